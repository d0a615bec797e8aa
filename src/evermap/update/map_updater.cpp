// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include <evermap/geometry/detail/for_each_index.hpp>
#include <evermap/map/detail/leaf_finder.hpp>
#include <evermap/update/detail/impact.hpp>
#include <evermap/update/detail/leaf_update.hpp>
#include <evermap/update/detail/map_updater.hpp>
#include <evermap/update/detail/paper_impact.hpp>

namespace evermap {
namespace {

constexpr std::size_t kLeavesPerTask = 256;

/// Takes from the leaf's geometry what the contradicting rays saw to be free; occupancy decides on its life.
void trim(Leaf& leaf, const Eigen::Vector3d& center_map, double thickness,
          std::span<const Contradiction> contradictions, const BundleGrid& bundles) {
  Gaussian surface = leaf.gaussian(center_map);
  for (const Contradiction& c : contradictions) {
    const Gaussian& bundle = bundles.bundles()[c.bundle].points;
    const Ray ray{bundles.origin_map, bundle.mean};
    const double t = closest_resemblance(ray, bundle.covariance, surface);
    surface = sigma_point_difference(surface, bundle_at(t, ray, bundle.covariance)).value_or(surface);
    surface.covariance = floor_eigenvalues(surface.covariance, thickness * thickness / 4);
  }
  leaf.set_gaussian(surface, center_map);
}

/// Subtractive: every contradicted leaf has one owner; what is to go is erased afterwards, since that moves
/// leaves. Returns the occupied leaves that went.
std::vector<VoxelKey> contradict_leaves(Octree& octree, const BundleGrid& bundles, const Evidence& evidence,
                                        const UpdateParameters& parameters) {
  enum class Fate : char { kStays, kPendingGoes, kOccupiedGoes };
  const double thickness = least_thickness(bundles.range_sigma, octree.grid());
  std::vector<Fate> fates(evidence.leaves.size(), Fate::kStays);
  octree.own(evidence.leaves, [](const LeafEvidence& against) { return against.leaf; });
  for_each_index(evidence.leaves.size(), kLeavesPerTask, [&](std::size_t i) {
    const LeafEvidence& against = evidence.leaves[i];
    Leaf& leaf = *octree.find(against.leaf);
    if (parameters.trim_leaves) {
      trim(leaf, octree.grid().center(against.leaf), thickness, against.among(evidence.contradictions),
           bundles);
    }
    const bool was_occupied = leaf.occupied();
    if (against.impact == 0 || contradict(leaf, against.impact, parameters)) return;
    fates[i] = was_occupied ? Fate::kOccupiedGoes : Fate::kPendingGoes;
  });
  std::vector<VoxelKey> gone;
  for (std::size_t i = 0; i < fates.size(); ++i) {
    if (fates[i] != Fate::kStays) octree.erase(evidence.leaves[i].leaf);
    if (fates[i] == Fate::kOccupiedGoes) gone.push_back(evidence.leaves[i].leaf);
  }
  return gone;
}

/// Additive: leaves that exist are confirmed in parallel; new ones are made one by one, since that moves
/// leaves. Returns how many became occupied.
std::size_t confirm_leaves(Octree& octree, const BundleGrid& bundles, const AlignmentError& error,
                           const UpdateParameters& parameters, double view_weight) {
  const auto& all = bundles.bundles();
  const auto error_at = [&](const RayBundle& bundle) {
    return error.at((bundle.points.mean - bundles.origin_map).norm());
  };
  enum class Hit : char { kNew, kConfirms, kMakesOccupied };
  std::vector<Hit> hits(all.size(), Hit::kNew);
  octree.own(all, [](const RayBundle& bundle) { return bundle.key; });
  for_each_chunk(all.size(), kLeavesPerTask, [&](std::size_t, std::size_t begin, std::size_t end) {
    LeafFinder leaves(octree);
    for (std::size_t i = begin; i < end; ++i) {
      Leaf* leaf = leaves.find(all[i].key);
      if (leaf == nullptr) continue;
      const bool was_occupied = leaf->occupied();
      Gaussian seen = all[i].points;
      seen.count *= view_weight;
      confirm(*leaf, seen, octree.grid().center(all[i].key), error_at(all[i]), parameters);
      hits[i] = !was_occupied && leaf->occupied() ? Hit::kMakesOccupied : Hit::kConfirms;
    }
  });
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (hits[i] != Hit::kNew) continue;
    Leaf& leaf = octree.find_or_insert(all[i].key);
    confirm(leaf, all[i].points, octree.grid().center(all[i].key), error_at(all[i]), parameters);
    if (leaf.occupied()) hits[i] = Hit::kMakesOccupied;
  }
  return static_cast<std::size_t>(std::count(hits.begin(), hits.end(), Hit::kMakesOccupied));
}

}  // namespace

LeafChanges add(Octree& octree, const BundleGrid& bundles, const UpdateParameters& parameters) {
  UpdateParameters trusting = parameters;
  trusting.confirmations = 1;
  trusting.settled = 0;
  return {confirm_leaves(octree, bundles, {}, trusting, 1), 0};
}

BundleGrid add_cloud(Octree& octree, const Scan& cloud, const Pose& T_map_cloud, const LidarParameters& lidar,
                     const UpdateParameters& parameters) {
  LidarParameters every_return = lidar;
  every_return.min_range = 0;
  every_return.max_range = std::numeric_limits<double>::infinity();
  every_return.vehicle_box.setEmpty();
  UpdateParameters sure = parameters;
  sure.hit = parameters.max_log_odds;
  BundleGrid bundles = condense(cloud, T_map_cloud, octree.grid(), every_return);
  add(octree, bundles, sure);
  return bundles;
}

LeafChanges update(Octree& octree, const BundleGrid& bundles, const UpdateParameters& parameters,
                   double view_weight) {
  return apply(octree, bundles, trace(octree, bundles, parameters), parameters, view_weight);
}

LeafChanges apply(Octree& octree, const BundleGrid& bundles, const Evidence& evidence,
                  const UpdateParameters& parameters, double view_weight, Rollback* rollback,
                  GoneLeaves* gone) {
  if (rollback != nullptr) {
    LeafFinder leaves(std::as_const(octree));
    for (const LeafEvidence& against : evidence.leaves)
      rollback->remember(against.leaf, leaves.find(against.leaf));
    for (const RayBundle& bundle : bundles.bundles()) rollback->remember(bundle.key, leaves.find(bundle.key));
  }
  std::vector<VoxelKey> went = contradict_leaves(octree, bundles, evidence, parameters);
  std::size_t erased = went.size();
  if (parameters.rim_gone > 0) {
    GoneLeaves of_this_scan;
    erased += remove_regions(octree, std::move(went), gone != nullptr ? *gone : of_this_scan, bundles,
                             parameters, rollback);
  }
  return {confirm_leaves(octree, bundles, evidence.alignment_error, parameters, view_weight), erased};
}

}  // namespace evermap
