// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/LU>

#include <evermap/geometry/detail/for_each_index.hpp>
#include <evermap/geometry/detail/neighbourhood.hpp>
#include <evermap/geometry/detail/running_median.hpp>
#include <evermap/update/detail/encounter.hpp>
#include <evermap/update/detail/evidence.hpp>
#include <evermap/update/detail/impact.hpp>
#include <evermap/update/detail/surroundings.hpp>

namespace evermap {
namespace {

constexpr std::size_t kItemsPerTask = 32;  ///< bricks or leaves

/// The leaves of one brick after the other, each judged by all rays that met it.
class JudgedBrick {
 public:
  JudgedBrick(const Octree& octree, const Eigen::Vector3d& origin_map, const AlignmentError& error,
              const UpdateParameters& parameters)
      : octree_(octree), origin_map_(origin_map), error_(error), parameters_(parameters) {}

  JudgedLeaf& leaf_of(const Encounter& encounter) {
    if (leaves_.empty() || encounter.key.brick() != brick_) {
      brick_ = encounter.key.brick();
      leaves_.clear();
      place_.fill(kNone);
    }
    std::int16_t& place = place_[static_cast<std::size_t>(encounter.key.voxel_in_brick())];
    if (place == kNone) {
      place = static_cast<std::int16_t>(leaves_.size());
      const Gaussian leaf = octree_.gaussian(encounter.key, *encounter.leaf);
      const double error = error_.at((leaf.mean - origin_map_).norm());
      leaves_.emplace_back(leaf, octree_.grid().edge, error, parameters_);
    }
    return leaves_[static_cast<std::size_t>(place)];
  }

 private:
  static constexpr std::int16_t kNone = -1;

