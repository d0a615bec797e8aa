// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include <evermap/io/scan_builder.hpp>

namespace evermap {
namespace {

constexpr std::array<std::string_view, 3> kAxisNames = {"x", "y", "z"};
constexpr std::array<std::string_view, 4> kTimeNames = {"t", "time", "timestamp", "offset_time"};
constexpr double kSecondsPerNanosecond = 1e-9;

}  // namespace

ScanBuilder::ScanBuilder(const InputFile& file, const RecordLayout& layout) : file_(file), layout_(layout) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Field* field = find(kAxisNames[axis]);
    if (field == nullptr) {
      file.fail("has no field " + std::string(kAxisNames[axis]) + "; points need x, y and z");
    }
    position_[axis] = *field;
  }
  for (const std::string_view name : kTimeNames) {
    const Field* field = find(name);
    if (field == nullptr) continue;
    time_ = *field;
    seconds_per_tick_ = is_floating(field->type) ? 1.0 : kSecondsPerNanosecond;
    break;
  }
}

const Field* ScanBuilder::find(std::string_view name) const {
  const Field* found = nullptr;
  for (const Field& field : layout_.fields()) {
    if (field.name != name) continue;
    if (found != nullptr || field.count != 1) {
      file_.fail("has more than one value named " + std::string(name) + " per point; rename all but one");
    }
    found = &field;
  }
  return found;
}

void ScanBuilder::add_records(std::size_t offset, std::uint64_t points, std::endian order) {
  const std::size_t stride = layout_.stride();
  const std::uint64_t complete = (file_.bytes().size() - offset) / stride;
  if (points > complete) {
    file_.fail_at_byte(offset + complete * stride,
                       "ends inside point " + std::to_string(complete) + " of " + std::to_string(points) +
                           "; copy the file again or correct the number of points");
  }
  const char* begin = file_.bytes().data() + offset;
  const auto column = [&](const Field& field) { return Column{begin + field.offset, stride, field.type}; };
  add_decoded({column(position_[kX]), column(position_[kY]), column(position_[kZ]),
               column(time_.value_or(position_[kX]))},
              points, order);
}

void ScanBuilder::add_columns(const char* bytes, std::size_t points) {
  const auto column = [&](const Field& field) {
    return Column{bytes + field.offset * points, field.count * size_of(field.type), field.type};
  };
  add_decoded({column(position_[kX]), column(position_[kY]), column(position_[kZ]),
               column(time_.value_or(position_[kX]))},
              points, std::endian::little);
}

void ScanBuilder::add_decoded(const std::array<Column, 4>& columns, std::size_t points, std::endian order) {
  scan_.p_sensor.reserve(points);
  if (time_) times_.reserve(points);
  const auto value = [&](Role role, std::size_t i) {
    const Column& column = columns[role];
    return decode(column.first + i * column.step, column.type, order);
  };
  for (std::size_t i = 0; i < points; ++i) {
    add({value(kX, i), value(kY, i), value(kZ, i)}, time_ ? value(kTime, i) : 0.0);
  }
}

void ScanBuilder::add_lines(TextLines& lines, std::uint64_t points) {
  // A value takes two bytes at least, itself and what ends it (which the last one may lack).
  const std::uint64_t possible = (lines.remaining() + 1) / (2 * layout_.value_count());
  if (points > possible) {
    lines.fail("the header promises " + std::to_string(points) +
               " points, the rest of the file has room for " + std::to_string(possible) +
               " at most; copy the file again or correct the number of points");
  }
  scan_.p_sensor.reserve(points);
  std::vector<double> values;
  for (std::uint64_t i = 0; i < points; ++i) {
    if (!lines.next_filled()) {
      file_.fail_at_byte(file_.bytes().size(), "ends after " + std::to_string(i) + " of " +
                                                   std::to_string(points) + " points; copy the file again");
    }
    lines.read_numbers(values);
    if (values.size() != layout_.value_count()) {
      lines.fail("has " + std::to_string(values.size()) + " values instead of " +
                 std::to_string(layout_.value_count()) + "; correct or remove the line");
    }
    const auto value = [&](Role role) { return values[position_[role].index]; };
    add({value(kX), value(kY), value(kZ)}, time_ ? values[time_->index] : 0.0);
  }
}

void ScanBuilder::add(const Eigen::Vector3d& p_sensor, double time) {
  if (!p_sensor.allFinite() || !std::isfinite(time)) {
    ++scan_.dropped_not_finite;
  } else if (p_sensor.squaredNorm() == 0.0) {
    ++scan_.dropped_at_origin;
  } else {
    scan_.p_sensor.push_back(p_sensor);
    if (time_) times_.push_back(time * seconds_per_tick_);
  }
}

Scan ScanBuilder::finish() {
  if (!times_.empty()) {
    const double first = *std::min_element(times_.begin(), times_.end());
    scan_.time_offset.reserve(times_.size());
    for (const double time : times_) scan_.time_offset.push_back(static_cast<float>(time - first));
  }
  return std::move(scan_);
}

}  // namespace evermap
