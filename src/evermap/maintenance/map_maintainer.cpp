// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <mutex>
#include <utility>
#include <vector>

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
        rollback_(static_cast<std::size_t>(parameters.rollback.scans)) {}

  ScanResult process(const Scan& raw, double time, const EgoMotion& ego) {
    ScanResult result;
    result.time = time;
    result.points = count_points(raw, {});                  // as long as it is not condensed
    if (map_.empty() && mode_ != MapMode::kLocalization) {  // the first scan lies where it is put
      result.T_map_sensor = localizer_.predict(time, ego);
      start_ = {{raw, ego, result}};
      begins_map_ = true;
      begin_map(raw, std::nullopt);
      return start_.front().result;
    }
    const auto propose = [&](Effort effort) {
      return timed(result.times.locate, [&] {
        return localizer_.propose(registered_to(), raw, time, ego, contradicting(), effort);
      });
    };
    Localization found = propose(Effort::kUsual);
    if (begins_map_ && found.passes()) {
      begin_map(localizer_.undistorted(start_.front().raw, found.motion), found.motion);
      begins_map_ = false;
      found = propose(Effort::kUsual);
    }
    write_found(found, propose, result);
    const TrackingState before = localizer_.state();
    localizer_.conclude(found);
    tell(found, result);
    if (found.state == TrackingState::kLost) {
      if (before != TrackingState::kLost) result.rolled_back = roll_back();
      start_.erase(start_.begin() + (begins_map_ ? 1 : 0), start_.end());
    } else if (found.motion_is_known && found.passes()) {
      result.confirmed = confirm_start();
    } else if (!found.motion_is_known && found.registration.converged()) {
      start_.push_back({raw, ego, result});
    }
    return result;
  }

  ScanResult process(const Scan& raw, const Pose& T_map_sensor,
                     const std::optional<Pose>& T_map_sensor_begin) {
    ScanResult result;
    const bool is_distorted = T_map_sensor_begin && has_times(raw);
    const Scan still =
        is_distorted ? deskew_between(raw, T_map_sensor.inverse() * *T_map_sensor_begin) : Scan{};
    const Scan& scan = is_distorted ? still : raw;
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
  void set_mode(MapMode mode) { mode_ = mode; }

 private:
  /// A scan from before the motion was known, so that its pose could not be believed.
  struct StartScan {
    Scan raw;
    EgoMotion ego;
    ScanResult result;
  };

  /// Makes a map of the first scan alone, which is believed as soon as the motion is known.
  void begin_map(const Scan& scan, const std::optional<Twist>& velocity) {
    StartScan& first = start_.front();
    ScanResult result;
    result.time = first.result.time;
    result.state = velocity ? TrackingState::kTracking : TrackingState::kStarting;
    {
      const std::lock_guard lock(changing_);
      map_ = Octree(map_.grid(), map_.frame());
    }
    wide_map_.reset();
    if (mode_ == MapMode::kMapping) {
      const double edge = least_mapping_edge(scan, parameters_.lidar);
      if (edge > map_.grid().edge) wide_map_ = Octree(VoxelGrid{edge});
    }
    write(scan, first.result.T_map_sensor, result, &Loop::add_to_map);
    localizer_.begin(result.T_map_sensor, result.time, first.ego, velocity);
    first.result = std::move(result);
  }

  /// Locates the scans of the start once more and gives them to the map, now that the motion is known.
  std::vector<ScanResult> confirm_start() {
    std::vector<ScanResult> confirmed;
    for (StartScan& scan : std::exchange(start_, {})) {
      ScanResult& result = scan.result;
      if (!result.is_believed()) {  // unlike the scan that the map began with
        result.reject_reason = RejectReason::kNone;
        const auto propose = [&](Effort effort) {
          return timed(result.times.locate, [&] {
            return localizer_.propose_earlier(registered_to(), scan.raw, result.time, scan.ego,
                                              contradicting(), effort);
          });
        };
        Localization found = propose(Effort::kUsual);
        write_found(found, propose, result);
        tell(found, result);
      }
      if (result.is_believed()) confirmed.push_back(std::move(result));
    }
    return confirmed;
  }

  const Octree& registered_to() const { return wide_map_ ? *wide_map_ : map_; }

  Contradicting contradicting() const {
    return [this](const Scan& scan, const Pose& T_map_sensor) {
      const BundleGrid bundles = condense(scan, T_map_sensor, map_.grid(), parameters_.lidar);
      return contradicting_fraction(trace(map_, bundles, parameters_.update), bundles);
    };
  }

  using Change = void (Loop::*)(const BundleGrid&, ScanResult&);

  /// Gives the map a scan that was located. Where it contradicts the map, other places are proposed.
  template <class Propose>
  void write_found(Localization& found, const Propose& propose, ScanResult& result) {
    if (mode_ == MapMode::kMapping) write_if_known(found, result, &Loop::add_to_map);
    if (mode_ == MapMode::kMaintenance) write_if_known(found, result, &Loop::update_if_usual);
    if (found.reject_reason == RejectReason::kContradictsMap) {  // is the map outdated, or the pose wrong?
      result.reject_reason = RejectReason::kNone;
      found = propose(Effort::kThorough);
      write_if_known(found, result, &Loop::update_reversibly);
    }
    if (result.contradicting_fraction) found.contradicting_fraction = result.contradicting_fraction;
  }

  void write_if_known(Localization& found, ScanResult& result, Change change) {
    if (!found.is_writable() || (mode_ == MapMode::kMaintenance && !found.is_precise())) return;
    write(found.scan, found.T_map_sensor, result, change);
    found.reject_reason = result.reject_reason;
  }

  static void tell(const Localization& found, ScanResult& result) {
    result.T_map_sensor = found.T_map_sensor;
    result.state = found.state;
    result.reject_reason = found.reject_reason;
    result.covariance = found.registration.covariance;
    if (found.registration.unobservable > 0) {
      result.unobservable = to_string(weakest_direction(found.registration.covariance));
    }
    result.inlier_fraction = found.registration.explained_fraction();
    result.residual = found.registration.residual;
    result.contradicting_fraction = found.contradicting_fraction;
  }

  /// Gives the map the scan's bundles, unless it has none or `change` rejects them.
  void write(const Scan& scan, const Pose& T_map_sensor, ScanResult& result, Change change) {
    result.T_map_sensor = T_map_sensor;
    const BundleGrid bundles = timed(
        result.times.condense, [&] { return condense(scan, T_map_sensor, map_.grid(), parameters_.lidar); });
    result.points = count_points(scan, bundles);
    if (bundles.bundles().empty()) result.reject_reason = RejectReason::kNoUsablePoint;
    if (result.reject_reason == RejectReason::kNone) (this->*change)(bundles, result);
    result.is_written = result.reject_reason == RejectReason::kNone;
    if (!result.is_written || !wide_map_) return;
    add(*wide_map_, condense(scan, T_map_sensor, wide_map_->grid(), parameters_.lidar), parameters_.update);
  }

  void add_to_map(const BundleGrid& bundles, ScanResult& result) {
    apply_changes(result, [&] { return add(map_, bundles, parameters_.update); });
  }

  void update_trusting(const BundleGrid& bundles, ScanResult& result) {
    const Evidence evidence = trace_rays(bundles, result);
    result.contradicting_fraction = contradicting_fraction(evidence, bundles);
    apply_changes(result, [&] { return apply_evidence(bundles, evidence, result); });
  }

  /// Updates the map with a scan whose pose was found, unless it contradicts more of the map than usual.
  void update_if_usual(const BundleGrid& bundles, ScanResult& result) {
    const Evidence evidence = trace_rays(bundles, result);
    result.contradicting_fraction = contradicting_fraction(evidence, bundles);
    if (localizer_.is_contradicting(*result.contradicting_fraction)) {
      result.reject_reason = RejectReason::kContradictsMap;
    } else {
      apply_reversibly(bundles, evidence, result);
    }
  }

  void update_reversibly(const BundleGrid& bundles, ScanResult& result) {
    apply_reversibly(bundles, trace_rays(bundles, result), result);
  }

  void apply_reversibly(const BundleGrid& bundles, const Evidence& evidence, ScanResult& result) {
    apply_changes(result, [&] {
      rollback_.begin_scan();
      return apply_evidence(bundles, evidence, result, &rollback_);
    });
  }

  Evidence trace_rays(const BundleGrid& bundles, ScanResult& result) const {
    return timed(result.times.trace, [&] { return trace(map_, bundles, parameters_.update); });
  }

  LeafChanges apply_evidence(const BundleGrid& bundles, const Evidence& evidence, const ScanResult& result,
                             Rollback* rollback = nullptr) {
    return apply(map_, bundles, evidence, parameters_.update, viewpoint_.view_weight(result.T_map_sensor),
                 rollback, &gone_);
  }

  /// Nobody reads the map while it changes.
  template <class Apply>
  void apply_changes(ScanResult& result, Apply&& apply_change) {
    const std::lock_guard lock(changing_);
    const LeafChanges changes = timed(result.times.apply, apply_change);
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
  std::optional<Octree> wide_map_;  ///< what scans are registered to, where these scans make the map
  Parameters parameters_;
  MapMode mode_;
  Localizer localizer_;
  std::vector<StartScan> start_;  ///< until the motion is known
  bool begins_map_ = false;       ///< the map is of start_.front() alone, which is not deskewed yet
  Viewpoint viewpoint_;
  Rollback rollback_;
  GoneLeaves gone_;
};

MapMaintainer::MapMaintainer(Octree map, const Parameters& parameters, MapMode mode,
                             const Pose& T_map_sensor_initial)
    : loop_(std::make_unique<Loop>(std::move(map), parameters, mode, T_map_sensor_initial)) {}
MapMaintainer::~MapMaintainer() = default;
MapMaintainer::MapMaintainer(MapMaintainer&&) noexcept = default;
MapMaintainer& MapMaintainer::operator=(MapMaintainer&&) noexcept = default;

ScanResult MapMaintainer::process(const Scan& scan, double time, const std::optional<Pose>& T_odom_sensor,
                                  const std::optional<Eigen::Matrix3d>& R_inertial_sensor) {
  return loop_->process(scan, time, EgoMotion{T_odom_sensor, R_inertial_sensor});
}
ScanResult MapMaintainer::process(const Scan& scan, const Pose& T_map_sensor,
                                  const std::optional<Pose>& T_map_sensor_begin) {
  return loop_->process(scan, T_map_sensor, T_map_sensor_begin);
}
Octree MapMaintainer::map() const { return loop_->snapshot(); }
TrackingState MapMaintainer::state() const { return loop_->state(); }
void MapMaintainer::set_mode(MapMode mode) { loop_->set_mode(mode); }

}  // namespace evermap
