// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include <evermap/files/file_error.hpp>
#include <evermap/io/detail/atomic_file.hpp>
#include <evermap/io/detail/occupancy_grid.hpp>

namespace evermap {
namespace {

constexpr float kNone = std::numeric_limits<float>::infinity();
constexpr std::int64_t kMostCells = std::int64_t{1} << 28;
constexpr char kOccupied = 0, kFree = static_cast<char>(254), kUnknown = static_cast<char>(205);

/// Values of the cells below and around the map, row by row along x.
struct Cells {
  Eigen::Vector2i least = {0, 0};
  int width = 0, height = 0;
  std::vector<float> values;

  float& at(int x, int y) {
    return values[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
};

template <class Visit>
void for_each_surface(const Octree& octree, Visit&& visit) {
  octree.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
    if (leaf.occupied()) visit(key.voxel(), static_cast<float>(octree.gaussian(key, leaf).mean.z()));
  });
}

Cells cells_around(const Octree& octree, const std::filesystem::path& path) {
  Eigen::Vector2i least = Eigen::Vector2i::Constant(std::numeric_limits<int>::max());
  Eigen::Vector2i greatest = Eigen::Vector2i::Constant(std::numeric_limits<int>::min());
  for_each_surface(octree, [&](const Eigen::Vector3i& voxel, float) {
    least = least.cwiseMin(voxel.head<2>());
    greatest = greatest.cwiseMax(voxel.head<2>());
  });
  Cells cells;
  cells.least = least;
  if (least.x() > greatest.x()) return cells;
  const std::int64_t width = std::int64_t{greatest.x()} - least.x() + 1;
  const std::int64_t height = std::int64_t{greatest.y()} - least.y() + 1;
  if (width * height > kMostCells)
    throw FileError(path, "the map is too wide for one picture: " + std::to_string(width) + " x " +
                              std::to_string(height) + " cells");
  cells.width = static_cast<int>(width);
  cells.height = static_cast<int>(height);
  cells.values.assign(static_cast<std::size_t>(width * height), kNone);
  return cells;
}

constexpr float kStep = 0.15F;      // [m] that a vehicle drives over
constexpr float kClearance = 2.0F;  // [m] that it drives under
constexpr double kSlope = 0.3;      // that it climbs

/// Drops cells that lie on nothing around them: a reflection below the ground would sink all of it.
void drop_unsupported(Cells& cells, double edge) {
  constexpr int kReach = 2;    // cells
  constexpr int kSupport = 6;  // of the 24 around
  const auto tolerance = static_cast<float>(kStep + kSlope * kReach * edge);
  Cells all = cells;
  for (int y = 0; y < all.height; ++y) {
    for (int x = 0; x < all.width; ++x) {
      if (all.at(x, y) == kNone) continue;
      int support = -1;  // without itself
      for (int ny = std::max(y - kReach, 0); ny <= std::min(y + kReach, all.height - 1); ++ny) {
        for (int nx = std::max(x - kReach, 0); nx <= std::min(x + kReach, all.width - 1); ++nx)
          support += std::abs(all.at(nx, ny) - all.at(x, y)) < tolerance ? 1 : 0;
      }
      if (support < kSupport) cells.at(x, y) = kNone;
    }
  }
}

/// The lowest surface of each cell becomes the ground: no higher than a slope allows from any other nearby,
/// so that the roof of a car is none. No farther, so that a hole sinks only its surroundings.
void lower_to_ground(Cells& cells, double edge) {
  constexpr double kReach = 2;  // [m] half of what is wide
  const auto straight = static_cast<float>(kSlope * edge);
  const auto diagonal = static_cast<float>(kSlope * edge * M_SQRT2);
  Cells before;
  const int steps = static_cast<int>(std::ceil(kReach / edge));
  for (int step = 0; step < steps; ++step) {
    before = cells;
    for (int y = 0; y < cells.height; ++y) {
      for (int x = 0; x < cells.width; ++x) {
        float& ground = cells.at(x, y);
        for (int ny = std::max(y - 1, 0); ny <= std::min(y + 1, cells.height - 1); ++ny) {
          for (int nx = std::max(x - 1, 0); nx <= std::min(x + 1, cells.width - 1); ++nx)
            ground = std::min(ground, before.at(nx, ny) + (nx == x || ny == y ? straight : diagonal));
        }
      }
    }
  }
}

}  // namespace

void write_occupancy_grid(const Octree& octree, const std::filesystem::path& path) {
  Cells ground = cells_around(octree, path);
  const auto cell_of = [&](const Eigen::Vector3i& voxel) -> Eigen::Vector2i {
    return voxel.head<2>() - ground.least;
  };
  for_each_surface(octree, [&](const Eigen::Vector3i& voxel, float z) {
    float& lowest = ground.at(cell_of(voxel).x(), cell_of(voxel).y());
    lowest = std::min(lowest, z);
  });
  drop_unsupported(ground, octree.grid().edge);
  lower_to_ground(ground, octree.grid().edge);
  std::string pixels(ground.values.size(), kUnknown);
  for_each_surface(octree, [&](const Eigen::Vector3i& voxel, float z) {
    const Eigen::Vector2i cell = cell_of(voxel);
    const float above = z - ground.at(cell.x(), cell.y());
    const auto row = static_cast<std::size_t>(ground.height - 1 - cell.y());  // pictures begin at the top
    char& pixel = pixels[row * static_cast<std::size_t>(ground.width) + static_cast<std::size_t>(cell.x())];
    if (above > kClearance) return;
    pixel = above > kStep || pixel == kOccupied ? kOccupied : kFree;
  });
  AtomicFile picture(path);
  picture.write("P5\n" + std::to_string(ground.width) + " " + std::to_string(ground.height) + "\n255\n");
  picture.write(pixels);
  const double edge = octree.grid().edge;
  const Eigen::Vector2d corner =
      ground.values.empty()
          ? Eigen::Vector2d(0, 0)
          : Eigen::Vector2d(octree.grid().origin.head<2>() + edge * ground.least.cast<double>());
  std::array<char, 300> text{};
  std::snprintf(
      text.data(), text.size(),
      "resolution: %.9g\norigin: [%.9g, %.9g, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
      edge, corner.x(), corner.y());
  std::filesystem::path description = path;
  AtomicFile yaml(description.replace_extension(".yaml"));
  yaml.write("image: " + path.filename().string() + "\nmode: trinary\n" + text.data());
  picture.commit();
  yaml.commit();
}

}  // namespace evermap
