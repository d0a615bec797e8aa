// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <evermap/files/detail/ply_reader.hpp>
#include <evermap/simulation/mesh_file.hpp>

namespace evermap {
namespace {

constexpr std::array<std::string_view, 2> kFaceNames = {"vertex_indices", "vertex_index"};

/// Where a property stands among those of its element.
std::optional<std::size_t> find(const PlyElement& element, std::string_view name) {
  const auto found = std::find_if(element.properties.begin(), element.properties.end(),
                                  [&](const PlyProperty& property) { return property.name == name; });
  if (found == element.properties.end()) return std::nullopt;
  return static_cast<std::size_t>(found - element.properties.begin());
}

void read_vertices(PlyReader& ply, const PlyElement& element, const InputFile& file, TriangleMesh& mesh) {
  std::array<std::size_t, 3> axes{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const char name = static_cast<char>('x' + axis);
    const auto place = find(element, {&name, 1});
    if (!place || element.properties[*place].list_count_type) file.fail("its vertices need x, y and z");
    axes[axis] = *place;
  }
  PlyRow row;
  for (std::uint64_t i = 0; i < element.count; ++i) {
    ply.read_row(element, row);
    mesh.vertices.emplace_back(row[axes[0]][0], row[axes[1]][0], row[axes[2]][0]);
    if (!mesh.vertices.back().allFinite()) file.fail("vertex " + std::to_string(i) + " is no point");
  }
}

void add_face(TriangleMesh& mesh, std::span<const double> corners, const InputFile& file) {
  for (const double corner : corners) {
    if (!(corner >= 0 && corner < static_cast<double>(mesh.vertices.size()))) {
      file.fail("a face names a vertex that there is not");
    }
  }
  const auto index = [&](std::size_t i) { return static_cast<std::uint32_t>(corners[i]); };
  for (std::size_t i = 2; i < corners.size(); ++i) {
    const Triangle3 triangle{mesh.vertices[index(0)], mesh.vertices[index(i - 1)], mesh.vertices[index(i)]};
    if (triangle.scaled_normal().norm() == 0) continue;  // without area, without surface
    mesh.triangles.push_back({index(0), index(i - 1), index(i)});
  }
}

void read_faces(PlyReader& ply, const PlyElement& element, std::size_t corners, const InputFile& file,
                TriangleMesh& mesh) {
  PlyRow row;
  for (std::uint64_t i = 0; i < element.count; ++i) {
    ply.read_row(element, row);
    add_face(mesh, row[corners], file);
  }
}

}  // namespace

TriangleMesh read_mesh(const std::filesystem::path& path) {
  const InputFile file(path);
  PlyReader ply(file);
  TriangleMesh mesh;
  for (const PlyElement& element : ply.elements()) {
    std::optional<std::size_t> corners;
    for (const std::string_view name : kFaceNames) corners = corners ? corners : find(element, name);
    if (element.name == "vertex") {
      read_vertices(ply, element, file, mesh);
    } else if (corners) {
      read_faces(ply, element, *corners, file, mesh);
    } else {
      ply.skip(element);
    }
  }
  if (mesh.triangles.empty()) file.fail("has no face");
  return mesh;
}

}  // namespace evermap
