// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include <evermap/simulation/mesh_file.hpp>
#include <evermap/simulation/scenario.hpp>

namespace evermap {
namespace {

static_assert(std::endian::native == std::endian::little, "binary PLY files are read as they are");

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& message) {
  throw ScenarioError(path.string() + ": " + message);
}

struct Property {
  std::string name;
  std::string type;
  std::string count_type;  ///< of a list; empty for a single value
};
struct Element {
  std::string name;
  std::size_t rows;
  std::vector<Property> properties;
};

template <class Number>
double read_number(std::istream& in) {
  std::array<char, sizeof(Number)> bytes{};
  in.read(bytes.data(), bytes.size());
  return static_cast<double>(std::bit_cast<Number>(bytes));
}

/// Takes value after value from a PLY file.
class PlyStream {
 public:
  explicit PlyStream(const std::filesystem::path& path) : path_(path), in_(path, std::ios::binary) {
    if (!in_) fail(path, "No such file");
    read_header();
  }

  const std::vector<Element>& elements() const { return elements_; }

  double next(const std::string& type) {
    double value = 0;
    if (is_ascii_) {
      in_ >> value;
    } else {
      value = next_binary(type);
    }
    if (!in_) fail(path_, "ends too early, or holds something that is no number");
    return value;
  }

 private:
  void read_header() {
    std::string line;
    if (!std::getline(in_, line) || !line.starts_with("ply")) fail(path_, "is no PLY file");
    while (std::getline(in_, line)) {
      std::istringstream words(line);
      std::string word;
      words >> word;
      if (word == "end_header") return;
      read_header_line(word, words);
    }
    fail(path_, "its header has no end");
  }

  void read_header_line(const std::string& word, std::istringstream& words) {
    if (word == "format") {
      std::string format;
      words >> format;
      is_ascii_ = format == "ascii";
      if (!is_ascii_ && format != "binary_little_endian") fail(path_, "format " + format + " is not read");
    } else if (word == "element") {
      elements_.emplace_back();
      words >> elements_.back().name >> elements_.back().rows;
      if (!words) fail(path_, "an element of its header has no number of rows");
    } else if (word == "property") {
      if (elements_.empty()) fail(path_, "a property of its header belongs to no element");
      Property property;
      words >> property.type;
      if (property.type == "list") words >> property.count_type >> property.type;
      words >> property.name;
      elements_.back().properties.push_back(property);
    }
  }

  double next_binary(const std::string& type) {
    if (type == "float" || type == "float32") return read_number<float>(in_);
    if (type == "double" || type == "float64") return read_number<double>(in_);
    if (type == "char" || type == "int8") return read_number<std::int8_t>(in_);
    if (type == "uchar" || type == "uint8") return read_number<std::uint8_t>(in_);
    if (type == "short" || type == "int16") return read_number<std::int16_t>(in_);
    if (type == "ushort" || type == "uint16") return read_number<std::uint16_t>(in_);
    if (type == "int" || type == "int32") return read_number<std::int32_t>(in_);
    if (type == "uint" || type == "uint32") return read_number<std::uint32_t>(in_);
    fail(path_, "type " + type + " is not known");
  }

  std::filesystem::path path_;
  std::ifstream in_;
  bool is_ascii_ = true;
  std::vector<Element> elements_;
};

Eigen::Vector3d read_vertex(PlyStream& ply, const Element& element) {
  Eigen::Vector3d vertex = Eigen::Vector3d::Constant(NAN);
  for (const Property& property : element.properties) {
    const double value = ply.next(property.type);
    if (property.name == "x") vertex.x() = value;
    if (property.name == "y") vertex.y() = value;
    if (property.name == "z") vertex.z() = value;
  }
  return vertex;
}

std::vector<double> read_list(PlyStream& ply, const Property& property) {
  std::vector<double> values;
  const double count = property.count_type.empty() ? 1 : ply.next(property.count_type);
  while (static_cast<double>(values.size()) < count) values.push_back(ply.next(property.type));
  return values;
}

void add_face(TriangleMesh& mesh, const std::vector<double>& corners, const std::filesystem::path& path) {
  for (const double corner : corners) {
    if (!(corner >= 0 && corner < static_cast<double>(mesh.vertices.size()))) {
      fail(path, "a face names a vertex that there is not");
    }
  }
  const auto index = [&](std::size_t i) { return static_cast<std::uint32_t>(corners[i]); };
  for (std::size_t i = 2; i < corners.size(); ++i) {
    const Triangle3 triangle{mesh.vertices[index(0)], mesh.vertices[index(i - 1)], mesh.vertices[index(i)]};
    if (triangle.scaled_normal().norm() == 0) continue;  // without area, without surface
    mesh.triangles.push_back({index(0), index(i - 1), index(i)});
  }
}

}  // namespace

TriangleMesh read_mesh(const std::filesystem::path& path) {
  PlyStream ply(path);
  TriangleMesh mesh;
  for (const Element& element : ply.elements()) {
    if (element.properties.empty()) continue;
    for (std::size_t row = 0; row < element.rows; ++row) {
      if (element.name == "vertex") {
        mesh.vertices.push_back(read_vertex(ply, element));
        if (!mesh.vertices.back().allFinite()) fail(path, "a vertex is no point");
        continue;
      }
      for (const Property& property : element.properties) {
        const std::vector<double> values = read_list(ply, property);
        const bool is_face = property.name == "vertex_indices" || property.name == "vertex_index";
        if (is_face) add_face(mesh, values, path);
      }
    }
  }
  if (mesh.triangles.empty()) fail(path, "has no face");
  return mesh;
}

}  // namespace evermap
