// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <evermap/geometry/detail/degree.hpp>
#include <evermap/localization/detail/motion_fit.hpp>
#include <evermap/localization/detail/perturbation.hpp>

namespace evermap {
namespace {

constexpr int kParts = 8;  ///< of a scan, equally long

using Parts = std::array<NormalEquations, kParts>;

/// Points all over a scan, some thousands in all. An odd step meets all beams of a sensor in turn.
Scan some_points(const Scan& scan) {
  constexpr std::size_t kPoints = 8000;
  const std::size_t step = scan.p_sensor.size() / kPoints | 1;
  Scan some;
  for (std::size_t i = 0; i < scan.p_sensor.size(); i += step) {
    some.p_sensor.push_back(scan.p_sensor[i]);
    if (!scan.time_offset.empty()) some.time_offset.push_back(scan.time_offset[i]);
  }
  return some;
}

/// The points that were taken no sooner than `from` [s] after the scan's begin.
Scan taken_from(const Scan& scan, double from) {
  Scan rest;
  for (std::size_t i = 0; i < scan.p_sensor.size(); ++i) {
    if (scan.time_offset[i] < from) continue;
    rest.p_sensor.push_back(scan.p_sensor[i]);
    rest.time_offset.push_back(scan.time_offset[i]);
  }
  return rest;
}

/// What each part of a scan, deskewed, says about its pose.
Parts equations_of_parts(const Octree& map, const Scan& raw, const Scan& deskewed, const Pose& T_map_sensor,
                         const LidarParameters& lidar, const RegistrationParameters& parameters) {
  std::array<Scan, kParts> parts;
  for (std::size_t i = 0; i < deskewed.p_sensor.size(); ++i) {
    const double fraction = fraction_at(raw.time_offset[i], lidar.scan_period);
    const int part = std::clamp(static_cast<int>(fraction * kParts), 0, kParts - 1);
    parts[part].p_sensor.push_back(deskewed.p_sensor[i]);
  }
  Parts equations;
  for (int i = 0; i < kParts; ++i) {
    const auto bundles =
        bundles_in_sensor_frame(parts[i], map.grid().edge, lidar, parameters.first_bundles / kParts);
    equations[i] = equations_at(map, bundles, T_map_sensor, {parameters.first_kernel_width});
  }
  return equations;
}

/// The same, as far as leaves of this edge can be believed: each part may be off by as much as they mislead.
NormalEquations as_far_as_believed(const NormalEquations& part, double unit, double edge) {
  const Matrix6 hessian = part.hessian / unit;
  const Matrix6 kept = Matrix6::Identity() - hessian * (hessian + systematic(edge).inverse()).inverse();
  NormalEquations believed;
  believed.hessian = kept * hessian;
  believed.gradient = kept * part.gradient / unit;
  return believed;
}

/// How far the sensor was from where it would have been at the assumed first velocity, in twists of
/// perturb(): at the scan's begin by `offset`, at its end by `drift` more, and from the bend on by as much as
/// `turn` in a whole scan.
struct Deviation {
  Twist at(double fraction) const {
    return offset + fraction * drift + std::max(0.0, fraction - bend) * turn;
  }

