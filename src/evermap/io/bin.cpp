// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <evermap/io/detail/bin.hpp>
#include <evermap/io/detail/scan_builder.hpp>

namespace evermap {
namespace {

constexpr std::size_t kUsualFields = 4;
constexpr std::array<std::size_t, 4> kGuesses = {4, 3, 5, 6};
constexpr std::size_t kFewPoints = 100;

/// The mean logarithm of the columns' spreads when all values are dealt out to `fields` columns in turn. In
/// the true layout each column holds values of one kind; in any other the kinds are mixed, and a mixture is
/// spread wider than its parts are on average.
double disorder(const std::vector<float>& values, std::size_t fields) {
  constexpr double kLeastSpread = 1e-3;
  struct Column {
    double count = 0, sum = 0, squares = 0;
  };
  std::vector<Column> columns(fields);
  for (std::size_t begin = 0; begin + fields <= values.size(); begin += fields) {
    for (std::size_t i = 0; i < fields; ++i) {
      const double value = values[begin + i];
      columns[i].count += 1;
      columns[i].sum += value;
      columns[i].squares += value * value;
    }
  }
  double sum = 0;
  for (const Column& column : columns) {
    const double mean = column.sum / column.count;
    const double variance = std::max(column.squares / column.count - mean * mean, 0.0);
    sum += std::log(std::sqrt(variance) + kLeastSpread);
  }
  return sum / static_cast<double>(fields);
}

/// All values, such that no stray one outweighs the others.
std::vector<float> bounded_values(const InputFile& file) {
  constexpr float kReach = 300;  // [m] of a LiDAR
  std::vector<float> values(file.bytes().size() / sizeof(float));
  for (std::size_t i = 0; i < values.size(); ++i) {
    const char* bytes = file.bytes().data() + i * sizeof(float);
    const auto value = static_cast<float>(decode(bytes, Scalar::kFloat32, std::endian::little));
    values[i] = std::isfinite(value) ? std::clamp(value, -kReach, kReach) : 0;
  }
  return values;
}

std::size_t guess_fields(const InputFile& file) {
  constexpr double kClear = 0.1;  // a tenth of the spread; true layouts win by ten times as much
  const std::vector<float> values = bounded_values(file);
  const bool is_one_value =
      std::adjacent_find(values.begin(), values.end(), std::not_equal_to<>()) == values.end();
  if (values.size() < kUsualFields * kFewPoints || is_one_value) return kUsualFields;
  std::size_t best = 0;
  double least = INFINITY;
  double second = INFINITY;
  for (const std::size_t fields : kGuesses) {
    const double now = disorder(values, fields);
    // Two points of three values make one of six just as orderly: more values must be worth it.
    const bool is_multiple = best != 0 && fields % best == 0;
    if (now < least - (is_multiple ? kClear : 0)) {
      second = std::exchange(least, now);
      best = fields;
    } else if (!is_multiple) {
      second = std::min(second, now);
    }
  }
  if (second - least < kClear) {
    file.fail("does not show how many float32 values a point has; say it with --bin-fields");
  }
  return best;
}

}  // namespace

Scan read_bin(const std::filesystem::path& path, std::optional<std::size_t> fields, CloudNotes* notes) {
  const InputFile file(path);
  const std::size_t count = fields ? *fields : guess_fields(file);
  const std::size_t point_size = count * sizeof(float);
  RecordLayout layout;
  for (const char* name : {"x", "y", "z"}) {
    if (!layout.append(name, Scalar::kFloat32, 1)) file.fail("cannot be read as points");
  }
  const bool is_layout = count >= kLeastBinFields && count <= kMostBinFields &&
                         (count == 3 || layout.append("other", Scalar::kFloat32, count - 3));
  if (!is_layout) file.fail("a point has 3 to 64 values, not " + std::to_string(count));
  const std::size_t incomplete = file.bytes().size() % point_size;
  if (incomplete != 0) {
    file.fail_at_byte(
        file.bytes().size() - incomplete,
        "the last point has " + std::to_string(incomplete) + " of " + std::to_string(point_size) +
            " bytes; copy the file again, or say with --bin-fields how many values a point has");
  }
  ScanBuilder builder(path, layout);
  builder.add_records(file.bytes(), 0, file.bytes().size() / point_size, std::endian::little);
  Scan scan = builder.finish(notes);
  if (notes != nullptr) notes->bin_fields = count;
  return scan;
}

}  // namespace evermap
