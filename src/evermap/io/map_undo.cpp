// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <system_error>

#include <evermap/files/file_error.hpp>
#include <evermap/io/detail/map_undo.hpp>
#include <evermap/io/map_file.hpp>

namespace evermap {

std::filesystem::path undo_path(const std::filesystem::path& map) {
  std::filesystem::path path = map;
  return path += ".undo";
}

void keep_for_undo(const std::filesystem::path& map) {
  std::error_code error;
  const std::filesystem::path target = std::filesystem::canonical(map, error);  // the file behind links
  if (error == std::errc::no_such_file_or_directory) return;
  if (error) throw FileError(map, "cannot be kept for undo: " + error.message());
  std::filesystem::path temporary = undo_path(map);
  temporary += ".tmp";
  std::filesystem::remove(temporary, error);
  std::filesystem::create_hard_link(target, temporary, error);
  if (error) {
    error.clear();
    std::filesystem::copy_file(target, temporary, error);  // a file system without hard links
  }
  if (!error) std::filesystem::rename(temporary, undo_path(map), error);
  if (error) throw FileError(undo_path(map), "the map cannot be kept for undo: " + error.message());
}

void undo_map(const std::filesystem::path& map) {
  const std::filesystem::path kept = undo_path(map);
  std::error_code error;
  if (!std::filesystem::exists(kept, error)) {
    throw FileError(kept, "no map was kept here; update and localize keep one with --undo-log");
  }
  load_map(kept);  // a damaged map must not replace a good one
  const std::filesystem::path target = std::filesystem::weakly_canonical(map, error);
  if (!error) std::filesystem::rename(kept, target, error);
  if (error) throw FileError(map, "cannot be brought back: " + error.message());
}

}  // namespace evermap
