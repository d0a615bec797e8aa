// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <stdlib.h>
#include <string>
#include <string_view>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include <evermap/files/file_error.hpp>

namespace evermap {

inline constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
inline constexpr float kInf = std::numeric_limits<float>::infinity();

/// A test with a folder of its own that is removed afterwards.
class FileTest : public testing::Test {
 protected:
  FileTest() {
    std::string name = (std::filesystem::temp_directory_path() / "evermap-test-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    folder_ = name;
  }
  ~FileTest() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path path(const std::string& name) const { return folder_ / name; }
  std::filesystem::path make(const std::string& name, std::string_view bytes) const {
    std::filesystem::remove(path(name));  // truncating makes some file systems write to the device at once
    std::ofstream(path(name), std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return path(name);
  }
  static std::string content(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  std::size_t files_in_folder() const {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(folder_), std::filesystem::directory_iterator()));
  }

  std::filesystem::path folder_;
};

/// Takes away, for its lifetime, the superuser's right to pass over permissions, should the test have it.
class Unprivileged {
 public:
  Unprivileged() {
    if (before_ == 0 && ::seteuid(65534) != 0) ADD_FAILURE() << "cannot give up the superuser's rights";
  }
  ~Unprivileged() {
    if (::seteuid(before_) != 0) std::abort();
  }

 private:
  const uid_t before_ = ::geteuid();
};

/// The bytes of values, one after the other.
template <typename T>
std::string bytes_of(const std::vector<T>& values, std::endian order = std::endian::little) {
  std::string bytes;
  for (const T value : values) {
    auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
    if (order != std::endian::native) std::reverse(raw.begin(), raw.end());
    bytes.append(raw.data(), raw.size());
  }
  return bytes;
}

/// The error that `call` throws; a failure of the test when it throws none. Every error must be one line that
/// begins with the file's path and holds `text`.
template <typename Call>
FileError file_error(const std::filesystem::path& path, std::string_view text, Call call) {
  try {
    call();
  } catch (const FileError& error) {
    const std::string_view what = error.what();
    EXPECT_EQ(error.path(), path);
    EXPECT_TRUE(what.starts_with(path.string() + ": ")) << what;
    EXPECT_EQ(what.find('\n'), std::string_view::npos) << what;
    EXPECT_NE(what.find(text), std::string_view::npos) << what << "\nlacks: " << text;
    return error;
  }
  ADD_FAILURE() << "no FileError for " << text;
  return {path, "no error"};
}

inline void expect_at_line(const FileError& error, std::uint64_t line) {
  EXPECT_EQ(error.unit(), FileError::Unit::kLine) << error.what();
  EXPECT_EQ(error.position(), line) << error.what();
}
inline void expect_at_byte(const FileError& error, std::uint64_t offset) {
  EXPECT_EQ(error.unit(), FileError::Unit::kByte) << error.what();
  EXPECT_EQ(error.position(), offset) << error.what();
}

}  // namespace evermap
