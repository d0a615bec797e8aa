// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace evermap {

struct Color {
  std::uint8_t red, green, blue;  ///< sRGB
};

/// An image in memory; pixel (0, 0) is the upper left one. What is drawn beyond its borders is cut off.
class Picture {
 public:
  Picture(int width, int height, Color ground);

  int width() const { return width_; }
  int height() const { return height_; }

  void fill(int x, int y, int width, int height, Color color);

  /// Atomically. Throws FileError when the file cannot be written.
  void save_png(const std::filesystem::path& path) const;

 private:
  int width_;
  int height_;
  std::vector<Color> pixels_;  ///< row by row, width_ x height_
};

}  // namespace evermap
