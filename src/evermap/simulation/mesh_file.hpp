// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include <evermap/simulation/scene.hpp>

namespace evermap {

/// Reads vertices and faces of a PLY file (see PlyReader); faces of more than three corners
/// become fans of triangles. Throws FileError naming the file when it is missing, damaged or has no face.
TriangleMesh read_mesh(const std::filesystem::path& path);

}  // namespace evermap
