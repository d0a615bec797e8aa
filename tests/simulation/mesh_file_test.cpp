// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "files/file_fixture.hpp"
#include <evermap/simulation/mesh_file.hpp>
#include <evermap/simulation/scenario.hpp>

namespace evermap {
namespace {

const std::string kHeader =
    "comment of someone\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
const std::string kAscii = "ply\nformat ascii 1.0\n" + kHeader + "0 0 0\n2 0 0\n2 1 0\n0 1 0.5\n4 0 1 2 3\n";

class MeshFile : public FileTest {
 protected:
  void expect_refused(const std::string& bytes, const std::string& text) const {
    const std::filesystem::path file = make("mesh.ply", bytes);
    try {
      read_mesh(file);
      ADD_FAILURE() << "no error: " << text;
    } catch (const FileError& error) {
      const std::string what = error.what();
      EXPECT_TRUE(what.starts_with(file.string() + ": ")) << what;
      EXPECT_NE(what.find(text), std::string::npos) << what << " lacks: " << text;
    }
  }
};

void expect_is_the_quad(const TriangleMesh& mesh) {
  ASSERT_EQ(mesh.vertices.size(), 4u);
  EXPECT_EQ(mesh.vertices[3], Eigen::Vector3d(0, 1, 0.5));
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.triangles[0], (std::array<std::uint32_t, 3>{0, 1, 2}));
  EXPECT_EQ(mesh.triangles[1], (std::array<std::uint32_t, 3>{0, 2, 3}));
}

TEST_F(MeshFile, ReadsText) { expect_is_the_quad(read_mesh(make("mesh.ply", kAscii))); }

TEST_F(MeshFile, ReadsBytes) {
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    const std::string name = order == std::endian::little ? "little" : "big";
    const std::string bytes = "ply\nformat binary_" + name + "_endian 1.0\n" + kHeader +
                              bytes_of<float>({0, 0, 0, 2, 0, 0, 2, 1, 0, 0, 1, 0.5F}, order) + '\4' +
                              bytes_of<std::int32_t>({0, 1, 2, 3}, order);
    expect_is_the_quad(read_mesh(make("mesh.ply", bytes)));
  }
}

TEST_F(MeshFile, LeavesOutTrianglesWithoutArea) {
  std::string text = kAscii;
  text.replace(text.find("2 1 0"), 5, "1 0 0");
  EXPECT_EQ(read_mesh(make("mesh.ply", text)).triangles.size(), 1u);
}

TEST_F(MeshFile, RefusesDamage) {
  EXPECT_THROW(read_mesh(path("none.ply")), FileError);
  expect_refused("pcd", "is this a PLY file?");
  expect_refused("ply\nformat ascii 1.0\n", "ends before the end_header");
  expect_refused(kAscii.substr(0, kAscii.size() - 4), "another length than it says");
  expect_refused(kAscii.substr(0, kAscii.size() - 10), "ends inside the data of element 'face'");
  std::string text = kAscii;
  text.replace(text.find("4 0 1"), 5, "4 0 9");
  expect_refused(text, "a vertex that there is not");
  text = kAscii;
  text.replace(text.find("2 1 0"), 5, "2 x 0");
  expect_refused(text, "no number");
  text = kAscii;
  text.replace(text.find("0 1 0.5"), 7, "0 1 nan");
  expect_refused(text, "vertex 3 is no point");
  text = kAscii;
  text.replace(text.find("float z"), 7, "float w");
  expect_refused(text, "need x, y and z");
  text = kAscii.substr(0, kAscii.find("element face")) + "end_header\n0 0 0\n2 0 0\n2 1 0\n0 1 0.5\n";
  expect_refused(text, "has no face");
}

}  // namespace
}  // namespace evermap
