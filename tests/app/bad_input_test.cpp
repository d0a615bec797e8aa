// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cerrno>
#include <cstring>
#include <sys/mount.h>
#include <sys/resource.h>

#include "app/program.hpp"

namespace evermap {
namespace {

#if defined(__SANITIZE_ADDRESS__)  // gcc
constexpr bool kUnderAddressSanitizer = true;
#elif defined(__has_feature)  // clang
constexpr bool kUnderAddressSanitizer = __has_feature(address_sanitizer);
#else
constexpr bool kUnderAddressSanitizer = false;
#endif

class BadInputTest : public ProgramTest {
 protected:
  BadInputTest() {
    if (kUnderAddressSanitizer) return;  // its shadow alone is larger
    // What a file claims must not be allocated: with this limit, 10^12 points cannot be.
    const rlimit limit = {rlim_t{4} << 30, RLIM_INFINITY};
    ::setrlimit(RLIMIT_AS, &limit);
  }

  void expect_cloud_refused(const std::string& file, std::string_view bytes, const std::string& text) const {
    make(file, bytes);
    expect_failed({"import", name(file), "-r", "0.4", "-o", name("out.evm")}, text);
  }
  /// A drive of two scans whose poses read so.
  void expect_poses_refused(std::string_view poses, const std::string& text) {
    if (!std::filesystem::exists(path("drive"))) make_drive("drive", 2, true);
    make("drive.txt", poses);
    expect_failed(build("drive", "out.evm"), text);
  }
};

std::string pcd(const std::string& fields, const std::string& points, const std::string& data) {
  return "VERSION 0.7\nFIELDS " + fields + "\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " + points +
         "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + points + "\nDATA " + data;
}

TEST_F(BadInputTest, Clouds) {
  expect_failed({"import", name("none.pcd"), "-r", "0.4", "-o", name("out.evm")}, "No such file");
  expect_cloud_refused("empty.pcd", "", "is empty");
  expect_cloud_refused("header.pcd", "VERSION 0.7\nFIELDS x y", "header.pcd");
  expect_cloud_refused("data.pcd", pcd("x y z", "2", "binary\n") + bytes_of<float>({1, 2, 3, 4}),
                       "data.pcd: at byte");
  expect_cloud_refused("data.bin", bytes_of<float>({1, 2, 3}), "data.bin: at byte");
  for (const char* encoding : {"ascii\n1 2 3\n", "binary\n123456789012", "binary_compressed\n12345678"}) {
    expect_cloud_refused("huge.pcd", pcd("x y z", "1000000000000", encoding), "huge.pcd");
    expect_cloud_refused("negative.pcd", pcd("x y z", "-5", encoding), "negative.pcd: at line");
  }
  expect_cloud_refused("fields.pcd", pcd("a b c", "1", "ascii\n1 2 3\n"), "has no field x");
  std::string unknown = pcd("x y z", "1", "ascii\n1 2 3\n");
  unknown.replace(unknown.find("TYPE F"), 6, "TYPE Q");
  expect_cloud_refused("type.pcd", unknown, "type.pcd: at line");
  expect_cloud_refused("cloud.e57", "LASF", "is no known kind of point cloud");
}

TEST_F(BadInputTest, CloudsWithoutAUsablePoint) {
  expect_cloud_refused("nan.bin", bytes_of<float>({kNaN, 0, 0, 0, kInf, 0, 0, 0}),
                       "nan.bin: no usable point among 2: 2 not finite");
  expect_cloud_refused("zero.bin", std::string(160, '\0'),
                       "no usable point among 10: 0 not finite, 10 at the origin");
}

TEST_F(BadInputTest, AFarPointIsDroppedNotDrawn) {
  std::string scan = room(false);
  const std::string far = bytes_of<float>({1e9F, 0, 0, 0});
  make("far.bin", scan + far);
  const Result result = run({"import", name("far.bin"), "-r", "0.4", "-o", name("out.evm")});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find(" 1 beyond the grid"), std::string::npos) << result.out;
}

TEST_F(BadInputTest, AScanWithoutAUsablePointCostsOneScan) {
  make_drive("drive", 3, true);
  make("drive/10001.bin", bytes_of<float>({0.1F, 0, 0, 0, 1e9F, 0, 0, 0}));
  const Result result = run(build("drive", "out.evm"));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("3 of 3; 1 without a usable point skipped"), std::string::npos) << result.out;
  EXPECT_NE(result.err.find("10001.bin: skipped, it has no usable point"), std::string::npos) << result.err;
}