  const Octree& octree_;
  const Eigen::Vector3d& origin_map_;
  const AlignmentError& error_;
  const UpdateParameters& parameters_;
  std::uint64_t brick_ = 0;
  std::vector<JudgedLeaf> leaves_;
  std::array<std::int16_t, Brick::kChildren> place_{};  ///< of a voxel's leaf among them
};

/// Who contradicts the leaves of these bricks, sorted by leaf.
std::vector<Contradiction> gather(const Octree& octree, const BundleGrid& bundles, const RayFan& fan,
                                  std::span<const PlacedBrick> bricks, const AlignmentError& error,
                                  const UpdateParameters& parameters) {
  std::vector<Contradiction> found;
  JudgedBrick brick(octree, bundles.origin_map, error, parameters);
  for (const Encounter& encounter : find_encounters(bundles, fan, bricks, parameters)) {
    const RayBundle& bundle = bundles.bundles()[encounter.bundle];
    const Ray ray{bundles.origin_map, encounter.target.end_map};
    const double value =
        brick.leaf_of(encounter).impact(ray, bundle.points.covariance, encounter.target.until);
    if (value <= 0 || encounter.key == bundle.key) continue;
    found.push_back({encounter.key, encounter.bundle, static_cast<float>(value)});
  }
  std::sort(found.begin(), found.end(), [](const Contradiction& a, const Contradiction& b) {
    return a.leaf != b.leaf ? a.leaf < b.leaf : a.bundle < b.bundle;
  });
  return found;
}

/// All contradictions, sorted by leaf. Chunks have a fixed size and are joined in order, whoever worked on
/// them.
std::vector<Contradiction> find_contradictions(const Octree& octree, const BundleGrid& bundles,
                                               const AlignmentError& error,
                                               const UpdateParameters& parameters) {
  const RayFan fan(octree.grid(), bundles.origin_map, looked_at(bundles));
  const std::vector<PlacedBrick> bricks = octree.bricks_in(fan.voxels());
  std::vector<std::vector<Contradiction>> found(chunks(bricks.size(), kItemsPerTask));
  for_each_chunk(bricks.size(), kItemsPerTask, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    const auto stretch = std::span(bricks).subspan(begin, end - begin);
    found[chunk] = gather(octree, bundles, fan, stretch, error, parameters);
  });
  std::vector<Contradiction> all;
  for (const auto& chunk : found) all.insert(all.end(), chunk.begin(), chunk.end());
  return all;
}

double combine(std::span<const Contradiction> contradictions, Combination combination) {
  double greatest = 0;
  double none = 1;  // probability that no contradiction holds
  for (const Contradiction& c : contradictions) {
    greatest = std::max(greatest, static_cast<double>(c.impact));
    none *= 1 - static_cast<double>(c.impact);
  }
  return combination == Combination::kMaximum ? greatest : 1 - none;
}

/// Whether this neighbouring hit may be the leaf's own surface, seen up to `tolerance` [m] from where it is.
/// Within its plane a flat leaf has all of the tolerance. Across it, a third: what came close in front of a
/// surface must not hide that the surface is gone.
bool fits(const Gaussian& leaf, const Plane& plane, const Gaussian& hit, double tolerance) {
  constexpr double kAcross = 1.0 / 3;
  const Eigen::Vector3d across = plane.flat ? plane.normal : Eigen::Vector3d::Zero();
  Gaussian blurred = hit;
  blurred.covariance += tolerance * tolerance *
                        (Eigen::Matrix3d::Identity() - (1 - kAcross * kAcross) * across * across.transpose());
  return mahalanobis_squared(leaf.mean, blurred) < kChiSquared99;
}

/// Whether the scan sees the leaf's surface in a neighbouring voxel.
bool is_reobserved(VoxelKey key, const Gaussian& leaf, const Plane& plane, const BundleGrid& bundles,
                   double tolerance) {
  return any_in_neighbourhood(key, [&](VoxelKey near) {
    const RayBundle* hit = bundles.find(near);
    return hit != nullptr && fits(leaf, plane, hit->points, tolerance);
  });
}

/// Whether the ray goes through the plane within `reach` [m] of this point on it.
bool goes_through(const Plane& plane, const Eigen::Vector3d& on_plane, double reach, const Ray& ray) {
  const double origin_side = plane.normal.dot(ray.origin - on_plane);
  const double end_side = plane.normal.dot(ray.end - on_plane);
  if (origin_side * end_side >= 0) return false;
  const double fraction = origin_side / (origin_side - end_side);
  return (ray.origin + fraction * (ray.end - ray.origin) - on_plane).norm() < reach;
}

/// Few points, or both faces of a slab, make no plane by themselves, and in a corner two planes meet: rays
/// along a ceiling, or past the foot of a wall, would tear such a leaf. It lies in the plane of its
/// surroundings or in those that meet in it, if there are any, and contradictions by rays that go through
/// none of them at the leaf are taken back. In a corner, a ray that is off by `error` [m] must end beyond the
/// plane: many end on one of its surfaces.
void heed_surroundings(const Octree& octree, VoxelKey key, const Gaussian& leaf, const BundleGrid& bundles,
                       double error, const UpdateParameters& parameters,
                       std::span<Contradiction> contradictions) {
  const double reach = octree.grid().edge;
  const Plane around = plane_around(octree, key);
  const std::vector<PlacedPlane> corner =
      around.flat ? std::vector<PlacedPlane>{} : corner_around(octree, key, leaf);
  if (!around.flat && corner.empty()) return;
  for (Contradiction& c : contradictions) {
    const Ray ray{bundles.origin_map, bundles.bundles()[c.bundle].points.mean};
    const bool is_through = around.flat
                                ? goes_through(around, leaf.mean, reach, ray)
                                : std::any_of(corner.begin(), corner.end(), [&](const PlacedPlane& side) {
                                    return crosses(side.plane, side.on_plane, ray, error, parameters) &&
                                           goes_through(side.plane, side.on_plane, reach, ray);
                                  });
    if (!is_through) c.impact = 0;
  }
}

/// How far a bundle is off its leaf's plane.
struct Offset {
  double range;     ///< [m]
  double distance;  ///< [m]
};

/// The median range, and the robust standard deviation of the distances.
Offset spread(std::span<const Offset> offsets) {
  std::vector<double> values;
  values.reserve(offsets.size());
  const auto median = [&](double Offset::*member) {
    values.clear();
    for (const Offset& offset : offsets) values.push_back(offset.*member);
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  };
  return {median(&Offset::range), kMedianToSigma * median(&Offset::distance)};
}

}  // namespace

