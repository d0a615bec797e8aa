// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include <evermap/files/detail/input_file.hpp>
#include <evermap/files/detail/record_layout.hpp>
#include <evermap/io/detail/atomic_file.hpp>
#include <evermap/io/detail/las.hpp>
#include <evermap/io/detail/scan_builder.hpp>

namespace evermap {
namespace {

// Where the public header has what is needed here [bytes].
constexpr std::size_t kMajor = 24, kMinor = 25, kPointsAt = 96, kPointFormat = 104, kPointSize = 105;
constexpr std::size_t kSoftware = 58, kHeaderSize = 94, kCount32 = 107, kCountOfFirstReturns = 111,
                      kScale = 131;
constexpr std::size_t kOffset = 155, kExtent = 179, kCount64 = 247;
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

void write_las(const std::filesystem::path& path, const std::vector<Eigen::Vector3d>& points) {
  constexpr double kStep = 0.001;  // [m]
  Eigen::Vector3d least = Eigen::Vector3d::Zero();
  Eigen::Vector3d greatest = Eigen::Vector3d::Zero();
  if (!points.empty()) least = greatest = points.front();
  for (const Eigen::Vector3d& p : points) {
    least = least.cwiseMin(p);
    greatest = greatest.cwiseMax(p);
  }
  const Eigen::Vector3d offset = least.array().floor();
  constexpr double kReach = 2e6;  // [m]
  const bool fits =
      (greatest - least).maxCoeff() < kReach && points.size() <= std::numeric_limits<std::uint32_t>::max();
  if (!fits) throw FileError(path, "the map is too large for LAS; export it as .pcd or .ply");
  std::string header(kHeader, '\0');
  const auto put = [&](std::size_t at, const auto& value) {
    std::memcpy(header.data() + at, &value, sizeof(value));
  };
  std::memcpy(header.data(), "LASF", 4);
  put(kMajor, std::uint8_t{1});
  put(kMinor, std::uint8_t{2});
  std::memcpy(header.data() + kSoftware, "evermap", 7);
  put(kHeaderSize, static_cast<std::uint16_t>(kHeader));
  put(kPointsAt, static_cast<std::uint32_t>(kHeader));
  constexpr std::uint16_t kRecord = 20;
  put(kPointSize, kRecord);
  put(kCount32, static_cast<std::uint32_t>(points.size()));
  put(kCountOfFirstReturns, static_cast<std::uint32_t>(points.size()));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    put(kScale + 8 * axis, kStep);
    put(kOffset + 8 * axis, offset[i]);
    put(kExtent + 16 * axis, greatest[i]);
    put(kExtent + 16 * axis + 8, least[i]);
  }
  AtomicFile file(path);
  file.write(header);
  for (const Eigen::Vector3d& p : points) {
    std::array<char, kRecord> record{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<Eigen::Index>(axis);
      const auto steps = static_cast<std::int32_t>(std::llround((p[i] - offset[i]) / kStep));
      std::memcpy(record.data() + 4 * axis, &steps, sizeof(steps));
    }
    record[14] = 0b00'001'001;  // the first return of one
    file.write(record.data(), record.size());
  }
  file.commit();
}

}  // namespace evermap