TEST_F(BadInputTest, ScansOfWhichNoneHasAUsablePointAreRefused) {
  make_drive("drive", 2, true);
  for (const char* scan : {"drive/10000.bin", "drive/10001.bin"}) {
    make(scan, bytes_of<float>({0.1F, 0, 0, 0, 1e9F, 0, 0, 0}));
  }
  const Result result = run(build("drive", "out.evm"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(
      result.err.find("no usable point among 4: 0 not finite, 0 at the origin, 2 nearer than min range, "
                      "0 on the vehicle, 2 farther than max range"),
      std::string::npos)
      << result.err;
  EXPECT_FALSE(std::filesystem::exists(path("out.evm")));
}

TEST_F(BadInputTest, Poses) {
  const std::string one = "1 0 0 0 0 1 0 0 0 0 1 0\n";
  expect_poses_refused(one, "has 1 poses for the 2 scans");
  expect_poses_refused(one + one + one, "has 3 poses for the 2 scans");
  expect_poses_refused("", "is empty");
  expect_poses_refused(one + "1 0 0 0 0 1 0 0 0 0 2 0\n", "at line 2: ");
  expect_poses_refused(one + "1 0 0 0 0 1 0 0 0 0 nan 0\n", "at line 2: ");
  expect_poses_refused("0 0 0 0 0 0 0 0\n1 0 0 0 0 0 0 1\n", "at line 1: the quaternion");
  expect_poses_refused("1 0 0 0 0 0 0 1\n0 0 0 0 0 0 0 1\n", "at line 2: the time");
  expect_poses_refused("1 2 3\n1 2 3\n", "at line 1: has 3 numbers");
  expect_failed({"build", name("drive"), "--poses", name("none.txt"), "-r", "0.4", "-o", name("out.evm")},
                "No such file");
}

TEST_F(BadInputTest, LeafSizes) {
  make("cloud.bin", room(true));
  for (const char* leaf : {"0", "-1", "nan", "inf", "0.049", "2.01"}) {
    expect_failed({"import", name("cloud.bin"), "-r", leaf, "-o", name("out.evm")}, "is out of range");
  }
}

TEST_F(BadInputTest, Maps) {
  make_drive("drive", 1, true);
  expect_done(build("drive", "map.evm"));
  const std::string map = content(path("map.evm"));
  const auto refused = [&](std::string_view bytes, const std::string& text) {
    make("bad.evm", bytes);
    expect_failed(update("bad.evm", "drive", "out.evm"), text);
    expect_failed({"info", name("bad.evm")}, text);
    expect_failed({"export", name("bad.evm"), name("out.pcd")}, text);
    EXPECT_FALSE(std::filesystem::exists(path("out.pcd")));
  };
  refused("", "is empty");
  refused(room(true), "is no evermap map");
  refused(std::string_view(map).substr(0, map.size() / 2), "bad.evm: at byte");
  std::string flipped = map;
  flipped[map.size() / 2] ^= 4;
  refused(flipped, "its checksum does not fit");
  std::string flipped_format = map;
  flipped_format[8] = 3;
  refused(flipped_format, "the header's checksum does not fit; the map is damaged");
}

TEST_F(BadInputTest, Ranges) {
  make_drive("drive", 1, true);
  std::vector<std::string> arguments = build("drive", "out.evm");
  arguments.insert(arguments.end(), {"--min-range", "9", "--max-range", "3"});
  expect_failed(arguments, "min range 9 m is not below max range 3 m");
}

TEST_F(BadInputTest, OutputsThatCannotBeWritten) {
  make_drive("drive", 1, true);
  expect_done(build("drive", "map.evm"));
  expect_failed(build("drive", "none/out.evm"), "none/out.evm: no file can be made in its folder");
  expect_failed(update("map.evm", "drive", "none/out.evm"), "No such file or directory");
  expect_failed(build("drive", "drive"), "is a folder");
  expect_failed({"build", name("drive"), "--poses", name("drive.txt"), "-r", "0.4", "-o", "/dev/full"},
                "is a device");
  expect_failed(update("map.evm", "drive", "out.evm", {"--report", name("map.evm")}), "map.evm");
}

/// A file system of its own, which the superuser's rights do not pass over.
class Mount {
 public:
  Mount(std::filesystem::path folder, unsigned long flags, const char* options) : folder_(std::move(folder)) {
    std::filesystem::create_directory(folder_);
    is_mounted_ = ::mount("tmpfs", folder_.c_str(), "tmpfs", flags, options) == 0;
    if (!is_mounted_) error_ = std::strerror(errno);
  }
  ~Mount() {
    if (is_mounted_) ::umount(folder_.c_str());
  }
  Mount(const Mount&) = delete;
  Mount& operator=(const Mount&) = delete;

  bool is_mounted() const { return is_mounted_; }
  const std::string& error() const { return error_; }

 private:
  std::filesystem::path folder_;
  bool is_mounted_ = false;
  std::string error_;
};

TEST_F(BadInputTest, ReadOnlyFolder) {
  make_drive("drive", 1, true);
  const Mount mount(path("fixed"), MS_RDONLY, "");
  if (!mount.is_mounted()) GTEST_SKIP() << "mounting is not permitted here: " << mount.error();
  expect_failed(build("drive", "fixed/out.evm"), "Read-only file system");
}

TEST_F(BadInputTest, FullDisk) {
  // A grid of far points: as many leaves as points, 48 bytes each, 9.6 MB.
  std::vector<float> values;
  for (int i = 0; i < 200'000; ++i) {
    for (const int x : {i % 500 + 1, i / 500, 0, 0}) values.push_back(static_cast<float>(x));
  }
  make("large.bin", bytes_of(values));
  make("small.bin", room(true));
  const Mount mount(path("disk"), 0, "size=8m");
  if (!mount.is_mounted()) GTEST_SKIP() << "mounting is not permitted here: " << mount.error();
  const auto import = [&](const char* cloud) {
    return std::vector<std::string>{"import", name(cloud), "-r", "0.4", "-o", name("disk/map.evm")};
  };
  expect_failed(import("large.bin"), "No space left on device");
  EXPECT_TRUE(std::filesystem::is_empty(path("disk")));
  expect_done(import("small.bin"));
  const std::string old = content(path("disk/map.evm"));
  expect_failed(import("large.bin"), "No space left on device");
  EXPECT_TRUE(content(path("disk/map.evm")) == old);
}

}  // namespace
}  // namespace evermap
