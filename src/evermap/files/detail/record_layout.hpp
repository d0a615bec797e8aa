// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace evermap {

enum class Scalar : std::uint8_t {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat32,
  kFloat64
};

std::size_t size_of(Scalar type);  ///< [bytes]
std::string_view name_of(Scalar type);
inline bool is_floating(Scalar type) { return type == Scalar::kFloat32 || type == Scalar::kFloat64; }

/// The value of the given type whose bytes stand at `bytes` in the given order; integers beyond 2^53 are
/// rounded. REQUIRES: size_of(type) bytes are readable there; no alignment is.
double decode(const char* bytes, Scalar type, std::endian order);

/// A named part of a record: `count` values of one type.
struct Field {
  std::string name;
  Scalar type;
  std::size_t count;
  std::size_t offset;  ///< [bytes] from the start of the record
  std::size_t index;   ///< of its first value among all values of the record, for text
};

/// How one point stands in a file: the same description serves packed records, columns and lines of text.
///
/// Class invariant: fields follow each other without gaps, in bytes and in values.
class RecordLayout {
 public:
  static constexpr std::size_t kMaxStride = std::size_t{1} << 30;  ///< [bytes] keeps sums from overflowing

  /// Adds a field behind the others; false (and nothing added) when the record would exceed kMaxStride.
  [[nodiscard]] bool append(std::string name, Scalar type, std::size_t count);

  const std::vector<Field>& fields() const { return fields_; }
  std::size_t stride() const { return stride_; }            ///< [bytes] of one record
  std::size_t value_count() const { return value_count_; }  ///< of one record

 private:
  std::vector<Field> fields_;
  std::size_t stride_ = 0;
  std::size_t value_count_ = 0;
};

}  // namespace evermap