  Twist offset = Twist::Zero(), drift = Twist::Zero(), turn = Twist::Zero();
  double bend = 1;  ///< fraction of the scan; 1 when there is none
  double cost = 0;  ///< twice the negative logarithm of its likelihood, but for a constant
};

/// The likeliest deviation with this bend. `begin`, `end`: where the scan before and odometry say that the
/// scan began and ended, as deviations, too.
Deviation fit(const Parts& parts, double bend, const Twist& begin, const Twist& end,
              const MotionPrior& prior) {
  using Vector18 = Eigen::Matrix<double, 18, 1>;
  using Matrix18 = Eigen::Matrix<double, 18, 18>;
  const Matrix6 of_turn = within(0.15, 12 * kDegree);  // in 0.1 s, vehicles do not do more
  Matrix18 information = Matrix18::Zero();
  information.block<6, 6>(0, 0) = prior.begin.covariance.inverse();
  information.block<6, 6>(6, 6) = prior.drift.inverse();
  information.block<6, 6>(12, 12) = of_turn.inverse();
  Vector18 pull = Vector18::Zero();
  pull.head<6>() = information.block<6, 6>(0, 0) * begin;
  const auto add = [&](double fraction, double since_bend, const Matrix6& hessian, const Twist& towards) {
    const Eigen::Vector3d weights(1, fraction, since_bend);
    for (int i = 0; i < 3; ++i) {
      pull.segment<6>(6 * i) += weights[i] * towards;
      for (int j = 0; j < 3; ++j) information.block<6, 6>(6 * i, 6 * j) += weights[i] * weights[j] * hessian;
    }
  };
  for (int part = 0; part < kParts; ++part) {
    const double from = std::clamp(bend - static_cast<double>(part) / kParts, 0.0, 1.0 / kParts);
    const double left = 1.0 / kParts - from;
    const double since_bend = std::max(0.0, static_cast<double>(part) / kParts - bend);
    add((part + 0.5) / kParts, since_bend + left * left * kParts / 2, parts[part].hessian,
        -parts[part].gradient);
  }
  if (prior.end) {
    const Matrix6 of_end = prior.end->covariance.inverse();
    add(1, 1 - bend, of_end, of_end * end);
  }
  const Vector18 x = information.ldlt().solve(pull);
  return {x.head<6>(), x.segment<6>(6), x.tail<6>(), bend, -x.dot(pull)};
}

Pose end_of(const Pose& T_map_begin, const ScanMotion& motion, double duration) {
  return T_map_begin * motion.pose_at(0, duration).inverse();
}

/// The likeliest deviations from an assumed motion, of one velocity and of two, and what they come to.
class MotionFit {
 public:
  /// `deskewed`: the raw scan, by the assumed motion.
  MotionFit(const Octree& map, const Scan& raw, const Scan& deskewed, const MovingPose& assumed,
            const MotionPrior& prior, const LidarParameters& lidar, const RegistrationParameters& parameters)
      : assumed_(assumed),
        period_(lidar.scan_period),
        least_shift_(std::max(0.02, map.grid().edge / 20)),
        least_turn_(std::max(0.15 * kDegree, least_shift_ / 10)) {
    Parts parts = equations_of_parts(map, raw, deskewed, assumed.T_map_sensor, lidar, parameters);
    NormalEquations all;
    for (const NormalEquations& part : parts) all += part;
    if (all.inliers == 0) return;
    for (int i = 0; i < kParts; ++i) {
      parts[i] = as_far_as_believed(parts[i], all.mean_inlier_error(), map.grid().edge);
      parts[i].gradient -= parts[i].hessian * mean_assumed_in(i);  // deviations are from the first velocity
    }
    const Pose T_map_sensor_expected = end_of(prior.begin.T_map_sensor, assumed.motion, period_);
    const Twist begin = difference(assumed.T_map_sensor, T_map_sensor_expected);
    Twist end = assumed_at(1);
    if (prior.end) end += difference(assumed.T_map_sensor, prior.end->T_map_sensor);
    steady_ = fit(parts, 1, begin, end, prior);
    bent_ = steady_;
    const auto try_bend = [&](double bend) {
      const Deviation next = fit(parts, bend, begin, end, prior);
      if (next.cost < bent_.cost) bent_ = next;
    };
    for (int i = 1; i < kParts; ++i) try_bend(static_cast<double>(i) / kParts);
    if (assumed.motion.bend > 0) try_bend(assumed.motion.bend);
    if (bent_.bend == 1) return;
    for (const double finer : {0.5 / kParts, 0.25 / kParts, 0.125 / kParts}) {
      const double around = bent_.bend;
      for (const double side : {-1, 1}) try_bend(around + side * finer);
    }
  }

  /// At the one velocity, or the two, that explain the scan better; none where that is about the same.
  std::optional<MovingPose> steady() const {
    if (assumed_.motion.bend > 0) return std::nullopt;  // else a bend hardly turns
    if (!matters(steady_.at(1)) && !matters(steady_.drift / 4)) return std::nullopt;
    return moved_by(steady_);
  }
  std::optional<MovingPose> bent() const {
    constexpr double kLeastGain = 15;  // of cost: what explains less is noise
    const bool gains = assumed_.motion.bend > 0 || bent_.cost < steady_.cost - kLeastGain;
    if (!gains || (!matters(change(bent_, 1)) && !matters(change(bent_, bent_.bend)))) return std::nullopt;
    return moved_by(bent_);
  }

