// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace evermap {

/// What is sound of a map and its versions.
struct MapVerdict {
  std::vector<std::string> damage;  ///< a line each: what, and where
  std::vector<int> sound_versions;  ///< that can be checked out
  int versions = 0;                 ///< in all
  bool is_map_sound = false;        ///< the map file

  bool is_sound() const { return damage.empty(); }
};

/// Reads a map and all its versions, and compares each with what was written. Throws FileError when there is
/// neither.
MapVerdict verify(const std::filesystem::path& map);

/// Makes a damaged map and its history sound again from what is left of both, and says what it did, a line
/// each. A damaged map file, or a history in which nothing can be read, stays as `.damaged`. Waits up to
/// `patience` [s] for another process that changes the map. Throws FileError when nothing can be saved.
std::vector<std::string> repair(const std::filesystem::path& map, double patience = 0);

}  // namespace evermap
