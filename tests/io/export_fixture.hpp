// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <random>
#include <vector>

#include "files/file_fixture.hpp"
#include "support/random_octree.hpp"

namespace evermap {

/// A test with a map to export, and a folder for it.
class ExportTest : public FileTest {
 protected:
  ExportTest() : octree_(VoxelGrid{0.2}) {
    std::mt19937 generator(7);
    octree_ = random_octree(generator, 3000, VoxelGrid{0.2});
    octree_.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
      if (leaf.occupied()) occupied_.push_back(key);
    });
  }

  Octree octree_;
  std::vector<VoxelKey> occupied_;
};

}  // namespace evermap
