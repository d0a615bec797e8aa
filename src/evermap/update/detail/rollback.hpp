// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include <evermap/map/octree.hpp>

namespace evermap {

/// Remembers what the last scans changed, so that it can be undone, bit for bit: a run of wrong poses that is
/// found out late does no harm.
///
/// Class invariant: a scan's images are those of before its own changes. Not thread safe.
class Rollback {
 public:
  /// `scans`: how many are held; 0 holds none.
  explicit Rollback(std::size_t scans) : capacity_(scans) {}

  /// Begins a scan: the oldest becomes final when there are too many.
  void begin_scan();
  /// Keeps the leaf of this voxel as it is now, or that there is none (nullptr). REQUIRES: begin_scan() was
  /// called.
  void remember(VoxelKey key, const Leaf* leaf);

  std::size_t scans() const { return scans_.size(); }

  /// Makes the map what it was before the oldest scan held, and holds none. REQUIRES: since then, the map was
  /// changed only at leaves that were remembered.
  void roll_back(Octree& octree);

 private:
  struct BeforeImage {
    VoxelKey key;
    std::optional<Leaf> leaf;  ///< none: there was no leaf
  };

  std::size_t capacity_;
  std::deque<std::vector<BeforeImage>> scans_;  ///< the newest last
};

}  // namespace evermap
