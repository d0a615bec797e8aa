// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "files/file_fixture.hpp"
#include <evermap/io/detail/scan_folder.hpp>
#include <evermap/io/detail/selected_scans.hpp>

namespace evermap {
namespace {

class SelectedScansTest : public FileTest {
 protected:
  /// A folder of scans whose x is their number; those named are cut off.
  void make_scans(int count, const std::vector<int>& damaged) {
    for (int i = 0; i < count; ++i) {
      const std::string scan = bytes_of<float>({static_cast<float>(i + 1), 0, 0, 0});
      const bool is_damaged = std::find(damaged.begin(), damaged.end(), i) != damaged.end();
      make(std::to_string(i) + ".bin", is_damaged ? scan.substr(0, 13) : scan);
    }
  }
  SelectedScans open(const ScanSelection& selection = {}) const {
    return {std::make_unique<ScanFolder>(folder_, CloudOptions{.bin_fields = 4}), selection};
  }
  static std::vector<std::size_t> indices(SelectedScans& scans) {
    std::vector<std::size_t> indices;
    while (scans.next()) indices.push_back(scans.index());
    return indices;
  }
};

TEST_F(SelectedScansTest, ScansWithoutTimesAreCounted) {
  make_scans(20, {});
  SelectedScans scans = open({.start = 0.5, .duration = 1.0, .every = 4, .scan_period = 0.1});
  EXPECT_EQ(indices(scans), (std::vector<std::size_t>{5, 9, 13}));
}

TEST_F(SelectedScansTest, ADamagedScanCostsItself) {
  make_scans(20, {0, 7});
  SelectedScans scans = open();
  const std::vector<std::size_t> given = indices(scans);
  EXPECT_EQ(given.size(), 18U);
  EXPECT_EQ(given.front(), 1U);
  EXPECT_EQ(scans.failure(), "");
  ASSERT_EQ(scans.remarks().size(), 2U);
  EXPECT_NE(scans.remarks()[1].find("7.bin: at byte 0: the last point has 13 of 16 bytes"), std::string::npos)
      << scans.remarks()[1];
}

TEST_F(SelectedScansTest, MoreThanATenthEndIt) {
  make_scans(20, {3, 7, 11});
  SelectedScans scans = open();
  EXPECT_EQ(indices(scans).size(), 9U);  // 0 to 10 without 3 and 7
  EXPECT_NE(scans.failure().find("11.bin"), std::string::npos) << scans.failure();
  EXPECT_NE(scans.failure().find("2 scans before"), std::string::npos) << scans.failure();
}

TEST_F(SelectedScansTest, TheFirstEndsItIfOneWishes) {
  make_scans(20, {3});
  SelectedScans scans = open({.is_strict = true});
  EXPECT_EQ(indices(scans).size(), 3U);
  EXPECT_NE(scans.failure().find("3.bin"), std::string::npos) << scans.failure();
}

TEST_F(SelectedScansTest, WhereNothingCanBeReadItIsAnError) {
  make_scans(5, {0});
  SelectedScans scans = open();
  file_error(path("0.bin"), "the last point has 13 of 16 bytes", [&] { scans.next(); });
}

}  // namespace
}  // namespace evermap
