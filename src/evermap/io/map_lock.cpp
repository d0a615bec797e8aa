// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cerrno>
#include <chrono>
#include <fcntl.h>
#include <string>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <thread>
#include <unistd.h>

#include <evermap/files/detail/descriptor.hpp>
#include <evermap/files/file_error.hpp>
#include <evermap/io/detail/atomic_file.hpp>
#include <evermap/io/detail/map_lock.hpp>

namespace evermap {
namespace {

std::string this_process() {
  std::array<char, 256> host{};
  ::gethostname(host.data(), host.size() - 1);
  return "process " + std::to_string(::getpid()) + " on " + host.data();
}

/// Whoever holds the lock, as the file says.
std::string holder_in(int descriptor) {
  std::array<char, 300> text{};
  const ssize_t size = ::pread(descriptor, text.data(), text.size() - 1, 0);
  return size > 0 ? std::string(text.data(), static_cast<std::size_t>(size)) : "another process";
}

}  // namespace

MapLock::MapLock(const std::filesystem::path& map, double patience) {
  using Clock = std::chrono::steady_clock;
  std::error_code error;
  path_ = std::filesystem::weakly_canonical(map, error);  // two names of one map have one lock
  if (error) path_ = map;
  path_ += ".lock";
  const auto until = Clock::now() + std::chrono::duration<double>(patience);
  while (!try_lock()) {
    if (Clock::now() < until) {
      ::close(descriptor_);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      continue;
    }
    const std::string holder = holder_in(descriptor_);
    ::close(descriptor_);
    throw FileError(map, "is being changed by " + holder + "; wait for it (--wait 60), or end it");
  }
  remove_leftovers_beside(path_);
}

MapLock::~MapLock() {
  ::unlink(path_.c_str());  // while it is locked, so that nobody else's goes
  ::close(descriptor_);
}

/// False when another process has it.
bool MapLock::try_lock() {
  for (;;) {
    descriptor_ = open_descriptor(path_, O_RDWR | O_CREAT);
    if (descriptor_ < 0) throw FileError(path_, "cannot be made: " + std::generic_category().message(errno));
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) return false;
    // Its last holder may have removed it between the two calls.
    struct stat locked {};
    struct stat named {};
    const bool is_same = ::fstat(descriptor_, &locked) == 0 && ::stat(path_.c_str(), &named) == 0 &&
                         locked.st_ino == named.st_ino && locked.st_dev == named.st_dev;
    if (is_same) break;
    ::close(descriptor_);
  }
  const std::string holder = this_process();
  const bool is_told = ::ftruncate(descriptor_, 0) == 0 && ::pwrite(descriptor_, holder.data(), holder.size(),
                                                                    0) == static_cast<ssize_t>(holder.size());
  static_cast<void>(is_told);  // the lock holds without the name
  return true;
}

}  // namespace evermap