 private:
  /// The assumed motion as a deviation from its first velocity.
  Twist assumed_at(double fraction) const {
    const ScanMotion& motion = assumed_.motion;
    if (motion.bend == 0 || fraction <= motion.bend) return Twist::Zero();
    const Pose T_map_bend = assumed_.T_map_sensor * motion.pose_at(motion.bend, period_);
    const Pose T_map_then = T_map_bend * exp((fraction - motion.bend) * period_ * motion.before);
    return -difference(assumed_.T_map_sensor, T_map_then * motion.pose_at(fraction, period_).inverse());
  }
  Twist mean_assumed_in(int part) const {
    constexpr int kSteps = 4;
    Twist sum = Twist::Zero();
    for (int i = 0; i < kSteps; ++i) sum += assumed_at((part + (i + 0.5) / kSteps) / kParts);
    return sum / kSteps;
  }
  /// What a deviation changes of the assumed motion.
  Twist change(const Deviation& deviation, double fraction) const {
    return deviation.at(fraction) - assumed_at(fraction);
  }
  bool matters(const Twist& twist) const {
    return twist.head<3>().norm() > least_shift_ || twist.tail<3>().norm() > least_turn_;
  }

  MovingPose moved_by(const Deviation& deviation) const {
    const auto T_map_then = [&](double fraction) {
      return perturb(assumed_.T_map_sensor, change(deviation, fraction)) *
             assumed_.motion.pose_at(fraction, period_);
    };
    const auto velocity = [&](double from, double to) {
      return Twist(log(T_map_then(from).inverse() * T_map_then(to)) / ((to - from) * period_));
    };
    const double bend = deviation.bend;
    if (bend == 1) return {ScanMotion::steady(velocity(0, 1)), T_map_then(1)};
    return {{velocity(0, bend), velocity(bend, 1), bend}, T_map_then(1)};
  }

  MovingPose assumed_;
  double period_;       ///< [s]
  double least_shift_;  ///< [m] below which nothing is to be gained
  double least_turn_;   ///< [rad]
  Deviation steady_, bent_;
};

}  // namespace

std::vector<MovingPose> fit_motion(const Octree& map, const Scan& raw, const Scan& deskewed,
                                   const MovingPose& assumed, const MotionPrior& prior,
                                   const LidarParameters& lidar, const RegistrationParameters& parameters) {
  constexpr int kSteps = 6;
  const Scan some = some_points(raw);
  const MotionFit first(map, some, some_points(deskewed), assumed, prior, lidar, parameters);
  const auto refined = [&](MovingPose at, auto next) {
    for (int i = 1; i < kSteps; ++i) {
      const Scan still = deskew(some, at.motion, lidar.scan_period);
      const auto better = (MotionFit(map, some, still, at, prior, lidar, parameters).*next)();
      if (!better) break;
      at = *better;
    }
    return at;
  };
  std::vector<MovingPose> better;
  if (const auto steady = first.steady()) better.push_back(refined(*steady, &MotionFit::steady));
  if (const auto bent = first.bent()) better.push_back(refined(*bent, &MotionFit::bent));
  return better;
}

MovingPose best_turn(const Octree& map, const Scan& raw, const Pose& T_map_begin, const Twist& before,
                     const LidarParameters& lidar, const RegistrationParameters& parameters) {
  const Eigen::Vector3d up =
      T_map_begin.rotation.transpose() * Eigen::Vector3d::UnitZ();  // in the sensor's frame
  const Scan some = some_points(raw);
  const double period = lidar.scan_period;
  // Bundles that fit, less those beside their leaves, of what was taken from the bend on.
  const auto fits = [&](const Scan& rest, const ScanMotion& motion) {
    const double bundles_of_all = static_cast<double>(parameters.first_bundles);
    const auto most_bundles = static_cast<std::size_t>((1 - motion.bend) * bundles_of_all);
    const auto bundles =
        bundles_in_sensor_frame(deskew(rest, motion, period), map.grid().edge, lidar, most_bundles);
    const NormalEquations there =
        equations_at(map, bundles, end_of(T_map_begin, motion, period), {parameters.first_kernel_width});
    return 2 * static_cast<double>(there.inliers) - static_cast<double>(there.matched);
  };
  ScanMotion best = ScanMotion::steady(before);
  double most = 0;
  for (const double bend : {0.0, 0.125, 0.25, 0.375, 0.5, 0.5625, 0.625, 0.6875, 0.75, 0.8125, 0.875}) {
    const Scan rest = taken_from(some, bend * period);
    const double usual = fits(rest, {before, before, bend});
    const auto consider = [&](double turn) {
      Twist after = before;
      after.tail<3>() += turn * up;
      const ScanMotion motion{before, after, bend};
      const double more = fits(rest, motion) - usual;
      if (more <= most) return;
      most = more;
      best = motion;
    };
    consider(-up.dot(before.tail<3>()));
    for (int i = -5; i <= 5; ++i)
      if (i != 0) consider(30 * kDegree * i);
  }
  return {best, end_of(T_map_begin, best, period)};
}

}  // namespace evermap
