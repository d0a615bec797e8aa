// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

namespace evermap {

/// Makes this process the only one that changes a map, for as long as it lives: a file beside the map
/// (`map.evm.lock`) that says who. Released by the kernel when the process dies, however it does;
/// the next writer removes what a dead one left in the map's folder.
class MapLock {
 public:
  /// Waits up to `patience` [s] for another writer. Throws FileError naming the other when it is still there,
  /// or when the file cannot be made.
  explicit MapLock(const std::filesystem::path& map, double patience = 0);
  ~MapLock();
  MapLock(const MapLock&) = delete;
  MapLock& operator=(const MapLock&) = delete;

 private:
  bool try_lock();

  std::filesystem::path path_;
  int descriptor_ = -1;
};

}  // namespace evermap
