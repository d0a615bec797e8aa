// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <sys/stat.h>

#include "files/file_fixture.hpp"
#include <evermap/files/detail/input_file.hpp>

namespace evermap {
namespace {

class InputFileTest : public FileTest {
 protected:
  static void expect_refused(const std::filesystem::path& file, std::string_view message) {
    file_error(file, message, [&] { InputFile input(file); });
  }
};

TEST_F(InputFileTest, HoldsAllBytes) {
  std::string bytes(3'000'000, 'x');
  bytes[1'234'567] = '\0';
  EXPECT_EQ(InputFile(make("a", bytes)).bytes(), bytes);
}

TEST_F(InputFileTest, WhatIsNoFileWithContentIsRefused) {
  expect_refused(path("none"), "No such file");
  expect_refused(folder_, "is a folder");
  expect_refused(make("empty", ""), "is empty");
  expect_refused("/dev/zero", "no regular file");
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  expect_refused(path("pipe"), "no regular file");  // and does not wait for a writer
}

TEST_F(InputFileTest, MoreThanTheMemoryIsRefusedBeforeItIsTaken) {
  std::filesystem::resize_file(make("sparse", "x"), std::uintmax_t{1} << 42);
  expect_refused(path("sparse"), "more than half of this machine's memory");
}

TEST_F(InputFileTest, AStreamReadsTheFileThatItOpened) {
  InputStream stream(make("a", "old content"));
  make("b", "new");
  std::filesystem::rename(path("b"), path("a"));
  std::string bytes = ">";
  stream.append_to(bytes, 4);
  EXPECT_EQ(stream.rest(), 7U);
  stream.append_to(bytes, stream.rest());
  EXPECT_EQ(bytes, ">old content");
}

TEST_F(InputFileTest, AFileThatShrinksIsSaid) {
  InputStream stream(make("a", "content"));
  std::filesystem::resize_file(path("a"), 3);
  std::string bytes;
  file_error(path("a"), "became shorter", [&] { stream.append_to(bytes, stream.rest()); });
}

}  // namespace
}  // namespace evermap
