// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "birds_eye.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "picture.hpp"

namespace evermap {
namespace {

constexpr int kLeastWidth = 1000;   // [pixels]
constexpr int kMostColumns = 4096;  // larger maps are drawn coarser, which bounds memory
constexpr int kMargin = 12;         // [pixels]
constexpr int kFooter = Picture::kTextHeight + 2 * kMargin;
constexpr double kCroppedSide = 0.0025;  // share of the leaves left out at each side of the area
constexpr double kCroppedHeight =
    0.02;  // and at each end of the ramp, where strays below ground take colours

constexpr Color kGround = {255, 255, 255};
constexpr Color kInk = {40, 40, 40};
// Okabe and Ito's palette, which holds for every common colour blindness.
constexpr Color kUnchanged = {205, 205, 205};
constexpr Color kMoved = {204, 121, 167};
constexpr Color kAdded = {0, 114, 178};
constexpr Color kRemoved = {213, 94, 0};

/// Viridis (van der Walt and Smith, 2015), without its brightest end, which white ground would swallow.
Color ramp(double share) {
  constexpr std::array<std::array<double, 3>, 8> kStops = {{{68, 1, 84},
                                                            {71, 44, 122},
                                                            {59, 81, 139},
                                                            {44, 113, 142},
                                                            {33, 144, 141},
                                                            {39, 173, 129},
                                                            {92, 200, 99},
                                                            {170, 220, 50}}};
  const double at = std::clamp(share, 0.0, 1.0) * (kStops.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  const auto mix = [&](std::size_t channel) {
    const double t = at - static_cast<double>(below);
    return static_cast<std::uint8_t>(
        std::lround((1 - t) * kStops[below][channel] + t * kStops[below + 1][channel]));
  };
  return {mix(0), mix(1), mix(2)};
}

struct Range {
  int least, greatest;  ///< both included
  int size() const { return greatest - least + 1; }
};

/// The range of values without that share at each end. REQUIRES: there are values.
Range cropped(std::vector<int>& values, double share) {
  const auto cut = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), values.begin() + cut, values.end());
  const int least = values[static_cast<std::size_t>(cut)];
  std::nth_element(values.begin(), values.end() - 1 - cut, values.end());
  return {least, *(values.end() - 1 - cut)};
}

/// The part of the map that all pictures show, divided into square cells: one leaf column each, or several
/// in a very large map.
class View {
 public:
  View(const Octree& before, const Octree& after)
      : edge_(before.grid().edge), origin_z_(before.grid().origin.z()) {
    std::array<std::vector<int>, 3> voxels;
    for (const Octree* octree : {&before, &after}) {
      octree->for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
        if (!leaf.occupied()) return;
        const Eigen::Vector3i voxel = key.voxel();
        for (int axis = 0; axis < 3; ++axis) voxels[static_cast<std::size_t>(axis)].push_back(voxel[axis]);
      });
    }
    if (voxels[0].empty()) return;
    range_ = {cropped(voxels[0], kCroppedSide), cropped(voxels[1], kCroppedSide),
              cropped(voxels[2], kCroppedHeight)};
    voxels_per_cell_ = 1 + (std::max(range_[0].size(), range_[1].size()) - 1) / kMostColumns;
    pixels_per_cell_ = std::max(1, (kLeastWidth + columns() - 1) / columns());
  }

  int columns() const { return (range_[0].size() + voxels_per_cell_ - 1) / voxels_per_cell_; }
  int rows() const { return (range_[1].size() + voxels_per_cell_ - 1) / voxels_per_cell_; }
  int pixels_per_cell() const { return pixels_per_cell_; }
  double pixels_per_metre() const { return pixels_per_cell_ / (voxels_per_cell_ * edge_); }
  double least_height() const { return origin_z_ + range_[2].least * edge_; }              ///< [m]
  double greatest_height() const { return origin_z_ + (range_[2].greatest + 1) * edge_; }  ///< [m]

  /// Calls visit(cell, voxel) when the voxel is in view; cells count from the upper left, row by row.
  template <class Visit>
  void locate(VoxelKey key, Visit&& visit) const {
    const Eigen::Vector3i voxel = key.voxel();
    const int column = (voxel.x() - range_[0].least) / voxels_per_cell_;
    const int row = (range_[1].greatest - voxel.y()) / voxels_per_cell_;
    if (voxel.x() < range_[0].least || voxel.y() > range_[1].greatest || column >= columns() || row >= rows())
      return;
    visit(static_cast<std::size_t>(row) * static_cast<std::size_t>(columns()) +
              static_cast<std::size_t>(column),
          voxel);
  }

  /// 0 at the lowest leaves in view, 1 at the highest.
  double height_share(int voxel_z) const {
    return (voxel_z - range_[2].least) / std::max(1.0, static_cast<double>(range_[2].size() - 1));
  }

 private:
  double edge_;      ///< [m]
  double origin_z_;  ///< [m] of the grid
  std::array<Range, 3> range_{};
  int voxels_per_cell_ = 1;
  int pixels_per_cell_ = kLeastWidth;
};

