// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <evermap/map/detail/leaf_changes.hpp>

namespace evermap {

/// Changes as bytes, compressed, and sealed with what they belong to: none of another `owner` are taken for
/// them. REQUIRES: at most kMostPacked.
constexpr std::size_t kMostPacked = 16384;
std::string pack(std::span<const LeafChange> changes, std::uint64_t owner);

/// None when a bit differs from what pack() made for this owner.
std::optional<std::vector<LeafChange>> unpack(std::string_view bytes, std::uint64_t owner);

/// 128 bits that tell maps apart, whatever order their leaves come in.
struct Fingerprint {
  std::uint64_t low = 0;
  std::uint64_t high = 0;

  std::string hex() const;
  friend bool operator==(const Fingerprint&, const Fingerprint&) = default;
};
Fingerprint fingerprint_of(const Octree& octree);

}  // namespace evermap
