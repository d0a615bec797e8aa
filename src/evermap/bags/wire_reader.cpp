// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <optional>

#include <evermap/bags/detail/wire_reader.hpp>
#include <evermap/io/detail/quaternion.hpp>

namespace evermap {

WireReader::WireReader(std::string_view bytes, Wire wire) : bytes_(bytes), wire_(wire) {
  if (wire_ == Wire::kRos1) return;
  constexpr std::size_t kEncapsulation = 4;  // [bytes]
  const std::string_view head = take(kEncapsulation);
  if (!is_good_) return;
  origin_ = kEncapsulation;
  const int kind = static_cast<unsigned char>(head[1]);
  // CDR of either version, plain: 0 and 1, 6 and 7. The lists of parameters between them hold no ROS message.
  is_good_ = head[0] == 0 && (kind <= 1 || kind == 6 || kind == 7);
  order_ = kind % 2 == 1 ? std::endian::little : std::endian::big;
  greatest_alignment_ = kind <= 1 ? 8 : 4;
}

void WireReader::align(std::size_t size) {
  const std::size_t step = std::min(size, greatest_alignment_);
  const std::size_t beyond = (position_ - origin_) % step;
  if (beyond != 0) take(step - beyond);
}

std::string_view WireReader::take(std::size_t size) {
  if (!is_good_ || size > bytes_.size() - position_) {
    is_good_ = false;
    return {};
  }
  const std::string_view taken = bytes_.substr(position_, size);
  position_ += size;
  return taken;
}

void WireReader::skip(std::size_t count, std::size_t size) {
  align(size);
  take(count * size);
}

std::string_view WireReader::text() {
  std::string_view text = take(number<std::uint32_t>());
  if (wire_ == Wire::kCdr && text.ends_with('\0')) text.remove_suffix(1);
  return text;
}

std::uint32_t WireReader::count(std::size_t least_size) {
  const auto count = number<std::uint32_t>();
  if (count > (bytes_.size() - position_) / least_size) is_good_ = false;
  return is_good_ ? count : 0;
}

double WireReader::stamp() {
  // ROS 1 counts seconds without a sign, ROS 2 with one; they differ from 2038 on.
  const auto seconds = number<std::uint32_t>();
  const auto nanoseconds = number<std::uint32_t>();
  return static_cast<double>(seconds) + 1e-9 * static_cast<double>(nanoseconds);
}

Eigen::Vector3d WireReader::vector() {
  const auto x = number<double>();
  const auto y = number<double>();
  return {x, y, number<double>()};
}

Pose WireReader::pose() {
  const Eigen::Vector3d translation = vector();
  const Eigen::Vector3d axis = vector();
  const auto w = number<double>();
  const std::optional<Eigen::Matrix3d> rotation =
      rotation_from_file(Eigen::Quaterniond(w, axis.x(), axis.y(), axis.z()));
  if (!rotation || !translation.allFinite()) {
    is_good_ = false;
    return {};
  }
  return {*rotation, translation};
}

}  // namespace evermap
