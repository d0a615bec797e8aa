// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include <evermap/files/input_file.hpp>

namespace evermap {

namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& message) {
  throw FileError(path, message);
}

std::uint64_t size_of(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) fail(path, "cannot be read: " + error.message() + "; check the path");
  if (std::filesystem::is_directory(status)) fail(path, "is a folder; name a file in it");
  if (!std::filesystem::is_regular_file(status)) fail(path, "is no regular file; copy its content to one");
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) fail(path, "cannot be read: " + error.message());
  if (size == 0) fail(path, "is empty; copy or record it again");
  return size;
}

}  // namespace

InputStream::InputStream(std::filesystem::path path) : path_(std::move(path)), size_(size_of(path_)) {
  errno = 0;
  stream_.open(path_, std::ios::binary);
  if (!stream_) fail(path_, "cannot be opened: " + std::generic_category().message(errno));
}

void InputStream::append_to(std::string& buffer, std::size_t size) {
  const std::size_t before = buffer.size();
  buffer.resize(before + size);
  stream_.read(buffer.data() + before, static_cast<std::streamsize>(size));
  if (stream_.bad()) fail(path_, "cannot be read: " + std::generic_category().message(errno));
  if (static_cast<std::size_t>(stream_.gcount()) < size) fail(path_, "became shorter while it was read");
  position_ += size;
}

InputFile::InputFile(std::filesystem::path path) : path_(std::move(path)) {
  InputStream stream(path_);
  stream.append_to(bytes_, stream.rest());
}

}  // namespace evermap
