// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <Eigen/Geometry>

#include <evermap/bags/detail/wire_writer.hpp>

namespace evermap {
namespace {

constexpr std::size_t kEncapsulation = 4;  ///< [bytes] of CDR, from behind which alignment counts

}  // namespace

WireWriter::WireWriter(Wire wire, std::endian order) : wire_(wire), order_(order) {
  if (wire_ == Wire::kCdr) bytes_ = {'\0', order_ == std::endian::little ? '\1' : '\0', '\0', '\0'};
}

void WireWriter::align(std::size_t size) {
  if (wire_ != Wire::kCdr) return;
  while ((bytes_.size() - kEncapsulation) % size != 0) bytes_ += '\0';
}

WireWriter& WireWriter::text(std::string_view text) {
  const bool has_end = wire_ == Wire::kCdr;
  number(static_cast<std::uint32_t>(text.size() + (has_end ? 1 : 0)));
  raw(text);
  if (has_end) bytes_ += '\0';
  return *this;
}

WireWriter& WireWriter::raw(std::string_view bytes) {
  bytes_ += bytes;
  return *this;
}

WireWriter& WireWriter::header(double time, std::string_view frame) {
  constexpr double kNanoseconds = 1e9;
  if (wire_ == Wire::kRos1) number<std::uint32_t>(0);  // a number of the message, which nobody uses
  auto seconds = static_cast<std::uint32_t>(std::floor(time));
  auto rest = static_cast<std::uint32_t>(std::llround((time - seconds) * kNanoseconds));
  if (rest == kNanoseconds) {
    ++seconds;
    rest = 0;
  }
  return number(seconds).number(rest).text(frame);
}

WireWriter& WireWriter::pose(const Pose& pose) {
  const Eigen::Quaterniond q(pose.rotation);
  for (const double value : pose.translation) number(value);
  for (const double value : {q.x(), q.y(), q.z(), q.w()}) number(value);
  return *this;
}

}  // namespace evermap
