// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>

#include <xxhash.h>
#include <zstd.h>

#include <evermap/history/detail/packed_changes.hpp>

namespace evermap {
namespace {

constexpr std::size_t kRecordSize = sizeof(std::uint64_t) + sizeof(Leaf);  // [bytes] key and leaf
using Record = std::array<char, kRecordSize>;

Record record_of(std::uint64_t key, const Leaf& leaf) {
  Record record;
  std::memcpy(record.data(), &key, sizeof(key));
  std::memcpy(record.data() + sizeof(key), static_cast<const void*>(&leaf), sizeof(leaf));
  return record;
}

std::uint64_t seal_of(std::string_view compressed, std::uint64_t owner) {
  return XXH3_64bits_withSeed(compressed.data(), compressed.size(), owner);
}

}  // namespace

// All first bytes of the records, then all second ones ...: signs and exponents are alike from leaf to leaf,
// keys grow by little.
std::string pack(std::span<const LeafChange> changes, std::uint64_t owner) {
  std::vector<Record> records;
  records.reserve(changes.size());
  std::uint64_t last = 0;
  for (const LeafChange& change : changes) {
    records.push_back(record_of(change.key.bits() - last, change.leaf));
    last = change.key.bits();
  }
  std::string plain;
  plain.reserve(records.size() * kRecordSize);
  for (std::size_t byte = 0; byte < kRecordSize; ++byte) {
    for (const Record& record : records) plain.push_back(record[byte]);
  }
  std::string packed(::ZSTD_compressBound(plain.size()), '\0');
  constexpr int kFast = 1;
  packed.resize(::ZSTD_compress(packed.data(), packed.size(), plain.data(), plain.size(), kFast));
  const std::uint64_t seal = seal_of(packed, owner);
  packed.append(reinterpret_cast<const char*>(&seal), sizeof(seal));
  return packed;
}

std::optional<std::vector<LeafChange>> unpack(std::string_view bytes, std::uint64_t owner) {
  std::uint64_t seal = 0;
  if (bytes.size() < sizeof(seal)) return std::nullopt;
  std::memcpy(&seal, bytes.data() + bytes.size() - sizeof(seal), sizeof(seal));
  bytes.remove_suffix(sizeof(seal));
  if (seal != seal_of(bytes, owner)) return std::nullopt;
  const unsigned long long size = ::ZSTD_getFrameContentSize(bytes.data(), bytes.size());
  if (size > kMostPacked * kRecordSize || size % kRecordSize != 0) return std::nullopt;
  std::string plain(size, '\0');
  if (::ZSTD_decompress(plain.data(), plain.size(), bytes.data(), bytes.size()) != size) return std::nullopt;
  std::vector<Record> records(size / kRecordSize);
  const char* next = plain.data();
  for (std::size_t byte = 0; byte < kRecordSize; ++byte) {
    for (Record& record : records) record[byte] = *next++;
  }
  std::vector<LeafChange> changes(records.size());
  std::uint64_t last = 0;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    std::uint64_t step = 0;
    std::memcpy(&step, records[i].data(), sizeof(step));
    std::memcpy(static_cast<void*>(&changes[i].leaf), records[i].data() + sizeof(step), sizeof(Leaf));
    last += step;
    changes[i].key = VoxelKey(last);
    if (!changes[i].leaf.is_finite() || changes[i].leaf.count < 0) return std::nullopt;
  }
  return changes;
}

std::string Fingerprint::hex() const {
  std::array<char, 33> text{};
  std::snprintf(text.data(), text.size(), "%016llx%016llx", static_cast<unsigned long long>(high),
                static_cast<unsigned long long>(low));
  return text.data();
}

Fingerprint fingerprint_of(const Octree& octree) {
  Fingerprint sum;
  octree.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
    const Record record = record_of(key.bits(), leaf);
    const XXH128_hash_t hash = XXH3_128bits(record.data(), record.size());
    sum.low += hash.low64;
    sum.high += hash.high64;
  });
  return sum;
}

}  // namespace evermap
