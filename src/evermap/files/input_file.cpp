// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cerrno>
#include <fcntl.h>
#include <new>
#include <stdexcept>
#include <string>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include <evermap/files/detail/descriptor.hpp>
#include <evermap/files/detail/gzip.hpp>
#include <evermap/files/detail/input_file.hpp>

namespace evermap {

namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& message) {
  throw FileError(path, message);
}

std::string reason(int error) { return std::generic_category().message(error); }

/// [bytes] What the machine has, used or not.
std::uint64_t physical_memory() {
  return static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) *
         static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

void grow(std::string& buffer, std::uint64_t size, const std::filesystem::path& path) {
  try {
    buffer.resize(buffer.size() + size);
  } catch (const std::bad_alloc&) {
    fail(path, "there is not enough memory for its " + std::to_string(size) + " bytes");
  } catch (const std::length_error&) {
    fail(path, "there is not enough memory for its " + std::to_string(size) + " bytes");
  }
}

}  // namespace

InputStream::InputStream(std::filesystem::path path) : path_(std::move(path)) {
  try {
    open();
  } catch (...) {
    if (descriptor_ >= 0) ::close(descriptor_);
    throw;
  }
}

InputStream::~InputStream() { ::close(descriptor_); }

/// Opens first and looks then, so that what is looked at is what will be read.
void InputStream::open() {
  // Without waiting for a pipe's other end, since a pipe is refused anyway.
  descriptor_ = open_descriptor(path_, O_RDONLY | O_NONBLOCK);
  if (descriptor_ < 0 && errno == ENXIO)
    fail(path_, "is no regular file; copy its content to one");  // a socket
  if (descriptor_ < 0) fail(path_, "cannot be read: " + reason(errno) + "; check the path");
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) fail(path_, "cannot be read: " + reason(errno));
  if (S_ISDIR(status.st_mode)) fail(path_, "is a folder; name a file in it");
  if (!S_ISREG(status.st_mode)) fail(path_, "is no regular file; copy its content to one");
  if (status.st_size == 0) fail(path_, "is empty; copy or record it again");
  size_ = static_cast<std::uint64_t>(status.st_size);
}

void InputStream::seek(std::uint64_t position) {
  if (::lseek(descriptor_, static_cast<off_t>(position), SEEK_SET) < 0)
    fail(path_, "cannot be read: " + reason(errno));
  position_ = position;
}

void InputStream::append_to(std::string& buffer, std::uint64_t size) {
  const std::size_t before = buffer.size();
  grow(buffer, size, path_);
  for (std::uint64_t done = 0; done < size;) {
    const ssize_t read = ::read(descriptor_, buffer.data() + before + done, size - done);
    if (read < 0 && errno == EINTR) continue;
    if (read < 0) fail(path_, "cannot be read: " + reason(errno));
    if (read == 0) fail(path_, "became shorter while it was read");
    done += static_cast<std::uint64_t>(read);
  }
  position_ += size;
}

InputFile::InputFile(std::filesystem::path path) : path_(std::move(path)) {
  InputStream stream(path_);
  if (stream.rest() > physical_memory() / 2) {
    fail("has " + std::to_string(stream.rest()) + " bytes, more than half of this machine's memory");
  }
  stream.append_to(bytes_, stream.rest());
  if (is_gzip(path_)) bytes_ = gunzip(path_, bytes_);
}

}  // namespace evermap
