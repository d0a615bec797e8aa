// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include <evermap/files/detail/record_layout.hpp>
#include <evermap/files/detail/text_lines.hpp>
#include <evermap/io/detail/cloud_notes.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

/// Adds a point to a scan, or counts why it is none; whether it was added.
bool add_point(Scan& scan, const Eigen::Vector3d& p_sensor);

/// [m] The largest x, y or z of a scan, without its sign.
double farthest_coordinate(const Scan& scan);

/// Makes a Scan from the points of a file, whichever way they stand in it: what every reader shares.
///
/// Takes fields x, y, z [m] and the first of kTimeNames, in lower or upper case; see seconds_per_tick for the
/// unit of times. Points with a coordinate or time that is not finite, and points of zero range, are dropped
/// and counted. Keeps a reference to the file. Not thread safe.
class ScanBuilder {
 public:
  /// Throws FileError when x, y or z is missing or ambiguous.
  ScanBuilder(std::filesystem::path file, const RecordLayout& layout);

  /// Adds `points` records that stand one after the other in `bytes`, which the file has from byte `offset`
  /// on. Throws FileError at the first record that is not complete, before memory is taken for any.
  void add_records(std::string_view bytes, std::size_t offset, std::uint64_t points, std::endian order);

  /// Adds points of which all values of the first field stand in `bytes`, then all of the second, and so on.
  /// REQUIRES: bytes holds points * stride bytes, little endian.
  void add_columns(const char* bytes, std::size_t points);

  /// Adds the next `points` filled lines, one point each. Throws FileError at a line with another number of
  /// values and when there are too few lines.
  void add_lines(TextLines& lines, std::uint64_t points);

  /// The scan, with times counted from the earliest point; fills `notes`, when given. Call once, last.
  Scan finish(CloudNotes* notes = nullptr);

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
  /// Makes the scan's times of `times_`. REQUIRES: there are some.
  PointTime finish_times();

  std::filesystem::path file_;
  const RecordLayout& layout_;
  std::array<Field, 3> position_;
  std::optional<Field> time_;
  std::vector<double> times_;  ///< [ticks] of each point, counted from any moment
  bool is_text_ = false;       ///< numbers are as precise as they are written
  Scan scan_;
};

}  // namespace evermap
