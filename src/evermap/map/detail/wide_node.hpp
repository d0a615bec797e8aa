// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <evermap/map/detail/shared_array.hpp>

namespace evermap {

/// A set of positions in 8 x 8 x 8: bit i of word i / 64 stands for i = z << 6 | y << 3 | x.
class Mask512 {
 public:
  bool has(int index) const { return words_[word(index)] >> (index & 63) & 1; }
  void set(int index) { words_[word(index)] |= std::uint64_t{1} << (index & 63); }
  void reset(int index) { words_[word(index)] &= ~(std::uint64_t{1} << (index & 63)); }
  std::uint64_t layer(int z) const { return words_[static_cast<std::size_t>(z)]; }
  bool empty() const {
    return std::all_of(words_.begin(), words_.end(), [](std::uint64_t layer) { return layer == 0; });
  }

  /// The least box of positions around all that are set. REQUIRES: there are some.
  Eigen::AlignedBox3i bounds() const {
    std::uint64_t slice = 0;  // all layers seen from above: bit y << 3 | x
    int bottom = 8;
    int top = 0;
    for (int z = 0; z < 8; ++z) {
      if (layer(z) == 0) continue;
      slice |= layer(z);
      bottom = std::min(bottom, z);
      top = z;
    }
    std::uint64_t row = slice | slice >> 32;
    row |= row >> 16;
    row = (row | row >> 8) & 0xFF;
    return {Eigen::Vector3i(std::countr_zero(row), std::countr_zero(slice) / 8, bottom),
            Eigen::Vector3i(63 - std::countl_zero(row), (63 - std::countl_zero(slice)) / 8, top)};
  }

 private:
  static std::size_t word(int index) { return static_cast<std::size_t>(index) >> 6; }

  std::array<std::uint64_t, 8> words_{};
};

/// Three levels of an octree folded into one node: up to 512 children, of which only the existing ones are
/// stored, packed in the order of their index.
///
///   mask   8 x 64 bit   which children exist
///   rank   8 x 16 bit   children below each layer, so that a child is found by one popcount
///   items  children in the order of set bits
///
/// Copies share their children until one of them changes some (see SharedArray).
///
/// Class invariant: rank[z] = popcount of the layers below z; items.size() = popcount of the whole mask.
template <class Child>
class WideNode {
 public:
  static constexpr int kChildren = 512;

  WideNode() = default;
  /// REQUIRES: as many children as `mask` has positions, in the order of these.
  WideNode(const Mask512& mask, std::vector<Child> children) : mask_(mask), items_(std::move(children)) {
    update_ranks();
  }

  const Child* find(int index) const { return has(index) ? &items_[position(index)] : nullptr; }
  Child* find(int index) { return has(index) ? &items_.own(position(index)) : nullptr; }
  bool has(int index) const { return mask_.has(index); }
  const Mask512& mask() const { return mask_; }

  Child& find_or_insert(int index) {
    const std::size_t at = position(index);
    if (has(index)) return items_.own(at);
    mask_.set(index);
    update_ranks();
    return items_.insert(at);
  }

  void erase(int index) {
    if (!has(index)) return;
    items_.erase(position(index));
    mask_.reset(index);
    update_ranks();
  }

  /// Makes all children this node's own, so that `find` changes nothing but the child.
  void own() {
    if (!empty()) items_.own(0);
  }

  bool empty() const { return items_.empty(); }
  std::size_t size() const { return items_.size(); }
  std::size_t capacity() const { return items_.capacity(); }

  /// Calls visit(index, child) in the order of indices.
  template <class Visit>
  void for_each(Visit&& visit) const {
    const Child* item = items_.data();
    for (int z = 0; z < 8; ++z) {
      for (std::uint64_t bits = mask_.layer(z); bits != 0; bits &= bits - 1) {
        visit(64 * z + std::countr_zero(bits), *item++);
      }
    }
  }

  /// Calls visit(index, child of a, child of b), in the order of indices, where a or b has a child (the
  /// other's is then nullptr), unless a and b still share their children.
  template <class Visit>
  static void for_each_pair(const WideNode& a, const WideNode& b, Visit&& visit) {
    const Child* of_a = a.items_.data();
    const Child* of_b = b.items_.data();
    if (of_a == of_b) return;
    for (int z = 0; z < 8; ++z) {
      const std::uint64_t in_a = a.mask_.layer(z);
      const std::uint64_t in_b = b.mask_.layer(z);
      for (std::uint64_t bits = in_a | in_b; bits != 0; bits &= bits - 1) {
        const std::uint64_t bit = bits & -bits;
        visit(64 * z + std::countr_zero(bits), (in_a & bit) != 0 ? of_a++ : nullptr,
              (in_b & bit) != 0 ? of_b++ : nullptr);
      }
    }
  }

 private:
  std::size_t position(int index) const {
    const std::uint64_t below = mask_.layer(index >> 6) & ((std::uint64_t{1} << (index & 63)) - 1);
    return rank_[static_cast<std::size_t>(index) >> 6] + static_cast<std::size_t>(std::popcount(below));
  }

  void update_ranks() {
    for (int z = 1; z < 8; ++z) {
      const auto at = static_cast<std::size_t>(z);
      rank_[at] = static_cast<std::uint16_t>(rank_[at - 1] + std::popcount(mask_.layer(z - 1)));
    }
  }

  Mask512 mask_;
  std::array<std::uint16_t, 8> rank_{};
  SharedArray<Child> items_;
};

}  // namespace evermap
