// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

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
  const RejectReason fit = judge_fit(registration);
  return fit == RejectReason::kNone ? judge_distance(registration, T_map_sensor_predicted, slack) : fit;
}

RejectReason Gate::judge_best(const std::vector<Hypothesis>& places, std::size_t best,
                              const Pose& T_map_sensor_predicted, double slack) const {
  const Hypothesis& place = places[best];
  const RejectReason fit = judge_fit(place.registration);
  const bool is_unusual = fit == RejectReason::kFitsWorse || fit == RejectReason::kSeesLess;
  if (fit != RejectReason::kNone && !(is_unusual && !is_contradicting(place.contradicting_fraction)))
    return fit;
  if (place.contradicting_fraction >= place.registration.explained_fraction()) {
    return RejectReason::kContradictsMap;
  }
  if (has_rival(places, best, parameters_.margin)) return RejectReason::kAmbiguous;
  return judge_distance(place.registration, T_map_sensor_predicted,
                        std::max(slack, parameters_.starting_slack));
}

bool Gate::is_usual(const Registration& registration) const {
  constexpr double kLeast = 0.95;
  constexpr double kMost = 1.2;
  return explained_.is_known() && registration.explained_fraction() > kLeast * explained_.value() &&
         registration.residual < kMost * residuals_.value() &&
         registration.score() > last_score_ - least_difference();
}

double Gate::least_difference() const {
  constexpr double kLeast = 0.02;
  constexpr double kSigmas = 3;
  if (!score_changes_.is_known()) return kLeast;
  return std::max(kLeast, kSigmas * kMedianToSigma * score_changes_.value());
}

bool Gate::is_contradicting(double fraction) const {
  return fraction > parameters_.max_contradicting + (contradicting_.is_known() ? contradicting_.value() : 0);
}

RejectReason Gate::judge_fit(const Registration& registration) const {
  if (!registration.converged()) return registration.reject_reason;
  const GateParameters& p = parameters_;
  if (!residuals_.is_known()) return RejectReason::kNone;
  // What fits better than noise would (a sensor that stands and sees the same again) is no measure.
  const double usual = std::max(1.0, residuals_.value());
  if (registration.residual > p.max_residual * usual) return RejectReason::kFitsWorse;
  const bool sees_less = registration.explained_fraction() < p.least_inlier_fraction * explained_.value();
  return sees_less ? RejectReason::kSeesLess : RejectReason::kNone;
}

RejectReason Gate::judge_distance(const Registration& registration, const Pose& T_map_sensor_predicted,
                                  double slack) const {
  const GateParameters& p = parameters_;
  const Twist off = difference(T_map_sensor_predicted, registration.T_map_sensor);
  const double far = three_sigma(translations_, p.max_translation, p.max_growth);
  const double turned = three_sigma(rotations_, p.max_rotation, p.max_growth);
  if (off.head<3>().norm() > slack * far) return RejectReason::kTooFar;
  if (off.tail<3>().norm() > slack * turned) return RejectReason::kTurnedTooFar;
  return RejectReason::kNone;
}

void Gate::remember(const Registration& passed, const Pose& T_map_sensor_predicted, bool is_predicted) {
  residuals_.push(passed.residual);
  explained_.push(passed.explained_fraction());
  score_changes_.push(std::abs(passed.score() - std::exchange(last_score_, passed.score())));
  if (!is_predicted) return;
  const Twist off = difference(T_map_sensor_predicted, passed.T_map_sensor);
  push(translations_, off.head<3>().norm(), parameters_.memory);
  push(rotations_, off.tail<3>().norm(), parameters_.memory);
}

}  // namespace evermap
