// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cerrno>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include <evermap/files/detail/descriptor.hpp>
#include <evermap/files/file_error.hpp>
#include <evermap/io/detail/atomic_file.hpp>

namespace evermap {
namespace {

constexpr std::size_t kBufferSize = 1 << 20;  // [bytes] few system calls, and no more than a cache holds
constexpr int kMaxLinks = 40;                 // what the kernel itself follows
constexpr std::string_view kTemporaryPrefix = ".evermap-";
constexpr std::string_view kTemporarySuffix = ".tmp";
constexpr int kMaxAttempts = 1000;  // leftovers of crashed processes that had this process's id

std::filesystem::path folder_of(const std::filesystem::path& file) {
  return file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
}

/// Locks a file that was just made, by which others know that its writer lives. False when one of them was
/// quicker and took it for a leftover.
bool is_ours(int descriptor) {
  struct stat status {};
  return ::flock(descriptor, LOCK_EX | LOCK_NB) != 0 ||
         (::fstat(descriptor, &status) == 0 && status.st_nlink > 0);
}

/// Follows links by hand, because a link may point to a file that does not exist yet.
std::filesystem::path follow_links(const std::filesystem::path& path) {
  std::filesystem::path target = path;
  std::error_code error;
  for (int i = 0; std::filesystem::is_symlink(target, error); ++i) {
    if (i == kMaxLinks) throw FileError(path, "too many symbolic links; name the file itself");
    const std::filesystem::path link = std::filesystem::read_symlink(target, error);
    if (error) throw FileError(path, "cannot read the symbolic link: " + error.message());
    target = folder_of(target) / link;  // operator/ drops the folder when the link is absolute
  }
  return target;
}

}  // namespace

void sync_folder_of(const std::filesystem::path& file) {
  const auto fail = [&](int error) {
    throw FileError(file, "its folder cannot be synced: " + std::generic_category().message(error));
  };
  const int folder = open_descriptor(folder_of(file), O_RDONLY | O_DIRECTORY);
  if (folder < 0) {
    if (errno == EACCES) return;  // a folder one may write but not list cannot be synced by any means
    fail(errno);
  }
  const int error = sync_to_device(folder);
  ::close(folder);
  // Some network file systems know no sync of folders and say so with EINVAL.
  if (error != 0 && error != EINVAL) fail(error);
}

void remove_leftovers_beside(const std::filesystem::path& file) {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder_of(file), error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(kTemporaryPrefix) || !name.ends_with(kTemporarySuffix)) continue;
    const int descriptor = open_descriptor(entry.path(), O_RDONLY | O_NOFOLLOW);
    if (descriptor < 0) continue;
    if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0) ::unlink(entry.path().c_str());
    ::close(descriptor);
  }
}

AtomicFile::AtomicFile(std::filesystem::path path) : path_(std::move(path)), target_(follow_links(path_)) {
  struct stat status {};
  const bool exists = ::stat(target_.c_str(), &status) == 0;
  if (!exists && errno != ENOENT) fail(errno, "cannot be written");
  if (!exists && !target_.has_filename()) throw FileError(path_, "names no file to write; add a file name");
  if (exists && S_ISDIR(status.st_mode)) throw FileError(path_, "is a folder; name a file in it");
  if (exists && !S_ISREG(status.st_mode)) {
    throw FileError(path_, "is a device, pipe or socket and cannot be replaced; name a regular file");
  }
  // rename() asks only for a writable folder; a file that its owner has write-protected must survive.
  if (exists && ::faccessat(AT_FDCWD, target_.c_str(), W_OK, AT_EACCESS) != 0)
    fail(errno, "cannot be replaced");
  open_temporary(exists ? 0600 : 0666);
  if (exists && ::fchmod(descriptor_, status.st_mode & 0777) != 0) {
    const int error = errno;
    close();
    ::unlink(temporary_path_.c_str());  // the destructor does not run for a constructor that throws
    fail(error, "cannot keep its permissions");
  }
}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!temporary_path_.empty()) ::unlink(temporary_path_.c_str());
}

void AtomicFile::write(const void* data, std::size_t size) {
  const char* bytes = static_cast<const char*>(data);
  if (buffer_.size() + size > kBufferSize) flush();
  if (size > kBufferSize) {
    write_through(bytes, size);
  } else {
    buffer_.append(bytes, size);
  }
}

void AtomicFile::commit() {
  flush();
  if (const int error = sync_to_device(descriptor_); error != 0)
    fail(error, "cannot be written to the device");
  // The lock outlives the descriptor, whose closing must be seen to succeed, until the file has its name.
  const struct Lock {
    ~Lock() { ::close(descriptor); }
    int descriptor;
  } lock{::dup(descriptor_)};
  close();
  if (::rename(temporary_path_.c_str(), target_.c_str()) != 0) fail(errno, "cannot be replaced");
  temporary_path_.clear();
  sync_folder_of(target_);
}

/// The name does not grow with the target's, so that it fits wherever the target's fits; O_EXCL makes names
/// unique among threads without a shared counter.
void AtomicFile::open_temporary(unsigned permissions) {
  const std::string prefix = std::string(kTemporaryPrefix) + std::to_string(::getpid()) + "-";
  for (int i = 0; i < kMaxAttempts; ++i) {
    temporary_path_ = folder_of(target_) / (prefix + std::to_string(i) + std::string(kTemporarySuffix));
    descriptor_ = open_descriptor(temporary_path_, O_WRONLY | O_CREAT | O_EXCL, permissions);
    if (descriptor_ >= 0 && is_ours(descriptor_)) return;
    if (descriptor_ >= 0) {
      close();
      continue;
    }
    if (errno != EEXIST) fail(errno, "no file can be made in its folder");
  }
  fail(EEXIST, "remove old files " + prefix + "*.tmp from its folder");
}

void AtomicFile::write_through(const char* data, std::size_t size) {
  if (const int error = write_all(descriptor_, {data, size}); error != 0) fail(error, "cannot be written");
}

void AtomicFile::flush() {
  write_through(buffer_.data(), buffer_.size());
  buffer_.clear();
}

void AtomicFile::close() {
  // Linux closes the descriptor even when close() is interrupted: trying again could close another's.
  if (::close(std::exchange(descriptor_, -1)) != 0 && errno != EINTR) fail(errno, "cannot be written");
}

void AtomicFile::fail(int error, const std::string& what) const {
  throw FileError(path_, what + ": " + std::generic_category().message(error));
}

void make_folder(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) throw FileError(path, "the folder cannot be made: " + error.message());
}

}  // namespace evermap
