// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "files/file_fixture.hpp"
#include <evermap/files/detail/ply_reader.hpp>

namespace evermap {
namespace {

const std::string kElements =
    "element camera 2\nproperty double focus\nproperty uchar id\n"
    "element strip 2\nproperty list uchar int a\nproperty short b\nproperty list ushort float c\n"
    "element nothing 1000000000000\nend_header\n";

std::vector<double> values(const PlyRow& row, std::size_t property) {
  return {row[property].begin(), row[property].end()};
}

class PlyReaderTest : public FileTest {
 protected:
  static std::string text() {
    return "ply\nformat ascii 1.0\n" + kElements + "0.5 1\n0.25 2\n2 10 -20 3 1 0.5\n0 4 2 1 2\n";
  }
  static std::string binary(std::endian order) {
    const std::string name = order == std::endian::little ? "little" : "big";
    return "ply\nformat binary_" + name + "_endian 1.0\n" + kElements + bytes_of<double>({0.5}, order) +
           "\1" + bytes_of<double>({0.25}, order) + "\2" + "\2" + bytes_of<std::int32_t>({10, -20}, order) +
           bytes_of<std::int16_t>({3}, order) + bytes_of<std::uint16_t>({1}, order) +
           bytes_of<float>({0.5F}, order) + std::string(1, '\0') + bytes_of<std::int16_t>({4}, order) +
           bytes_of<std::uint16_t>({2}, order) + bytes_of<float>({1, 2}, order);
  }
  void expect_reads(const std::string& bytes, bool skips_first) const {
    const InputFile file(make("a.ply", bytes));
    PlyReader ply(file);
    ASSERT_EQ(ply.elements().size(), 3U);
    const PlyElement& camera = ply.elements()[0];
    PlyRow row;
    if (skips_first) {
      ply.skip(camera);
    } else {
      ply.read_row(camera, row);
      EXPECT_EQ(values(row, 0), std::vector<double>{0.5});
      ply.read_row(camera, row);
      EXPECT_EQ(values(row, 0), std::vector<double>{0.25});
      EXPECT_EQ(values(row, 1), std::vector<double>{2});
    }
    const PlyElement& strip = ply.elements()[1];
    ply.read_row(strip, row);
    EXPECT_EQ(values(row, 0), (std::vector<double>{10, -20}));
    EXPECT_EQ(values(row, 1), std::vector<double>{3});
    EXPECT_EQ(values(row, 2), std::vector<double>{0.5});
    ply.read_row(strip, row);
    EXPECT_EQ(values(row, 0), std::vector<double>{});
    EXPECT_EQ(values(row, 1), std::vector<double>{4});
    EXPECT_EQ(values(row, 2), (std::vector<double>{1, 2}));
    ply.skip(ply.elements()[2]);
  }
  /// Reads the whole file, which must end in this error.
  FileError error(const std::string& bytes, std::string_view message) const {
    const std::filesystem::path path = make("a.ply", bytes);
    const InputFile file(path);
    return file_error(path, message, [&] {
      PlyReader ply(file);
      PlyRow row;
      for (const PlyElement& element : ply.elements()) {
        for (std::uint64_t i = 0; i < element.count; ++i) ply.read_row(element, row);
      }
    });
  }
};

TEST_F(PlyReaderTest, RowsOfEveryEncodingAreTheSame) {
  for (const bool skips_first : {false, true}) {
    expect_reads(text(), skips_first);
    expect_reads(binary(std::endian::little), skips_first);
    expect_reads(binary(std::endian::big), skips_first);
  }
}

TEST_F(PlyReaderTest, DataCutAnywhereIsRefused) {
  const std::string whole = binary(std::endian::little);
  const std::size_t header = whole.find("end_header\n") + 11;
  for (std::size_t size = header; size < whole.size(); ++size) {
    error(whole.substr(0, size), "ends inside the data of element");
  }
}

TEST_F(PlyReaderTest, ListsThatLieAreRefused) {
  const auto text_of = [](const std::string& row) {
    return "ply\nformat ascii 1.0\nelement a 1\nproperty list int int b\nend_header\n" + row + "\n";
  };
  for (const char* row : {"3 1 2", "-1 1 2", "nan 1", "1e300"}) {
    expect_at_line(error(text_of(row), "another length than it says"), 6);
  }
  expect_at_line(error(text_of("1 1 2"), "has 2 values instead of 1"), 6);
  const std::string header =
      "ply\nformat binary_little_endian 1.0\nelement a 1\nproperty list int double b\nend_header\n";
  expect_at_byte(error(header + bytes_of<std::int32_t>({-1}), "negative length"), header.size());
  expect_at_byte(error(header + bytes_of<std::int32_t>({0x7FFFFFFF, 1, 2}), "ends inside"),
                 header.size() + 4);
}

}  // namespace
}  // namespace evermap
