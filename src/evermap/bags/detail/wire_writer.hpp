// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include <evermap/bags/detail/wire_reader.hpp>

namespace evermap {

/// Serializes one message, as WireReader reads it.
class WireWriter {
 public:
  explicit WireWriter(Wire wire, std::endian order = std::endian::little);

  const std::string& bytes() const { return bytes_; }

  template <class T>
  WireWriter& number(T value) {
    align(sizeof(T));
    const auto* first = reinterpret_cast<const char*>(&value);
    bytes_.append(first, sizeof(T));
    if (order_ != std::endian::native) std::reverse(bytes_.end() - sizeof(T), bytes_.end());
    return *this;
  }
  WireWriter& text(std::string_view text);
  /// Bytes as they are.
  WireWriter& raw(std::string_view bytes);
  WireWriter& header(double time, std::string_view frame);  ///< [s] std_msgs/Header
  WireWriter& pose(const Pose& pose);                       ///< geometry_msgs/Pose or Transform

 private:
  void align(std::size_t size);

  Wire wire_;
  std::endian order_;
  std::string bytes_;
};

}  // namespace evermap
