// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <limits>
#include <span>
#include <vector>

#include <evermap/geometry/for_each_index.hpp>
#include <evermap/update/impact.hpp>
#include <evermap/update/leaf_update.hpp>
#include <evermap/update/map_updater.hpp>

namespace evermap {
namespace {

constexpr std::size_t kGrain = 256;  ///< leaves per task

/// Takes from the leaf's geometry what the contradicting rays saw to be free; occupancy decides on its life.
void trim(Leaf& leaf, const Eigen::Vector3d& center_map, double thickness,
          std::span<const Contradiction> contradictions, const BundleGrid& bundles, Difference difference) {
  Gaussian surface = leaf.gaussian(center_map);
  for (const Contradiction& c : contradictions) {
    const Gaussian& bundle = bundles.bundles()[c.bundle].points;
    const Ray ray{bundles.origin_map, bundle.mean};
    if (difference == Difference::kSoft) {
      surface = soft_difference(surface, ray, bundle, static_cast<double>(c.impact));
    } else {
      const double t = closest_resemblance(ray, bundle.covariance, surface);
      surface = sigma_point_difference(surface, bundle_at(t, ray, bundle.covariance)).value_or(surface);
    }
    surface.covariance = floor_eigenvalues(surface.covariance, thickness * thickness / 4);
  }
  leaf.set_gaussian(surface, center_map);
}

/// Subtractive: every contradicted leaf has one owner; what is to go is erased afterwards, since that moves
/// leaves.
void contradict_leaves(Octree& octree, const BundleGrid& bundles, const Evidence& evidence,
                       const UpdateParameters& parameters) {
  const double thickness = least_thickness(parameters.lidar, octree.grid());
  std::vector<char> erased(evidence.leaves.size(), 0);
  for_each_index(evidence.leaves.size(), kGrain, [&](std::size_t i) {
    const LeafEvidence& against = evidence.leaves[i];
    Leaf& leaf = *octree.find(against.leaf);
    if (parameters.difference != Difference::kNone) {
      const auto contradictions =
          std::span(evidence.contradictions).subspan(against.begin, against.end - against.begin);
      trim(leaf, octree.grid().center(against.leaf), thickness, contradictions, bundles,
           parameters.difference);
    }
    erased[i] = against.impact > 0 && !contradict(leaf, against.impact, parameters);
  });
  for (std::size_t i = 0; i < erased.size(); ++i) {
    if (erased[i]) octree.erase(evidence.leaves[i].leaf);
  }
}

/// Additive: leaves that exist are confirmed in parallel; new ones are made one by one, since that moves
/// leaves.
void confirm_leaves(Octree& octree, const BundleGrid& bundles, const UpdateParameters& parameters,
                    double novelty) {
  const auto& all = bundles.bundles();
  std::vector<char> is_new(all.size(), 0);
  for_each_chunk(all.size(), kGrain, [&](std::size_t, std::size_t begin, std::size_t end) {
    LeafFinder leaves(octree);
    for (std::size_t i = begin; i < end; ++i) {
      Leaf* leaf = leaves.find(all[i].key);
      is_new[i] = leaf == nullptr;
      if (leaf == nullptr) continue;
      Gaussian seen = all[i].points;
      seen.count *= novelty;
      confirm(*leaf, seen, octree.grid().center(all[i].key), parameters);
    }
  });
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!is_new[i]) continue;
    confirm(octree.find_or_insert(all[i].key), all[i].points, octree.grid().center(all[i].key), parameters);
  }
}

}  // namespace

ScanSummary summarize(const Scan& scan, const BundleGrid& bundles) {
  return {scan.p_sensor.size(), bundles.bundles().size(), bundles.dropped_near, bundles.dropped_far,
          bundles.dropped_out_of_grid};
}

ScanSummary add_scan(Octree& octree, const Scan& scan, const Pose& T_map_sensor,
                     const UpdateParameters& parameters) {
  UpdateParameters trusting = parameters;
  trusting.confirmations = 1;
  const BundleGrid bundles = condense(scan, T_map_sensor, octree.grid(), parameters.lidar);
  confirm_leaves(octree, bundles, trusting, 1);
  return summarize(scan, bundles);
}

ScanSummary add_cloud(Octree& octree, const Scan& cloud, const Pose& T_map_cloud,
                      const UpdateParameters& parameters) {
  UpdateParameters trusting = parameters;
  trusting.lidar.min_range = 0;
  trusting.lidar.max_range = std::numeric_limits<double>::infinity();
  trusting.hit = parameters.max_log_odds;
  return add_scan(octree, cloud, T_map_cloud, trusting);
}

ScanSummary update(Octree& octree, const Scan& scan, const Pose& T_map_sensor,
                   const UpdateParameters& parameters, double novelty) {
  const BundleGrid bundles = condense(scan, T_map_sensor, octree.grid(), parameters.lidar);
  apply(octree, bundles, trace(octree, bundles, parameters), parameters, novelty);
  return summarize(scan, bundles);
}

void apply(Octree& octree, const BundleGrid& bundles, const Evidence& evidence,
           const UpdateParameters& parameters, double novelty) {
  contradict_leaves(octree, bundles, evidence, parameters);
  confirm_leaves(octree, bundles, parameters, novelty);
}

}  // namespace evermap
