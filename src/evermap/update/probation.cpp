// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <evermap/update/probation.hpp>

namespace evermap {

void Probation::begin_scan() {
  scans_.emplace_back();
  if (scans_.size() > capacity_) scans_.pop_front();
}

void Probation::remember(const Octree& octree, VoxelKey key) {
  if (scans_.empty()) return;
  const Leaf* leaf = octree.find(key);
  scans_.back().push_back({key, leaf != nullptr ? std::optional(*leaf) : std::nullopt});
}

void Probation::take_back(Octree& octree) {
  // Backwards, so that a leaf changed more than once ends as it was first.
  for (auto scan = scans_.rbegin(); scan != scans_.rend(); ++scan) {
    for (auto image = scan->rbegin(); image != scan->rend(); ++image) {
      if (image->leaf) {
        octree.find_or_insert(image->key) = *image->leaf;
      } else {
        octree.erase(image->key);
      }
    }
  }
  scans_.clear();
}

}  // namespace evermap
