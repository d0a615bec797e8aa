// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <numeric>

#include <evermap/localization/detail/gate.hpp>
#include <evermap/localization/detail/perturbation.hpp>

namespace evermap {
namespace {

constexpr std::size_t kLeastMemory = 5;  ///< scans before a deviation means anything

/// Three standard deviations, within [least, growth * least].
double three_sigma(const std::deque<double>& values, double least, double growth) {
  if (values.size() < kLeastMemory) return least;
  const double sum = std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
  return std::clamp(3 * std::sqrt(sum / static_cast<double>(values.size())), least, growth * least);
}

void push(std::deque<double>& values, double value, std::size_t memory) {
  values.push_back(value);
  if (values.size() > memory) values.pop_front();
}

}  // namespace

RejectReason Gate::judge(const Registration& registration, const Pose& T_map_sensor_predicted,
                         double slack) const {
  if (!registration.converged()) return registration.reject_reason;
  const GateParameters& p = parameters_;
  if (residuals_.is_known()) {
    if (registration.residual > p.max_residual * residuals_.value()) return RejectReason::kFitsWorse;
    if (registration.inlier_fraction < p.least_inlier_fraction * inlier_fractions_.value()) {
      return RejectReason::kSeesLess;
    }
  }
  const Twist off = difference(T_map_sensor_predicted, registration.T_map_sensor);
  const double far = three_sigma(translations_, p.max_translation, p.max_growth);
  const double turned = three_sigma(rotations_, p.max_rotation, p.max_growth);
  if (off.head<3>().norm() > slack * far) return RejectReason::kTooFar;
  if (off.tail<3>().norm() > slack * turned) return RejectReason::kTurnedTooFar;
  return RejectReason::kNone;
}

void Gate::remember(const Registration& passed, const Pose& T_map_sensor_predicted, bool is_predicted) {
  residuals_.push(passed.residual);
  inlier_fractions_.push(passed.inlier_fraction);
  if (!is_predicted) return;
  const Twist off = difference(T_map_sensor_predicted, passed.T_map_sensor);
  push(translations_, off.head<3>().norm(), parameters_.memory);
  push(rotations_, off.tail<3>().norm(), parameters_.memory);
}

}  // namespace evermap
