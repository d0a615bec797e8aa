// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <span>

#include <Eigen/LU>
#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <evermap/map/traversal.hpp>
#include <evermap/update/evidence.hpp>
#include <evermap/update/impact.hpp>

namespace evermap {
namespace {

constexpr std::size_t kGrain = 256;  ///< bundles or leaves per task: some 0.1 ms of work

/// How far the ray is known to be free [m]: range noise forbids a verdict just before the hit.
double free_length(const Ray& ray, const Gaussian& bundle, const UpdateParameters& parameters) {
  const double length = ray.length();
  const Eigen::Vector3d u = (ray.end - ray.origin) / length;
  const double sigma_along = std::sqrt(u.dot(bundle.covariance * u));
  return length - std::max(parameters.end_guard, 3 * parameters.lidar.range_sigma + 2 * sigma_along);
}

void trace_bundle(const Octree& octree, const BundleGrid& bundles, std::uint32_t index,
                  const UpdateParameters& parameters, std::vector<Contradiction>& found) {
  const RayBundle& bundle = bundles.bundles()[index];
  const Ray ray{bundles.origin_map, bundle.points.mean};
  const double free = free_length(ray, bundle.points, parameters);
  if (free <= 0) return;
  // A hit voxel takes no miss; it is looked at all the same when its geometry may be trimmed.
  const bool trims = parameters.difference != Difference::kNone;
  traverse(octree, ray, [&](VoxelKey key, const Leaf& leaf, double entry, double) {
    if (entry > free || key == bundle.key || (!trims && bundles.find(key) != nullptr)) return;
    const double value = impact(octree.gaussian(key, leaf), ray, bundle.points, free, parameters);
    if (value > 0) found.push_back({key, index, static_cast<float>(value)});
  });
}

/// All contradictions, sorted by leaf. Chunks have a fixed size and are joined in order, whoever worked on
/// them.
std::vector<Contradiction> find_contradictions(const Octree& octree, const BundleGrid& bundles,
                                               const UpdateParameters& parameters) {
  const std::size_t count = bundles.bundles().size();
  std::vector<std::vector<Contradiction>> chunks((count + kGrain - 1) / kGrain);
  oneapi::tbb::parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t chunk) {
    const std::size_t end = std::min(count, (chunk + 1) * kGrain);
    for (std::size_t i = chunk * kGrain; i < end; ++i) {
      trace_bundle(octree, bundles, static_cast<std::uint32_t>(i), parameters, chunks[chunk]);
    }
  });
  std::vector<Contradiction> all;
  for (const auto& chunk : chunks) all.insert(all.end(), chunk.begin(), chunk.end());
  std::sort(all.begin(), all.end(), [](const Contradiction& a, const Contradiction& b) {
    return a.leaf != b.leaf ? a.leaf < b.leaf : a.bundle < b.bundle;
  });
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

/// Whether this neighbouring hit lies in the plane of the leaf.
bool is_coplanar(const Gaussian& leaf, const Plane& plane, const Gaussian& hit) {
  constexpr double kMaxOffset = 0.06;  // [m]
  constexpr double kMinCosine = 0.95;
  return plane.flat && std::abs(plane.normal.dot(hit.mean - leaf.mean)) < kMaxOffset &&
         std::abs(plane.normal.dot(plane_of(hit).normal)) > kMinCosine;
}

/// Whether this neighbouring hit may be the leaf's own surface, seen displaced by the pose's error.
bool fits(const Gaussian& leaf, const Gaussian& hit, double pose_sigma) {
  Gaussian blurred = leaf;
  blurred.covariance += hit.covariance + pose_sigma * pose_sigma * Eigen::Matrix3d::Identity();
  return mahalanobis_squared(hit.mean, blurred) < kChiSquared99;
}

bool is_spared(const Octree& octree, VoxelKey key, const BundleGrid& bundles,
               const UpdateParameters& parameters) {
  if (bundles.find(key) != nullptr) return true;
  if (parameters.surface_guard == SurfaceGuard::kNone) return false;
  const Gaussian leaf = octree.gaussian(key, *octree.find(key));
  const bool coplanar = parameters.surface_guard == SurfaceGuard::kCoplanarHit;
  const Plane plane = coplanar ? plane_of(leaf) : Plane{};
  const Eigen::Vector3i center = key.voxel();
  for (int i = 0; i < 27; ++i) {
    const Eigen::Vector3i voxel = center + Eigen::Vector3i(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    if (!VoxelKey::in_range(voxel)) continue;
    const RayBundle* hit = bundles.find(VoxelKey::from_voxel(voxel));
    if (hit == nullptr) continue;
    if (coplanar ? is_coplanar(leaf, plane, hit->points) : fits(leaf, hit->points, parameters.pose_sigma)) {
      return true;
    }
  }
  return false;
}

}  // namespace

Evidence trace(const Octree& octree, const BundleGrid& bundles, const UpdateParameters& parameters) {
  Evidence evidence{find_contradictions(octree, bundles, parameters), {}};
  const auto& all = evidence.contradictions;
  for (std::uint32_t begin = 0; begin < all.size();) {
    std::uint32_t end = begin + 1;
    while (end < all.size() && all[end].leaf == all[begin].leaf) ++end;
    evidence.leaves.push_back({all[begin].leaf, 0, begin, end});
    begin = end;
  }
  oneapi::tbb::parallel_for(
      oneapi::tbb::blocked_range<std::size_t>(0, evidence.leaves.size(), kGrain), [&](const auto& range) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) {
          LeafEvidence& leaf = evidence.leaves[i];
          if (is_spared(octree, leaf.leaf, bundles, parameters)) continue;
          leaf.impact =
              combine(std::span(all).subspan(leaf.begin, leaf.end - leaf.begin), parameters.combination);
        }
      });
  return evidence;
}

}  // namespace evermap
