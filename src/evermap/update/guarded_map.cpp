// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <utility>

#include <evermap/update/guarded_map.hpp>

namespace evermap {

GuardedMap::GuardedMap(Octree octree, const UpdateParameters& parameters, const GuardParameters& guard)
    : octree_(std::move(octree)),
      parameters_(parameters),
      guard_(guard),
      viewpoint_(parameters.standstill),
      probation_(guard.probation),
      contradicting_(guard.memory) {}

std::optional<ScanSummary> GuardedMap::update(const Scan& scan, const Pose& T_map_sensor) {
  const BundleGrid bundles = condense(scan, T_map_sensor, octree_.grid(), parameters_.lidar);
  const Evidence evidence = trace(octree_, bundles, parameters_);
  const double contradicting = contradicting_share(evidence, bundles);
  const bool is_used_to_it = contradicting_.is_known();
  if (contradicting > (is_used_to_it ? guard_.max_contradicting + contradicting_.value() : guard_.at_first)) {
    return std::nullopt;
  }
  contradicting_.push(contradicting);
  probation_.begin_scan();
  LeafFinder leaves(std::as_const(octree_));
  for (const LeafEvidence& against : evidence.leaves) probation_.remember(leaves, against.leaf);
  for (const RayBundle& bundle : bundles.bundles()) probation_.remember(leaves, bundle.key);
  apply(octree_, bundles, evidence, parameters_, viewpoint_.novelty(T_map_sensor));
  return summarize(scan, bundles);
}

std::size_t GuardedMap::take_back() {
  const std::size_t scans = probation_.scans();
  probation_.take_back(octree_);
  return scans;
}

}  // namespace evermap
