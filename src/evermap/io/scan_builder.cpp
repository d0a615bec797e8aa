// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include <evermap/files/file_error.hpp>
#include <evermap/io/detail/scan_builder.hpp>

namespace evermap {
namespace {

constexpr std::array<std::string_view, 3> kAxisNames = {"x", "y", "z"};

std::string in_lower_case(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

}  // namespace

bool add_point(Scan& scan, const Eigen::Vector3d& p_sensor) {
  if (!p_sensor.allFinite()) {
    ++scan.dropped_not_finite;
  } else if (p_sensor.squaredNorm() == 0.0) {
    ++scan.dropped_at_origin;
  } else {
    scan.p_sensor.push_back(p_sensor);
    return true;
  }
  return false;
}

double farthest_coordinate(const Scan& scan) {
  double farthest = 0;
  for (const Eigen::Vector3d& p_sensor : scan.p_sensor)
    farthest = std::max(farthest, p_sensor.cwiseAbs().maxCoeff());
  return farthest;
}

ScanBuilder::ScanBuilder(std::filesystem::path file, const RecordLayout& layout)
    : file_(std::move(file)), layout_(layout) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Field* field = find(kAxisNames[axis]);
    if (field == nullptr) {
      throw FileError(file_, "has no field " + std::string(kAxisNames[axis]) + "; points need x, y and z");
    }
    position_[axis] = *field;
  }
  for (const std::string_view name : kTimeNames) {
    const Field* field = find(name);
    if (field == nullptr || field->name == "T") continue;  // which may be a temperature
    time_ = *field;
    break;
  }
}

/// A name in lower case means the same in upper case, unless the file has both.
const Field* ScanBuilder::find(std::string_view name) const {
  for (const bool as_written : {true, false}) {
    const Field* found = nullptr;
    for (const Field& field : layout_.fields()) {
      if ((as_written ? field.name : in_lower_case(field.name)) != name) continue;
      if (found != nullptr || field.count != 1) {
        throw FileError(
            file_, "has more than one value named " + std::string(name) + " per point; rename all but one");
      }
      found = &field;
    }
    if (found != nullptr) return found;
  }
  return nullptr;
}

void ScanBuilder::add_records(std::string_view bytes, std::size_t offset, std::uint64_t points,
                              std::endian order) {
  const std::size_t stride = layout_.stride();
  const std::uint64_t complete = bytes.size() / stride;
  if (points > complete) {
    throw FileError::at_byte(file_, offset + complete * stride,
                             "ends inside point " + std::to_string(complete) + " of " +
                                 std::to_string(points) +
                                 "; copy the file again or correct the number of points");
  }
  const auto column = [&](const Field& field) {
    return Column{bytes.data() + field.offset, stride, field.type};
  };
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
  is_text_ = true;
  scan_.p_sensor.reserve(points);
  std::vector<double> values;
  for (std::uint64_t i = 0; i < points; ++i) {
    if (!lines.next_filled()) {
      throw FileError::at_byte(file_, lines.offset(),
                               "ends after " + std::to_string(i) + " of " + std::to_string(points) +
                                   " points; copy the file again");
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
  if (!std::isfinite(time)) {
    ++scan_.dropped_not_finite;
  } else if (add_point(scan_, p_sensor) && time_) {
    times_.push_back(time);
  }
}

PointTime ScanBuilder::finish_times() {
  const auto [first, last] = std::minmax_element(times_.begin(), times_.end());
  const double unit = seconds_per_tick(time_->type, *last - *first);
  scan_.time_offset.reserve(times_.size());
  for (const double time : times_)
    scan_.time_offset.push_back(static_cast<float>(time * unit - *first * unit));
  return {time_->name, time_->type, unit, *first * unit, (*last - *first) * unit};
}

Scan ScanBuilder::finish(CloudNotes* notes) {
  std::optional<PointTime> time;
  if (!times_.empty()) time = finish_times();
  if (notes != nullptr) {
    notes->time = std::move(time);
    notes->farthest_coordinate = farthest_coordinate(scan_);
    const bool is_float32 =
        !is_text_ && std::any_of(position_.begin(), position_.end(),
                                 [](const Field& field) { return field.type == Scalar::kFloat32; });
    const auto farthest = static_cast<float>(notes->farthest_coordinate);
    notes->coordinate_step = is_float32 ? std::nextafter(farthest, INFINITY) - farthest : 0;
  }
  return std::move(scan_);
}

}  // namespace evermap
