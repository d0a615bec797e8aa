// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace evermap {

/// Three levels of an octree folded into one node: up to 512 children, of which only the existing ones are
/// stored, packed in the order of their index.
///
///   mask   8 x 64 bit   bit i of word i / 64 is set when child i exists
///   rank   8 x 16 bit   children before each word, so that a child is found by one popcount
///   items  children in the order of set bits
///
/// Class invariant: rank[w] = popcount of mask[0..w-1]; items.size() = popcount of the whole mask.
template <class Child>
class WideNode {
 public:
  static constexpr int kChildren = 512;

  const Child* find(int index) const { return has(index) ? &items_[position(index)] : nullptr; }
  Child* find(int index) { return has(index) ? &items_[position(index)] : nullptr; }
  bool has(int index) const { return mask_[word(index)] >> (index & 63) & 1; }

  Child& find_or_insert(int index) {
    const std::size_t at = position(index);
    if (has(index)) return items_[at];
    mask_[word(index)] |= std::uint64_t{1} << (index & 63);
    update_ranks();
    // Grown by a quarter, not doubled: most of a map's memory is here.
    if (items_.size() == items_.capacity()) items_.reserve(items_.size() + 1 + items_.size() / 4);
    return *items_.insert(items_.begin() + static_cast<std::ptrdiff_t>(at), Child{});
  }

  void erase(int index) {
    if (!has(index)) return;
    items_.erase(items_.begin() + static_cast<std::ptrdiff_t>(position(index)));
    mask_[word(index)] &= ~(std::uint64_t{1} << (index & 63));
    update_ranks();
  }

  bool empty() const { return items_.empty(); }
  std::size_t size() const { return items_.size(); }
  std::size_t capacity() const { return items_.capacity(); }

  /// The least box of positions (x, y, z) in [0, 8)^3 around all children, whose index is z << 6 | y << 3 |
  /// x. REQUIRES: there are some.
  Eigen::AlignedBox3i bounds() const {
    std::uint64_t slice = 0;  // all layers seen from above: bit y << 3 | x
    int bottom = 8;
    int top = 0;
    for (int z = 0; z < 8; ++z) {
      const std::uint64_t layer = mask_[static_cast<std::size_t>(z)];
      if (layer == 0) continue;
      slice |= layer;
      bottom = std::min(bottom, z);
      top = z;
    }
    std::uint64_t row = slice | slice >> 32;
    row |= row >> 16;
    row = (row | row >> 8) & 0xFF;
    return {Eigen::Vector3i(std::countr_zero(row), std::countr_zero(slice) / 8, bottom),
            Eigen::Vector3i(63 - std::countl_zero(row), (63 - std::countl_zero(slice)) / 8, top)};
  }

  /// Calls visit(index, child) in the order of indices.
  template <class Visit>
  void for_each(Visit&& visit) const {
    auto item = items_.begin();
    for (int w = 0; w < 8; ++w) {
      for (std::uint64_t bits = mask_[static_cast<std::size_t>(w)]; bits != 0; bits &= bits - 1) {
        visit(64 * w + std::countr_zero(bits), *item++);
      }
    }
  }

 private:
  static std::size_t word(int index) { return static_cast<std::size_t>(index) >> 6; }

  std::size_t position(int index) const {
    const std::uint64_t below = mask_[word(index)] & ((std::uint64_t{1} << (index & 63)) - 1);
    return rank_[word(index)] + static_cast<std::size_t>(std::popcount(below));
  }

  void update_ranks() {
    for (std::size_t w = 1; w < 8; ++w) {
      rank_[w] = static_cast<std::uint16_t>(rank_[w - 1] + std::popcount(mask_[w - 1]));
    }
  }

  std::array<std::uint64_t, 8> mask_{};
  std::array<std::uint16_t, 8> rank_{};
  std::vector<Child> items_;
};

}  // namespace evermap
