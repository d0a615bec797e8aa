// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <mutex>
#include <utility>

#include <evermap/geometry/detail/running_median.hpp>
#include <evermap/localization/detail/localizer.hpp>
#include <evermap/maintenance/detail/point_counts.hpp>
#include <evermap/maintenance/map_maintainer.hpp>
#include <evermap/map/detail/leaf_finder.hpp>
#include <evermap/scan/detail/deskew.hpp>
#include <evermap/update/detail/map_updater.hpp>
#include <evermap/update/detail/rollback.hpp>
#include <evermap/update/detail/viewpoint.hpp>

namespace evermap {
namespace {

/// Calls work() and adds the time it took [s].
template <class Work>
auto timed(double& seconds, Work&& work) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begin = Clock::now();
  auto result = work();
  seconds += std::chrono::duration<double>(Clock::now() - begin).count();
  return result;
}

}  // namespace

class MapMaintainer::Loop {
 public:
  Loop(Octree map, const Parameters& parameters, MapMode mode, const Pose& T_map_sensor_initial)
      : map_(std::move(map)),
        parameters_(parameters),
        mode_(mode),
        localizer_(T_map_sensor_initial, parameters.lidar, parameters.localization),
        viewpoint_(parameters.update.standstill),
        rollback_(static_cast<std::size_t>(parameters.rollback.scans)),
        usual_contradicting_(static_cast<std::size_t>(parameters.rollback.memory)) {}

  ScanResult process(const Scan& raw, double time, const std::optional<Pose>& T_odom_sensor) {
    ScanResult result;
    const Scan scan = timed(result.times.locate, [&] {
      const double period = parameters_.lidar.scan_period;
      return deskew(raw, localizer_.motion(time, T_odom_sensor, period), period);
    });
    result.points = count_points(scan, {});                 // as long as it is not condensed
    if (map_.empty() && mode_ != MapMode::kLocalization) {  // the first scan lies where it is put
      write(scan, localizer_.predict(time, T_odom_sensor), result, &Loop::add_to_map);
      result.state = TrackingState::kStarting;
      return result;
    }
    Localization found =
        timed(result.times.locate, [&] { return localizer_.propose(map_, scan, time, T_odom_sensor); });
    if (found.is_writable() && mode_ != MapMode::kLocalization) {
      write(scan, found.T_map_sensor, result,
            mode_ == MapMode::kMapping ? &Loop::add_to_map : &Loop::update_if_plausible);
      found.reject_reason = result.reject_reason;
    }
    const TrackingState before = localizer_.state();
    localizer_.conclude(found);
    if (found.state == TrackingState::kLost && before != TrackingState::kLost)
      result.rolled_back = roll_back();
    result.T_map_sensor = found.T_map_sensor;
    result.state = found.state;
    result.reject_reason = found.reject_reason;
    result.covariance = found.registration.covariance;
    if (found.reject_reason == RejectReason::kUnobservable) {
      result.unobservable = to_string(found.registration.weakest);
    }
    result.inlier_fraction = found.registration.inlier_fraction;
    result.residual = found.registration.residual;
    return result;
  }

  ScanResult process(const Scan& scan, const Pose& T_map_sensor) {
    ScanResult result;
    switch (mode_) {
      case MapMode::kLocalization:
        result.T_map_sensor = T_map_sensor;
        break;
      case MapMode::kMapping:
        write(scan, T_map_sensor, result, &Loop::add_to_map);
        break;
      case MapMode::kMaintenance:
        write(scan, T_map_sensor, result, &Loop::update_trusting);
        break;
    }
    return result;
  }

  Octree snapshot() const {
    const std::lock_guard lock(changing_);
    return map_;
  }

  TrackingState state() const { return localizer_.state(); }

 private:
  /// Gives the map the scan's bundles, unless it has none or `change` rejects them.
  void write(const Scan& scan, const Pose& T_map_sensor, ScanResult& result,
             void (Loop::*change)(const BundleGrid&, ScanResult&)) {
    result.T_map_sensor = T_map_sensor;
    const BundleGrid bundles = timed(
        result.times.condense, [&] { return condense(scan, T_map_sensor, map_.grid(), parameters_.lidar); });
    result.points = count_points(scan, bundles);
    if (bundles.bundles().empty()) result.reject_reason = RejectReason::kNoUsablePoint;
    if (result.reject_reason == RejectReason::kNone) (this->*change)(bundles, result);
    result.is_written = result.reject_reason == RejectReason::kNone;
  }

