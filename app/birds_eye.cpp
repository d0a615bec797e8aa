// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "birds_eye.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "picture.hpp"
#include <evermap/io/detail/atomic_file.hpp>

namespace evermap {
namespace {

constexpr int kLeastWidth = 1000;   // [pixels]
constexpr int kMostColumns = 4096;  // larger maps are drawn coarser, which bounds memory
constexpr int kMargin = 12;         // [pixels]
constexpr int kBar = 14;            // [pixels] height of what explains a picture, below it
constexpr int kFooter = kBar + 2 * kMargin;
constexpr double kCroppedSide = 0.0025;  // fraction of the leaves left out at each side of the area
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
Color ramp(double fraction) {
  constexpr std::array<std::array<double, 3>, 8> kStops = {{{68, 1, 84},
                                                            {71, 44, 122},
                                                            {59, 81, 139},
                                                            {44, 113, 142},
                                                            {33, 144, 141},
                                                            {39, 173, 129},
                                                            {92, 200, 99},
                                                            {170, 220, 50}}};
  const double at = std::clamp(fraction, 0.0, 1.0) * (kStops.size() - 1);
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

/// The range of values without that fraction at each end. REQUIRES: there are values.
Range cropped(std::vector<int>& values, double fraction) {
  const auto cut = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size()));
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
  /// [m] The largest 1, 2 or 5 times a power of ten that fits a fifth of the width.
  double scale_bar() const {
    const double most = columns() * pixels_per_cell_ / 5.0 / pixels_per_metre();
    const double power = std::pow(10, std::floor(std::log10(most)));
    return (5 * power <= most ? 5 : 2 * power <= most ? 2 : 1) * power;
  }
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
  double height_fraction(int voxel_z) const {
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

  Picture finish() const {
    const int scale = view_.pixels_per_cell();
    Picture picture(view_.columns() * scale, view_.rows() * scale + kFooter, kGround);
    for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
      const auto columns = static_cast<std::size_t>(view_.columns());
      picture.fill(static_cast<int>(cell % columns) * scale, static_cast<int>(cell / columns) * scale, scale,
                   scale, cells_[cell]);
    }
    picture.fill(0, picture.height() - kFooter, picture.width(), 1, kUnchanged);
    draw_scale_bar(picture);
    return picture;
  }

 private:
  /// At the right.
  void draw_scale_bar(Picture& picture) const {
    const int width = static_cast<int>(std::lround(view_.scale_bar() * view_.pixels_per_metre()));
    const int x = picture.width() - kMargin - width;
    const int y = picture.height() - kMargin - kBar;
    picture.fill(x, y + kBar - 4, width, 4, kInk);
    for (const int end : {x, x + width - 2}) picture.fill(end, y, 2, kBar, kInk);
  }

  const View& view_;
  std::vector<Color> cells_;
};

Picture height_picture(const View& view, const Octree& octree) {
  Canvas canvas(view);
  std::vector<int> top(static_cast<std::size_t>(view.columns()) * static_cast<std::size_t>(view.rows()),
                       -VoxelKey::kMaxZ - 1);
  octree.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
    if (!leaf.occupied()) return;
    view.locate(key, [&](std::size_t cell, const Eigen::Vector3i& voxel) {
      if (voxel.z() <= top[cell]) return;
      top[cell] = voxel.z();
      canvas.paint(cell, ramp(view.height_fraction(voxel.z())));
    });
  });
  Picture picture = canvas.finish();
  constexpr int kRampWidth = 200;  // [pixels]
  for (int i = 0; i < kRampWidth; ++i) {
    picture.fill(kMargin + i, picture.height() - kMargin - kBar, 1, kBar,
                 ramp(static_cast<double>(i) / (kRampWidth - 1)));
  }
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
  return canvas.finish();
}

/// What the pictures show, in words: they hold none.
std::string legend(const View& view) {
  return fmt::format(
      "Maps from above, north (y) up; the bar at the lower right is {:g} m long.\n"
      "before.png, after.png: height of the highest leaf, from {:.1f} m (dark violet) to {:.1f} m (light "
      "green).\n"
      "change.png: grey unchanged, blue added, orange removed, pink moved.\n",
      view.scale_bar(), view.least_height(), view.greatest_height());
}

}  // namespace

void write_pictures(const std::filesystem::path& folder, const Octree& before, const Octree& after,
                    const MapDifference& difference) {
  const View view(before, after);
  height_picture(view, before).save_png(folder / "before.png");
  height_picture(view, after).save_png(folder / "after.png");
  change_picture(view, after, difference).save_png(folder / "change.png");
  AtomicFile file(folder / "legend.txt");
  file.write(legend(view));
  file.commit();
}

}  // namespace evermap
