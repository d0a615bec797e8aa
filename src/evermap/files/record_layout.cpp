// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include <evermap/files/detail/record_layout.hpp>

namespace evermap {
namespace {

template <typename T>
double decode_as(const char* bytes, std::endian order) {
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), bytes, sizeof(T));
  if (order != std::endian::native) std::reverse(raw.begin(), raw.end());
  return static_cast<double>(std::bit_cast<T>(raw));
}

}  // namespace

std::size_t size_of(Scalar type) {
  constexpr std::array<std::size_t, 10> kSizes = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

std::string_view name_of(Scalar type) {
  constexpr std::array<std::string_view, 10> kNames = {"int8",   "uint8", "int16",  "uint16",  "int32",
                                                       "uint32", "int64", "uint64", "float32", "float64"};
  return kNames[static_cast<std::size_t>(type)];
}

double decode(const char* bytes, Scalar type, std::endian order) {
  switch (type) {
    case Scalar::kInt8:
      return decode_as<std::int8_t>(bytes, order);
    case Scalar::kUint8:
      return decode_as<std::uint8_t>(bytes, order);
    case Scalar::kInt16:
      return decode_as<std::int16_t>(bytes, order);
    case Scalar::kUint16:
      return decode_as<std::uint16_t>(bytes, order);
    case Scalar::kInt32:
      return decode_as<std::int32_t>(bytes, order);
    case Scalar::kUint32:
      return decode_as<std::uint32_t>(bytes, order);
    case Scalar::kInt64:
      return decode_as<std::int64_t>(bytes, order);
    case Scalar::kUint64:
      return decode_as<std::uint64_t>(bytes, order);
    case Scalar::kFloat32:
      return decode_as<float>(bytes, order);
    case Scalar::kFloat64:
      return decode_as<double>(bytes, order);
  }
  __builtin_unreachable();
}

bool RecordLayout::append(std::string name, Scalar type, std::size_t count) {
  if (count > (kMaxStride - stride_) / size_of(type)) return false;
  fields_.push_back({std::move(name), type, count, stride_, value_count_});
  stride_ += count * size_of(type);
  value_count_ += count;
  return true;
}

}  // namespace evermap