/// One colour per cell, then the picture with its footer.
class Canvas {
 public:
  explicit Canvas(const View& view)
      : view_(view),
        cells_(static_cast<std::size_t>(view.columns()) * static_cast<std::size_t>(view.rows()), kGround) {}

  void paint(std::size_t cell, Color color) { cells_[cell] = color; }

  Picture finish(std::string_view title) const {
    const int scale = view_.pixels_per_cell();
    Picture picture(view_.columns() * scale, view_.rows() * scale + kFooter, kGround);
    for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
      const auto columns = static_cast<std::size_t>(view_.columns());
      picture.fill(static_cast<int>(cell % columns) * scale, static_cast<int>(cell / columns) * scale, scale,
                   scale, cells_[cell]);
    }
    picture.fill(0, picture.height() - kFooter, picture.width(), 1, kUnchanged);
    picture.write(kMargin, picture.height() - kMargin - Picture::kTextHeight, title, kInk);
    draw_scale_bar(picture);
    return picture;
  }

 private:
  /// At the right, of the largest 1, 2 or 5 times a power of ten metres that fits a fifth of the width.
  void draw_scale_bar(Picture& picture) const {
    const double most = picture.width() / 5.0 / view_.pixels_per_metre();  // [m]
    double length = std::pow(10, std::floor(std::log10(most)));
    for (const double factor : {5.0, 2.0}) {
      if (factor * length > most) continue;
      length *= factor;
      break;
    }
    const int width = static_cast<int>(std::lround(length * view_.pixels_per_metre()));
    const int x = picture.width() - kMargin - width;
    const int y = picture.height() - kMargin - Picture::kTextHeight;
    picture.fill(x, y + Picture::kTextHeight - 4, width, 4, kInk);
    for (const int end : {x, x + width - 2}) picture.fill(end, y, 2, Picture::kTextHeight, kInk);
    const std::string text = fmt::format("{:g} m", length);
    picture.write(x - kMargin - Picture::text_width(text), y, text, kInk);
  }

  const View& view_;
  std::vector<Color> cells_;
};

constexpr int kLegendX = 160;  // [pixels] behind the longest title
int legend_y(const Picture& picture) { return picture.height() - kMargin - Picture::kTextHeight; }

Picture height_picture(const View& view, const Octree& octree, std::string_view title) {
  Canvas canvas(view);
  std::vector<int> top(static_cast<std::size_t>(view.columns()) * static_cast<std::size_t>(view.rows()),
                       -VoxelKey::kMaxZ - 1);
  octree.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
    if (!leaf.occupied()) return;
    view.locate(key, [&](std::size_t cell, const Eigen::Vector3i& voxel) {
      if (voxel.z() <= top[cell]) return;
      top[cell] = voxel.z();
      canvas.paint(cell, ramp(view.height_share(voxel.z())));
    });
  });
  Picture picture = canvas.finish(title);
  constexpr int kRampWidth = 200;  // [pixels]
  const std::string least = fmt::format("{:.1f} m", view.least_height());
  const int y = legend_y(picture);
  picture.write(kLegendX, y, least, kInk);
  const int x = kLegendX + Picture::text_width(least) + kMargin;
  for (int i = 0; i < kRampWidth; ++i) {
    picture.fill(x + i, y, 1, Picture::kTextHeight, ramp(static_cast<double>(i) / (kRampWidth - 1)));
  }
  picture.write(x + kRampWidth + kMargin, y, fmt::format("{:.1f} m", view.greatest_height()), kInk);
  return picture;
}

Picture change_picture(const View& view, const Octree& after, const MapDifference& difference) {
  Canvas canvas(view);
  const auto paint = [&](VoxelKey key, Color color) {
    view.locate(key, [&](std::size_t cell, const Eigen::Vector3i&) { canvas.paint(cell, color); });
  };
  // Later ones cover earlier ones of the same column.
  after.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
    if (leaf.occupied()) paint(key, kUnchanged);
  });
  for (const VoxelKey key : difference.moved) paint(key, kMoved);
  for (const VoxelKey key : difference.added) paint(key, kAdded);
  for (const VoxelKey key : difference.removed) paint(key, kRemoved);
  Picture picture = canvas.finish("change");
  int x = kLegendX;
  for (const auto& [name, color] :
       {std::pair("unchanged", kUnchanged), {"added", kAdded}, {"removed", kRemoved}, {"moved", kMoved}}) {
    picture.fill(x, legend_y(picture), Picture::kTextHeight, Picture::kTextHeight, color);
    x += Picture::kTextHeight + kMargin / 2;
    picture.write(x, legend_y(picture), name, kInk);
    x += Picture::text_width(name) + 2 * kMargin;
  }
  return picture;
}

}  // namespace

void write_pictures(const std::filesystem::path& folder, const Octree& before, const Octree& after,
                    const MapDifference& difference) {
  const View view(before, after);
  height_picture(view, before, "before").save_png(folder / "before.png");
  height_picture(view, after, "after").save_png(folder / "after.png");
  change_picture(view, after, difference).save_png(folder / "change.png");
}

}  // namespace evermap
