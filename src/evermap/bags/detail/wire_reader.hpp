// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

#include <Eigen/Core>

#include <evermap/geometry/pose.hpp>

namespace evermap {

/// How a bag's messages are serialized: as ROS 1 does (packed, little endian), or in CDR as ROS 2 does
/// (aligned, behind four bytes that tell the byte order).
enum class Wire { kRos1, kCdr };

/// Reads the values of one message from its front. What is read beyond the end, or makes no sense, is zero or
/// empty, and from then on is_good() is false: whoever reads asks once, at the end.
class WireReader {
 public:
  /// Keeps a view of the bytes.
  WireReader(std::string_view bytes, Wire wire);

  bool is_good() const { return is_good_; }
  Wire wire() const { return wire_; }
  std::endian order() const { return order_; }

  template <class T>
  T number() {
    align(sizeof(T));
    const std::string_view raw = take(sizeof(T));
    T value{};
    if (raw.size() != sizeof(T)) return value;
    if (order_ == std::endian::native) {
      std::memcpy(&value, raw.data(), sizeof(T));
    } else {
      for (std::size_t i = 0; i < sizeof(T); ++i)
        std::memcpy(reinterpret_cast<char*>(&value) + i, raw.data() + sizeof(T) - 1 - i, 1);
    }
    return value;
  }
  /// A string, without the zero that ends it in CDR.
  std::string_view text();
  /// The length of a sequence of elements that take `least_size` bytes or more each.
  std::uint32_t count(std::size_t least_size);
  /// `size` bytes as they are.
  std::string_view take(std::size_t size);
  /// Steps over `count` numbers of `size` bytes each.
  void skip(std::size_t count, std::size_t size);

  double stamp();            ///< [s] builtin_interfaces/Time
  Eigen::Vector3d vector();  ///< geometry_msgs/Vector3 or Point
  Pose pose();               ///< geometry_msgs/Pose or Transform; a rotation of norm 0 makes no sense

 private:
  void align(std::size_t size);

  std::string_view bytes_;
  std::size_t position_ = 0;
  std::size_t origin_ = 0;              ///< [bytes] where alignment counts from
  std::size_t greatest_alignment_ = 1;  ///< [bytes]
  Wire wire_;
  std::endian order_ = std::endian::little;
  bool is_good_ = true;
};

}  // namespace evermap
