// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "picture.hpp"

#include <algorithm>
#include <string>

#include <png.h>

#include <evermap/files/file_error.hpp>
#include <evermap/io/detail/atomic_file.hpp>

namespace evermap {
Picture::Picture(int width, int height, Color ground)
    : width_(width),
      height_(height),
      pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), ground) {}

void Picture::fill(int x, int y, int width, int height, Color color) {
  const int left = std::clamp(x, 0, width_);
  const int right = std::clamp(x + width, left, width_);
  for (int row = std::max(y, 0); row < std::min(y + height, height_); ++row) {
    const auto begin = pixels_.begin() + static_cast<std::ptrdiff_t>(row) * width_;
    std::fill(begin + left, begin + right, color);
  }
}

void Picture::save_png(const std::filesystem::path& path) const {
  static_assert(sizeof(Color) == 3);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width_);
  image.height = static_cast<png_uint_32>(height_);
  image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels_.data(), 0, nullptr) == 0) {
    throw FileError(path, std::string("the picture cannot be encoded: ") + image.message);
  }
  AtomicFile file(path);
  file.write(bytes.data(), size);
  file.commit();
}

}  // namespace evermap
