// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <string>

#include <evermap/files/detail/input_file.hpp>
#include <evermap/files/detail/record_layout.hpp>
#include <evermap/io/detail/las.hpp>
#include <evermap/io/detail/scan_builder.hpp>

namespace evermap {
namespace {

// Where the public header has what is needed here [bytes].
constexpr std::size_t kMajor = 24, kMinor = 25, kPointsAt = 96, kPointFormat = 104, kPointSize = 105;
constexpr std::size_t kCount32 = 107, kScale = 131, kOffset = 155, kCount64 = 247;
constexpr std::size_t kHeader = 227, kHeader14 = 375;

}  // namespace

Scan read_las(const std::filesystem::path& path, CloudNotes* notes) {
  const InputFile file(path);
  if (!file.bytes().starts_with("LASF")) file.fail("is no LAS file; it does not begin with LASF");
  const auto value = [&](std::size_t at, Scalar type) {
    return decode(file.bytes().data() + at, type, std::endian::little);
  };
  if (file.bytes().size() < kHeader) file.fail("ends inside its header; copy the file again");
  const bool is_14 = value(kMajor, Scalar::kUint8) == 1 && value(kMinor, Scalar::kUint8) >= 4;
  if (is_14 && file.bytes().size() < kHeader14) file.fail("ends inside its header; copy the file again");
  const auto format = static_cast<unsigned>(value(kPointFormat, Scalar::kUint8));
  constexpr unsigned kLastFormat = 10;
  if (format > kLastFormat) {  // LAZ sets the highest bits
    file.fail_at_byte(kPointFormat, "is compressed (LAZ); write it as LAS, by laszip or las2las");
  }
  const auto point_size = static_cast<std::size_t>(value(kPointSize, Scalar::kUint16));
  constexpr std::size_t kCoordinates = 12;  // [bytes] three int32
  if (point_size < kCoordinates) file.fail_at_byte(kPointSize, "a point has no room for x, y and z");
  const auto begin = static_cast<std::size_t>(value(kPointsAt, Scalar::kUint32));
  if (begin > file.bytes().size())
    file.fail_at_byte(kPointsAt, "its points lie behind its end; copy the file again");
  const double count_32 = value(kCount32, Scalar::kUint32);
  const double count = is_14 && count_32 == 0 ? value(kCount64, Scalar::kUint64) : count_32;
  const std::size_t complete = (file.bytes().size() - begin) / point_size;
  if (!(count <= static_cast<double>(complete))) {
    file.fail_at_byte(begin + complete * point_size,
                      "ends inside point " + std::to_string(complete) + "; copy the file again");
  }
  Eigen::Vector3d scale, offset;
  for (int axis = 0; axis < 3; ++axis) {
    scale[axis] = value(kScale + 8 * axis, Scalar::kFloat64);
    offset[axis] = value(kOffset + 8 * axis, Scalar::kFloat64);
  }
  Scan scan;
  const auto points = static_cast<std::size_t>(count);
  scan.p_sensor.reserve(points);
  for (std::size_t i = 0; i < points; ++i) {
    const std::size_t at = begin + i * point_size;
    const Eigen::Vector3d steps(value(at, Scalar::kInt32), value(at + 4, Scalar::kInt32),
                                value(at + 8, Scalar::kInt32));
    add_point(scan, steps.cwiseProduct(scale) + offset);
  }
  if (notes != nullptr) notes->farthest_coordinate = farthest_coordinate(scan);
  return scan;
}

}  // namespace evermap
