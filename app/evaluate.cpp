// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include "options.hpp"
#include "posed_scans.hpp"
#include "progress_bar.hpp"
#include "report.hpp"
#include "verbs.hpp"
#include <evermap/evaluation/labelled_drive.hpp>
#include <evermap/evaluation/map_claims.hpp>
#include <evermap/evaluation/trajectory_metrics.hpp>
#include <evermap/files/file_error.hpp>
#include <evermap/history/map_history.hpp>
#include <evermap/io/detail/labelled_boxes.hpp>
#include <evermap/io/poses.hpp>

namespace evermap {
namespace {

struct EvaluateOptions {
  std::filesystem::path map;
  std::filesystem::path scans;
  std::filesystem::path poses;
  std::filesystem::path boxes;
  std::vector<std::string> trajectory;  ///< found and true
  double tolerance = 0.02;              ///< [s]
  bool as_json = false;
};

DriveScore score_drive(const Octree& octree, PosedScans& scans,
                       const std::vector<std::vector<LabelledBox>>& boxes) {
  DriveScore score;
  ProgressBar bar(scans.size());
  for (std::size_t i = 0; auto posed = scans.next(); ++i) {
    add_to_score(score, posed->scan, posed->T_map_sensor,
                 i < boxes.size() ? boxes[i] : std::vector<LabelledBox>{},
                 i + DriveScore::kLastScans >= scans.size(),
                 [&](const Eigen::Vector3d& p_map) { return claims(octree, p_map, DriveScore::kPoseSigma); });
    bar.show(i + 1);
  }
  return score;
}

void score_map(const EvaluateOptions& options) {
  const Octree octree = load_map_version(options.map);
  const auto boxes = read_labelled_boxes(options.boxes);
  PosedScans scans(options.scans, options.poses.string(), LidarParameters{}.scan_period);
  const DriveScore score = score_drive(octree, scans, boxes);
  if (options.as_json) {
    fmt::print("{}", dump({{"static_kept", score.all_static.value()},
                           {"static_kept_in_labelled_view", score.seen_static.value()},
                           {"parked_kept", score.parked.value()},
                           {"moving_removed", score.removed()},
                           {"associated_accuracy", score.associated_accuracy()}}));
    return;
  }
  fmt::print("static kept      {:.4f}   ({:.4f} in the labelled view)\n", score.all_static.value(),
             score.seen_static.value());
  fmt::print("parked kept      {:.4f}\nmoving removed   {:.4f}\n", score.parked.value(), score.removed());
  fmt::print("sqrt(static kept x moving removed)   {:.4f}\n", score.associated_accuracy());
}

/// Two trajectories, pose by pose, and what found no partner.
struct MatchedPoses {
  bool is_by_time;
  std::vector<Pose> truth;
  std::vector<Pose> found;
  std::size_t unmatched_found;
  std::size_t unmatched_truth;
};

/// Empty unless every pose has a time.
std::vector<double> times_of(const std::vector<StampedPose>& poses) {
  std::vector<double> times;
  for (const StampedPose& pose : poses) {
    if (pose.time) times.push_back(*pose.time);
  }
  return times;
}

MatchedPoses match(const std::vector<StampedPose>& found, const std::vector<StampedPose>& truth,
                   double tolerance) {
  const std::vector<double> found_times = times_of(found);
  const std::vector<double> true_times = times_of(truth);
  MatchedPoses matched{!found_times.empty() && !true_times.empty(), {}, {}, found.size(), truth.size()};
  std::vector<PosePair> pairs;
  if (matched.is_by_time) {
    pairs = match_times(found_times, true_times, tolerance);
  } else {
    for (std::size_t i = 0; i < std::min(found.size(), truth.size()); ++i) pairs.push_back({i, i});
  }
  for (const auto& [found_index, true_index] : pairs) {
    matched.found.push_back(found[found_index].T_map_sensor);
    matched.truth.push_back(truth[true_index].T_map_sensor);
  }
  matched.unmatched_found -= pairs.size();
  matched.unmatched_truth -= pairs.size();
  return matched;
}

/// One file's times may be of the begin of each scan, the other's of its end: then each pose fits the true
/// one beside its partner.
void warn_of_shift(const MatchedPoses& matched, double rmse) {
  constexpr double kFits = 0.3;  // of the error as matched
  if (matched.found.size() < 3) return;
  const auto but_first = [](const std::vector<Pose>& poses) {
    return std::vector<Pose>(poses.begin() + 1, poses.end());
  };
  const auto but_last = [](const std::vector<Pose>& poses) {
    return std::vector<Pose>(poses.begin(), poses.end() - 1);
  };
  const double late =
      compare_trajectories(but_last(matched.truth), but_first(matched.found)).translation_rmse();
  const double early =
      compare_trajectories(but_first(matched.truth), but_last(matched.found)).translation_rmse();
  if (std::min(late, early) >= kFits * rmse) return;
  spdlog::warn(
      "the poses fit the true ones of the scan {} better, {:.4f} m rms instead of {:.4f}; are the times "
      "of both files those of the same moment of a scan?",
      late < early ? "before" : "after", std::min(late, early), rmse);
}

void score_trajectory(const EvaluateOptions& options) {
  constexpr double kLongestStretch = 100;  ///< [m]
  constexpr double kDegrees = 180 / std::numbers::pi;
  const std::filesystem::path found = options.trajectory[0];
  const std::filesystem::path truth = options.trajectory[1];
  const std::vector<StampedPose> found_poses = read_trajectory(found);
  const std::vector<StampedPose> true_poses = read_trajectory(truth);
  const MatchedPoses matched = match(found_poses, true_poses, options.tolerance);
  if (!matched.is_by_time && found_poses.size() != true_poses.size()) {
    throw FileError(found,
                    fmt::format("has {} poses, {} has {}, and not both have times: nothing tells which "
                                "belong together; give times to both (TUM)",
                                found_poses.size(), truth.string(), true_poses.size()));
  }
  if (matched.found.empty()) {
    throw FileError(found, fmt::format("no pose is within {} s of one of {}; check both files' times",
                                       options.tolerance, truth.string()));
  }
  const TrajectoryError error = compare_trajectories(matched.truth, matched.found);
  if (matched.is_by_time) warn_of_shift(matched, error.translation_rmse());
  const double stretch = std::min(kLongestStretch, path_length(matched.truth));
  const double drifted = stretch > 0 ? drift(matched.truth, matched.found, stretch) : NAN;
  if (options.as_json) {
    fmt::print("{}", dump({{"poses", matched.found.size()},
                           {"matched_by", matched.is_by_time ? "time" : "order"},
                           {"unmatched_found", matched.unmatched_found},
                           {"unmatched_true", matched.unmatched_truth},
                           {"ate_rmse_m", error.translation_rmse()},
                           {"ate_rmse_aligned_m", error.aligned_translation_rmse},
                           {"ate_max_m", error.translation_max()},
                           {"rotation_rmse_deg", error.rotation_rmse() * kDegrees},
                           {"rotation_max_deg", error.rotation_max() * kDegrees},
                           {"drift_percent", 100 * drifted},
                           {"drift_stretch_m", stretch},
                           {"fraction_lost", error.fraction_lost()}}));
    return;
  }
  fmt::print("poses      {} matched by {}; without a partner: {} found, {} true\n", matched.found.size(),
             matched.is_by_time ? "time" : "order", matched.unmatched_found, matched.unmatched_truth);
  fmt::print("ATE        {:.4f} m rms, {:.4f} m at most; {:.4f} m rms after rigid alignment\n",
             error.translation_rmse(), error.translation_max(), error.aligned_translation_rmse);
  fmt::print("rotation   {:.4f} deg rms, {:.4f} deg at most\n", error.rotation_rmse() * kDegrees,
             error.rotation_max() * kDegrees);
  fmt::print("drift      {:.3f} % over stretches of {:.1f} m\n", 100 * drifted, stretch);
  fmt::print("lost       {:.2f} % of the poses, more than 1 m or 5 degrees off\n",
             100 * error.fraction_lost());
}

void run_evaluate(const EvaluateOptions& options) {
  if (!options.trajectory.empty()) return score_trajectory(options);
  if (options.map.empty()) throw CLI::RequiredError("MAP.evm, or --trajectory,");
  if (options.scans.empty()) throw CLI::RequiredError("SCANS");
  if (options.poses.empty()) throw CLI::RequiredError("--poses");
  if (options.boxes.empty()) throw CLI::RequiredError("--boxes");
  score_map(options);
}

}  // namespace

void add_evaluate(CLI::App& app) {
  CLI::App* verb =
      app.add_subcommand("evaluate", "Score a map on raw points of labelled scans, or a trajectory");
  const auto options = std::make_shared<EvaluateOptions>();
  CLI::Option* map = verb->add_option("MAP.evm", options->map, "Map to score");
  verb->add_option("SCANS", options->scans, "Folder of scans");
  verb->add_option("--poses", options->poses, "Poses of the scans (TUM or KITTI)");
  verb->add_option("--boxes", options->boxes, "Labelled boxes (.csv) with a column 'moving'");
  CLI::Option* trajectory =
      verb->add_option("--trajectory", options->trajectory,
                       "Instead of a map: score found poses against true ones, both TUM or KITTI")
          ->expected(2)
          ->type_name("FOUND TRUTH")
          ->excludes(map);
  verb->add_option("--max-time-difference", options->tolerance, "Between a found pose and the true one")
      ->check(CLI::Range(0.0, 10.0))
      ->type_name("S")
      ->capture_default_str()
      ->needs(trajectory);
  add_json_option(*verb, options->as_json);
  verb->callback([options] { run_evaluate(*options); });
}

}  // namespace evermap
