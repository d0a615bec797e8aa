// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include <evermap/geometry/detail/for_each_index.hpp>
#include <evermap/update/detail/encounter.hpp>

namespace evermap {
namespace {

constexpr std::size_t kRaysPerTask = 1024;

/// The fraction of the ray that is known to be free: just before the hit, range noise forbids a verdict.
double free_fraction(const Ray& ray, const Gaussian& bundle, double range_sigma) {
  const double length = ray.length();
  const Eigen::Vector3d u = (ray.end - ray.origin) / length;
  const double sigma_along = std::sqrt(u.dot(bundle.covariance * u));
  return 1 - (3 * range_sigma + 2 * sigma_along) / length;
}

/// The leaves of bricks, in ascending order, that the scan did not hit.
class Unhit {
 public:
  Unhit(const BundleGrid& bundles, VoxelKey first)
      : next_(std::lower_bound(bundles.bundles().begin(), bundles.bundles().end(), first,
                               [](const RayBundle& bundle, VoxelKey key) { return bundle.key < key; })),
        end_(bundles.bundles().end()) {}

  /// REQUIRES: the brick lies behind the one of the call before.
  Mask512 of(const PlacedBrick& brick) {
    Mask512 leaves = brick.brick->mask();
    const VoxelKey last = brick.key(Brick::kChildren - 1);
    for (; next_ != end_ && next_->key <= last; ++next_) {
      if (next_->key >= brick.first) leaves.reset(next_->key.voxel_in_brick());
    }
    return leaves;
  }

 private:
  std::vector<RayBundle>::const_iterator next_, end_;
};

}  // namespace

std::vector<RayFan::Target> looked_at(const BundleGrid& bundles) {
  std::vector<RayFan::Target> targets(bundles.bundles().size());
  for_each_index(targets.size(), kRaysPerTask, [&](std::size_t i) {
    const Gaussian& points = bundles.bundles()[i].points;
    const Ray ray{bundles.origin_map, points.mean};
    targets[i] = {ray.end, free_fraction(ray, points, bundles.range_sigma)};
  });
  return targets;
}

std::vector<Encounter> find_encounters(const BundleGrid& bundles, const RayFan& fan,
                                       std::span<const PlacedBrick> bricks,
                                       const UpdateParameters& parameters) {
  std::vector<Encounter> encounters;
  if (bricks.empty()) return encounters;
  Unhit unhit(bundles, bricks.front().first);
  for (const PlacedBrick& brick : bricks) {
    fan.for_each_met(brick, parameters.trim_leaves ? brick.brick->mask() : unhit.of(brick),
                     [&](std::uint32_t index, const RayFan::Target& target, VoxelKey key, const Leaf& leaf) {
                       leaf.prefetch();
                       encounters.push_back({key, &leaf, index, target});
                     });
  }
  return encounters;
}

}  // namespace evermap
