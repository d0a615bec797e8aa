// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <evermap/io/detail/cloud_notes.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

/// The extensions that read_cloud knows, for messages.
inline constexpr std::string_view kCloudExtensions =
    ".bin (KITTI), .pcd, .ply, .las, .npy, .xyz, .txt, .csv, and OctoMap's .bt and .ot, also with .gz";

/// What a user knows of a file better than the file says.
struct CloudOptions {
  /// The extension of its format, ".pcd", whatever the file's own; empty: its own tells.
  std::string format = {};
  std::optional<std::size_t> bin_fields = {};  ///< float32 values a point in a .bin file, see read_bin
  bool ignore_viewpoint = false;               ///< of a PCD file: the scan has no pose
};

/// The extension of `path`, less .gz and in lower case, when read_cloud knows it, none otherwise. Does not
/// look at the file.
std::optional<std::string_view> cloud_extension(const std::filesystem::path& path);

/// The extensions by themselves.
std::vector<std::string> cloud_extensions();

/// Whether read_cloud would read a text, which beside other files is mostly something else: times, or poses.
bool is_text_cloud(const std::filesystem::path& path);

/// Reads a point cloud or scan; the format follows from the extension (kCloudExtensions, any case), of what
/// is in it where that is .gz. Fills `notes`, when given, with what was taken for what. Throws FileError when
/// the file is missing, malformed or of another kind. Thread safe.
Scan read_cloud(const std::filesystem::path& path, const CloudOptions& options = {},
                CloudNotes* notes = nullptr);

/// Throws FileError when the coordinates of `path`, as its notes say, step by more than a tenth of a leaf's
/// edge [m]: far from the origin (UTM coordinates, say) float32 is too coarse for a map.
void check_coordinate_step(const std::filesystem::path& path, const CloudNotes& notes, double leaf);

}  // namespace evermap
