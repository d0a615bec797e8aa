// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <span>

#include <Eigen/LU>

#include <evermap/geometry/detail/for_each_index.hpp>
#include <evermap/geometry/detail/neighbourhood.hpp>
#include <evermap/update/detail/encounter.hpp>
#include <evermap/update/detail/evidence.hpp>
#include <evermap/update/detail/impact.hpp>

namespace evermap {
namespace {

constexpr std::size_t kItemsPerTask = 32;  ///< bricks or leaves

/// Who contradicts the leaves of these bricks, sorted by leaf.
std::vector<Contradiction> gather(const Octree& octree, const BundleGrid& bundles, const RayFan& fan,
                                  std::span<const PlacedBrick> bricks, double error,
                                  const UpdateParameters& parameters) {
  std::vector<Contradiction> found;
  for (const Encounter& encounter : find_encounters(bundles, fan, bricks, parameters)) {
    const RayBundle& bundle = bundles.bundles()[encounter.bundle];
    const Ray ray{bundles.origin_map, encounter.target.end_map};
    const double value = impact(octree.gaussian(encounter.key, *encounter.leaf), octree.grid().edge, ray,
                                bundle.points.covariance, encounter.target.until, error, parameters);
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
std::vector<Contradiction> find_contradictions(const Octree& octree, const BundleGrid& bundles, double error,
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

/// The plane in which a leaf and those around it lie together.
Plane plane_around(const Octree& octree, VoxelKey key) {
  constexpr int kLeast = 4;  // leaves; fewer lie in a plane anyhow
  Gaussian around;
  for_each_in_neighbourhood(key, [&](VoxelKey near) {
    const Leaf* leaf = octree.find(near);
    if (leaf == nullptr || !leaf->occupied()) return;
    const Gaussian surface = octree.gaussian(near, *leaf);
    around = merge(around, {surface.mean, surface.covariance, 1});  // each leaf as much as another
  });
  return around.count < kLeast ? Plane{} : plane_of(around);
}

/// Whether the ray goes through the plane within `reach` [m] of this point on it.
bool goes_through(const Plane& plane, const Eigen::Vector3d& on_plane, double reach, const Ray& ray) {
  const double origin_side = plane.normal.dot(ray.origin - on_plane);
  const double end_side = plane.normal.dot(ray.end - on_plane);
  if (origin_side * end_side >= 0) return false;
  const double fraction = origin_side / (origin_side - end_side);
  return (ray.origin + fraction * (ray.end - ray.origin) - on_plane).norm() < reach;
}

/// Few points, or both faces of a slab, make no plane by themselves: rays along a ceiling that pass them by
/// would tear it. Such a leaf lies in the plane of its surroundings, if they have one, and contradictions by
/// rays that do not go through that one at the leaf are taken back.
void heed_surroundings(const Octree& octree, VoxelKey key, const Gaussian& leaf, const BundleGrid& bundles,
                       std::span<Contradiction> contradictions) {
  const Plane plane = plane_around(octree, key);
  if (!plane.flat) return;
  for (Contradiction& c : contradictions) {
    const Ray ray{bundles.origin_map, bundles.bundles()[c.bundle].points.mean};
    if (!goes_through(plane, leaf.mean, octree.grid().edge, ray)) c.impact = 0;
  }
}

}  // namespace

double alignment_error(const Octree& octree, const BundleGrid& bundles) {
  constexpr std::size_t kSamples = 2000;     // bundles that are asked, evenly over the scan
  constexpr std::size_t kEnough = 50;        // flat places that tell the error to about 10 %
  constexpr double kMinLeafCount = 10;       // [points] fewer do not make a plane
  constexpr double kMinBundleCount = 3;      // [points] fewer are mostly range noise
  constexpr double kUnknown = 0.01;          // [m] a moderate error, where too little is flat to tell
  constexpr double kMedianToSigma = 1.4826;  // of a normal distribution
  const std::vector<RayBundle>& all = bundles.bundles();
  const std::size_t step = 1 + all.size() / kSamples;
  constexpr double kNotFlat = -1;
  std::vector<double> offsets(chunks(all.size(), step), kNotFlat);
  for_each_index(offsets.size(), kItemsPerTask, [&](std::size_t i) {
    const RayBundle& bundle = all[i * step];
    const Leaf* leaf = octree.find(bundle.key);
    if (leaf == nullptr || !leaf->occupied() || leaf->count < kMinLeafCount) return;
    if (bundle.points.count < kMinBundleCount) return;
    const Gaussian surface = octree.gaussian(bundle.key, *leaf);
    const Plane plane = plane_of(surface);
    if (plane.flat) offsets[i] = std::abs(plane.normal.dot(bundle.points.mean - surface.mean));
  });
  std::erase(offsets, kNotFlat);
  if (offsets.size() < kEnough) return kUnknown;
  const auto middle = offsets.begin() + static_cast<std::ptrdiff_t>(offsets.size() / 2);
  std::nth_element(offsets.begin(), middle, offsets.end());
  return kMedianToSigma * *middle;
}

double contradicting_fraction(const Evidence& evidence, const BundleGrid& bundles) {
  std::vector<bool> contradicts(bundles.bundles().size(), false);
  for (const LeafEvidence& against : evidence.leaves) {
    if (against.impact == 0) continue;
    for (std::uint32_t i = against.begin; i < against.end; ++i) {
      const Contradiction& c = evidence.contradictions[i];
      if (c.impact > 0) contradicts[c.bundle] = true;
    }
  }
  const auto count = std::count(contradicts.begin(), contradicts.end(), true);
  return static_cast<double>(count) / std::max(1.0, static_cast<double>(contradicts.size()));
}

Evidence trace(const Octree& octree, const BundleGrid& bundles, const UpdateParameters& parameters) {
  const bool is_asked = parameters.hit_margin > 0 || parameters.surface_crossing ||
                        parameters.spare_reobserved || parameters.settled > 0;
  const double error = is_asked ? alignment_error(octree, bundles) : 0;
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
    const double tolerance = parameters.surface_tolerance * error;
    if (parameters.spare_reobserved && is_reobserved(against.leaf, leaf, plane, bundles, tolerance)) return;
    const auto contradictions =
        std::span(evidence.contradictions).subspan(against.begin, against.end - against.begin);
    if (parameters.surface_crossing && !plane.flat)
      heed_surroundings(octree, against.leaf, leaf, bundles, contradictions);
    against.impact = combine(contradictions, parameters.combination);
  });
  return evidence;
}

}  // namespace evermap
