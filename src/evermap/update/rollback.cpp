// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <utility>

#include <evermap/update/detail/rollback.hpp>

namespace evermap {

void Rollback::begin_scan() {
  std::vector<BeforeImage> images;
  if (scans_.size() >= capacity_ && !scans_.empty()) {
    images.swap(scans_.front());  // for its memory
    images.clear();
    scans_.pop_front();
  }
  if (capacity_ > 0) scans_.push_back(std::move(images));
}

void Rollback::remember(VoxelKey key, const Leaf* leaf) {
  if (scans_.empty()) return;
  scans_.back().push_back({key, leaf != nullptr ? std::optional(*leaf) : std::nullopt});
}

void Rollback::roll_back(Octree& octree) {
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
