// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <evermap/files/input_file.hpp>
#include <evermap/files/record_layout.hpp>
#include <evermap/files/text_lines.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

/// Makes a Scan from the points of a file, whichever way they stand in it: what every reader shares.
///
/// Takes fields x, y, z [m] and the first of t, time, timestamp, offset_time: nanoseconds when it is of an
/// integer type (as of Ouster and Livox), seconds when floating (Velodyne, Hesai). Points with a coordinate
/// or time that is not finite, and points of zero range, are dropped and counted. Keeps a reference to the
/// file. Not thread safe.
class ScanBuilder {
 public:
  /// Throws FileError when x, y or z is missing or ambiguous.
  ScanBuilder(const InputFile& file, const RecordLayout& layout);

  /// Adds `points` records that stand one after the other in the file from byte `offset` on. Throws FileError
  /// at the first record that is not complete, before memory is taken for any.
  void add_records(std::size_t offset, std::uint64_t points, std::endian order);

  /// Adds points of which all values of the first field stand in `bytes`, then all of the second, and so on.
  /// REQUIRES: bytes holds points * stride bytes, little endian.
  void add_columns(const char* bytes, std::size_t points);

  /// Adds the next `points` filled lines, one point each. Throws FileError at a line with another number of
  /// values and when there are too few lines.
  void add_lines(TextLines& lines, std::uint64_t points);

  /// The scan, with times counted from the earliest point. Call once, last.
  Scan finish();

 private:
  enum Role : std::size_t { kX, kY, kZ, kTime };
  /// Where the values of one role stand: the first at `first`, each next one `step` bytes further.
  struct Column {
    const char* first;
    std::size_t step;
    Scalar type;
  };

  const Field* find(std::string_view name) const;
  void add_decoded(const std::array<Column, 4>& columns, std::size_t points, std::endian order);
  void add(const Eigen::Vector3d& p_sensor, double time);

  const InputFile& file_;
  const RecordLayout& layout_;
  std::array<Field, 3> position_;
  std::optional<Field> time_;
  double seconds_per_tick_ = 1.0;
  std::vector<double> times_;  ///< [s] of each point, counted from any moment
  Scan scan_;
};

}  // namespace evermap
