// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cerrno>
#include <fstream>
#include <system_error>
#include <utility>

#include <evermap/io/input_file.hpp>

namespace evermap {

InputFile::InputFile(std::filesystem::path path) : path_(std::move(path)) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path_, error);
  if (!std::filesystem::exists(status)) fail("cannot be read: " + error.message() + "; check the path");
  if (std::filesystem::is_directory(status)) fail("is a folder; name a file in it");
  if (!std::filesystem::is_regular_file(status)) fail("is no regular file; copy its content to one");
  const std::uintmax_t size = std::filesystem::file_size(path_, error);
  if (error) fail("cannot be read: " + error.message());
  if (size == 0) fail("is empty; copy or record it again");

  errno = 0;
  std::ifstream stream(path_, std::ios::binary);
  if (!stream) fail("cannot be opened: " + std::generic_category().message(errno));
  bytes_.resize(size);
  stream.read(bytes_.data(), static_cast<std::streamsize>(size));
  if (stream.bad()) fail("cannot be read: " + std::generic_category().message(errno));
  bytes_.resize(static_cast<std::size_t>(stream.gcount()));
}

}  // namespace evermap