AlignmentError alignment_error(const Octree& octree, const BundleGrid& bundles) {
  constexpr std::size_t kSamples = 2000;  // bundles that are asked, evenly over the scan
  constexpr std::size_t kEnough = 50;     // flat places that tell the error to about 10 %
  constexpr double kMinLeafCount = 10;    // [points] fewer do not make a plane
  constexpr double kMinBundleCount = 3;   // [points] fewer are mostly range noise
  constexpr double kUnknown = 0.01;       // [m] a moderate error, where too little is flat to tell
  const std::vector<RayBundle>& all = bundles.bundles();
  const std::size_t step = 1 + all.size() / kSamples;
  std::vector<std::optional<Offset>> asked(chunks(all.size(), step));
  for_each_index(asked.size(), kItemsPerTask, [&](std::size_t i) {
    const RayBundle& bundle = all[i * step];
    const Leaf* leaf = octree.find(bundle.key);
    if (leaf == nullptr || !leaf->occupied() || leaf->count < kMinLeafCount) return;
    if (bundle.points.count < kMinBundleCount) return;
    const Gaussian surface = octree.gaussian(bundle.key, *leaf);
    const Plane plane = plane_of(surface);
    if (!plane.flat) return;
    asked[i] = {(bundle.points.mean - bundles.origin_map).norm(),
                std::abs(plane.normal.dot(bundle.points.mean - surface.mean))};
  });
  std::vector<Offset> offsets;
  for (const auto& offset : asked) {
    if (offset) offsets.push_back(*offset);
  }
  if (offsets.size() < kEnough) return {kUnknown, 0};
  if (offsets.size() < 2 * kEnough) return {spread(offsets).distance, 0};
  std::stable_sort(offsets.begin(), offsets.end(),
                   [](const Offset& a, const Offset& b) { return a.range < b.range; });
  const std::span<Offset> sorted(offsets);
  const Offset near = spread(sorted.first(sorted.size() / 2));
  const Offset far = spread(sorted.subspan(sorted.size() / 2));
  // near = position^2 + direction^2 range^2, and so is far.
  const auto square = [](double x) { return x * x; };
  const double grown = std::max(0.0, square(far.distance) - square(near.distance));
  const double direction_squared = grown / std::max(1e-6, square(far.range) - square(near.range));
  const double position_squared = square(near.distance) - direction_squared * square(near.range);
  return {std::sqrt(std::max(0.0, position_squared)), std::sqrt(direction_squared)};
}

double contradicting_fraction(const Evidence& evidence, const BundleGrid& bundles) {
  std::vector<bool> is_counted(bundles.bundles().size(), false);
  std::size_t count = 0;
  for (const LeafEvidence& against : evidence.leaves) {
    if (against.impact == 0) continue;
    const auto rays = against.among(evidence.contradictions);
    const auto next = std::find_if(rays.begin(), rays.end(), [&](const Contradiction& c) {
      return c.impact > 0 && !is_counted[c.bundle];
    });
    if (next == rays.end()) continue;
    is_counted[next->bundle] = true;
    ++count;
  }
  return static_cast<double>(count) / std::max(1.0, static_cast<double>(is_counted.size()));
}

Evidence trace(const Octree& octree, const BundleGrid& bundles, const UpdateParameters& parameters) {
  const bool is_asked = parameters.hit_margin > 0 || parameters.surface_crossing ||
                        parameters.spare_reobserved || parameters.settled > 0;
  const AlignmentError error = is_asked ? alignment_error(octree, bundles) : AlignmentError{};
  Evidence evidence{find_contradictions(octree, bundles, error, parameters), {}, error};
  const auto& all = evidence.contradictions;
  for (std::uint32_t begin = 0; begin < all.size();) {
    std::uint32_t end = begin + 1;
    while (end < all.size() && all[end].leaf == all[begin].leaf) ++end;
    evidence.leaves.push_back({all[begin].leaf, 0, begin, end});
    begin = end;
  }
  for_each_index(evidence.leaves.size(), kItemsPerTask, [&](std::size_t i) {
    LeafEvidence& against = evidence.leaves[i];
    if (bundles.find(against.leaf) != nullptr) return;  // occupied wins
    const Gaussian leaf = octree.gaussian(against.leaf, *octree.find(against.leaf));
    const Plane plane = plane_of(leaf);
    const double error_there = error.at((leaf.mean - bundles.origin_map).norm());
    const double tolerance = parameters.surface_tolerance * error_there;
    if (parameters.spare_reobserved && is_reobserved(against.leaf, leaf, plane, bundles, tolerance)) return;
    const auto contradictions = against.among(evidence.contradictions);
    if (parameters.surface_crossing && !plane.flat)
      heed_surroundings(octree, against.leaf, leaf, bundles, error_there, parameters, contradictions);
    against.impact = combine(contradictions, parameters.combination);
  });
  return evidence;
}

}  // namespace evermap