  void add_to_map(const BundleGrid& bundles, ScanResult& result) {
    apply_changes(result, [&] { return add(map_, bundles, parameters_.update); });
  }

  void update_trusting(const BundleGrid& bundles, ScanResult& result) {
    const Evidence evidence = trace_rays(bundles, result);
    apply_changes(result, [&] { return apply_evidence(bundles, evidence, result); });
  }

  /// Updates the map with a scan whose pose was found: not when it contradicts too much of the map, and in a
  /// way that can be undone.
  void update_if_plausible(const BundleGrid& bundles, ScanResult& result) {
    const Evidence evidence = trace_rays(bundles, result);
    result.contradicting_fraction = contradicting_fraction(evidence, bundles);
    const RollbackParameters& p = parameters_.rollback;
    const double most = usual_contradicting_.is_known() ? p.max_contradicting + usual_contradicting_.value()
                                                        : p.max_contradicting_at_first;
    if (result.contradicting_fraction > most) {
      result.reject_reason = RejectReason::kContradictsMap;
      return;
    }
    usual_contradicting_.push(result.contradicting_fraction);
    apply_changes(result, [&] {
      rollback_.begin_scan();
      LeafFinder leaves(std::as_const(map_));
      for (const LeafEvidence& against : evidence.leaves) rollback_.remember(leaves, against.leaf);
      for (const RayBundle& bundle : bundles.bundles()) rollback_.remember(leaves, bundle.key);
      return apply_evidence(bundles, evidence, result);
    });
  }

  Evidence trace_rays(const BundleGrid& bundles, ScanResult& result) const {
    return timed(result.times.trace, [&] { return trace(map_, bundles, parameters_.update); });
  }

  LeafChanges apply_evidence(const BundleGrid& bundles, const Evidence& evidence, const ScanResult& result) {
    return apply(map_, bundles, evidence, parameters_.update, viewpoint_.view_weight(result.T_map_sensor));
  }

  /// Nobody reads the map while it changes.
  template <class Change>
  void apply_changes(ScanResult& result, Change&& change) {
    const std::lock_guard lock(changing_);
    const LeafChanges changes = timed(result.times.apply, change);
    result.leaves_occupied += changes.occupied;
    result.leaves_erased += changes.erased;
  }

  std::size_t roll_back() {
    const std::lock_guard lock(changing_);
    const std::size_t scans = rollback_.scans();
    rollback_.roll_back(map_);
    return scans;
  }

  mutable std::mutex changing_;  ///< held while map_ changes or is copied by a reader
  Octree map_;
  Parameters parameters_;
  MapMode mode_;
  Localizer localizer_;
  Viewpoint viewpoint_;
  Rollback rollback_;
  RunningMedian usual_contradicting_;
};

MapMaintainer::MapMaintainer(Octree map, const Parameters& parameters, MapMode mode,
                             const Pose& T_map_sensor_initial)
    : loop_(std::make_unique<Loop>(std::move(map), parameters, mode, T_map_sensor_initial)) {}
MapMaintainer::~MapMaintainer() = default;
MapMaintainer::MapMaintainer(MapMaintainer&&) noexcept = default;
MapMaintainer& MapMaintainer::operator=(MapMaintainer&&) noexcept = default;

ScanResult MapMaintainer::process(const Scan& scan, double time, const std::optional<Pose>& T_odom_sensor) {
  return loop_->process(scan, time, T_odom_sensor);
}
ScanResult MapMaintainer::process(const Scan& scan, const Pose& T_map_sensor) {
  return loop_->process(scan, T_map_sensor);
}
Octree MapMaintainer::map() const { return loop_->snapshot(); }
TrackingState MapMaintainer::state() const { return loop_->state(); }

}  // namespace evermap
