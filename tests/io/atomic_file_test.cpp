// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "files/file_fixture.hpp"
#include <evermap/io/detail/atomic_file.hpp>

namespace evermap {
namespace {

namespace fs = std::filesystem;

class AtomicFileTest : public FileTest {};

TEST_F(AtomicFileTest, CommitMakesANewFile) {
  AtomicFile file(path("map"));
  file.write("one ");
  file.write("two");
  EXPECT_FALSE(fs::exists(path("map")));
  file.commit();
  EXPECT_EQ(content(path("map")), "one two");
  EXPECT_EQ(files_in_folder(), 1U);
}

TEST_F(AtomicFileTest, OldFileStaysUntilCommit) {
  make("map", "old");
  AtomicFile file(path("map"));
  file.write("new");
  EXPECT_EQ(content(path("map")), "old");
  file.commit();
  EXPECT_EQ(content(path("map")), "new");
}

TEST_F(AtomicFileTest, WithoutCommitNothingChanges) {
  make("map", "old");
  {
    AtomicFile file(path("map"));
    file.write(std::string(3 << 20, 'x'));
  }
  EXPECT_EQ(content(path("map")), "old");
  EXPECT_EQ(files_in_folder(), 1U);
}

TEST_F(AtomicFileTest, SmallAndLargeWritesKeepTheirOrder) {
  std::string expected;
  AtomicFile file(path("map"));
  for (std::size_t i = 0; i < 40; ++i) {
    const std::string part(i % 7 == 3 ? (1 << 20) + i : 1000 * i, static_cast<char>('a' + i % 26));
    file.write(part);
    expected += part;
  }
  file.commit();
  EXPECT_TRUE(content(path("map")) == expected);
}

TEST_F(AtomicFileTest, TwoWritersOfOneFileDoNotMeet) {
  AtomicFile first(path("map"));
  AtomicFile second(path("map"));
  first.write("first");
  second.write("second");
  first.commit();
  EXPECT_EQ(content(path("map")), "first");
  second.commit();
  EXPECT_EQ(content(path("map")), "second");
}

TEST_F(AtomicFileTest, RelativePathWithoutFolder) {
  const fs::path before = fs::current_path();
  fs::current_path(folder_);
  AtomicFile file("map");
  file.write("x");
  file.commit();
  fs::current_path(before);
  EXPECT_EQ(content(path("map")), "x");
}

TEST_F(AtomicFileTest, PermissionsAreKept) {
  fs::permissions(make("map", "old"), fs::perms(0640));
  AtomicFile file(path("map"));
  file.commit();
  EXPECT_EQ(fs::status(path("map")).permissions(), fs::perms(0640));
}

TEST_F(AtomicFileTest, NewFileFollowsTheUmask) {
  const mode_t before = ::umask(027);
  AtomicFile file(path("map"));
  file.commit();
  ::umask(before);
  EXPECT_EQ(fs::status(path("map")).permissions(), fs::perms(0640));
}

TEST_F(AtomicFileTest, SymbolicLinkStaysAndItsTargetIsReplaced) {
  fs::create_directory(path("maps"));
  make("maps/real", "old");
  fs::create_symlink("maps/real", path("inner"));
  fs::create_symlink(path("inner"), path("link"));
  AtomicFile file(path("link"));
  file.write("new");
  file.commit();
  EXPECT_TRUE(fs::is_symlink(path("link")));
  EXPECT_TRUE(fs::is_symlink(path("inner")));
  EXPECT_FALSE(fs::is_symlink(path("maps/real")));
  EXPECT_EQ(content(path("maps/real")), "new");
}

TEST_F(AtomicFileTest, DanglingLinkGetsItsTarget) {
  fs::create_symlink("later", path("link"));
  AtomicFile file(path("link"));
  file.write("new");
  file.commit();
  EXPECT_TRUE(fs::is_symlink(path("link")));
  EXPECT_EQ(content(path("later")), "new");
}

TEST_F(AtomicFileTest, LinksInACircleAreRefused) {
  fs::create_symlink("b", path("a"));
  fs::create_symlink("a", path("b"));
  file_error(path("a"), "too many symbolic links", [&] { AtomicFile file(path("a")); });
}

TEST_F(AtomicFileTest, WhatIsNoRegularFileIsRefused) {
  file_error(folder_, "is a folder", [&] { AtomicFile file(folder_); });
  file_error("/dev/full", "is a device", [] { AtomicFile file("/dev/full"); });
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  file_error(path("pipe"), "is a device, pipe", [&] { AtomicFile file(path("pipe")); });
  EXPECT_EQ(files_in_folder(), 1U);
}

TEST_F(AtomicFileTest, PathsThatNameNoFileAreRefused) {
  file_error("", "names no file", [] { AtomicFile file(""); });
  file_error(path("none/"), "names no file", [&] { AtomicFile file(path("none/")); });
  file_error(path("none/map"), "No such file or directory", [&] { AtomicFile file(path("none/map")); });
  make("file", "x");
  file_error(path("file/map"), "Not a directory", [&] { AtomicFile file(path("file/map")); });
}

TEST_F(AtomicFileTest, WriteProtectedFileSurvives) {
  fs::permissions(folder_, fs::perms(0777));
  fs::permissions(make("map", "old"), fs::perms(0444));
  const Unprivileged unprivileged;
  file_error(path("map"), "Permission denied", [&] { AtomicFile file(path("map")); });
  EXPECT_EQ(content(path("map")), "old");
}

/// Lowers the size that files of this process may have, as a full device would.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t size) : handler_(::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit = {size, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    ::signal(SIGXFSZ, handler_);
  }

 private:
  void (*handler_)(int);
  rlimit before_{};
};

TEST_F(AtomicFileTest, FailedWriteLeavesTheOldFile) {
  make("map", "old");
  {
    AtomicFile file(path("map"));
    const FileSizeLimit limit(100'000);
    // The first 100,000 bytes are taken (a short write), the rest is refused.
    file_error(path("map"), "File too large", [&] { file.write(std::string(3 << 20, 'x')); });
  }
  EXPECT_EQ(content(path("map")), "old");
  EXPECT_EQ(files_in_folder(), 1U);
}

TEST_F(AtomicFileTest, FailedCommitLeavesTheOldFile) {
  make("map", "old");
  {
    AtomicFile file(path("map"));
    file.write(std::string(200'000, 'x'));  // still in the buffer
    const FileSizeLimit limit(100'000);
    file_error(path("map"), "File too large", [&] { file.commit(); });
  }
  EXPECT_EQ(content(path("map")), "old");
  EXPECT_EQ(files_in_folder(), 1U);
}

TEST_F(AtomicFileTest, TargetThatBecameAFolderIsNotReplaced) {
  {
    AtomicFile file(path("map"));
    fs::create_directory(path("map"));
    file_error(path("map"), "cannot be replaced", [&] { file.commit(); });
  }
  EXPECT_TRUE(fs::is_directory(path("map")));
  EXPECT_EQ(files_in_folder(), 1U);
}

}  // namespace
}  // namespace evermap
