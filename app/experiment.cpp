// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <fmt/core.h>

#include "options.hpp"
#include "posed_scans.hpp"
#include "progress_bar.hpp"
#include "report.hpp"
#include "verbs.hpp"
#include "yard_trial.hpp"
#include <evermap/evaluation/labelled_drive.hpp>
#include <evermap/evaluation/map_claims.hpp>
#include <evermap/io/labelled_boxes.hpp>
#include <evermap/update/map_updater.hpp>
#include <evermap/update/viewpoint.hpp>

namespace evermap {
namespace {

constexpr double kStillThere = 0.1;  // [m] from a point of the last scans
constexpr std::size_t kStandstillScans = 100;

struct Rule {
  std::string name;
  UpdateParameters parameters;
};

/// Each row adds one rule to the row before, from the paper to the default; then what the default leaves out.
std::vector<Rule> rules() {
  std::vector<Rule> rows;
  UpdateParameters p = UpdateParameters::paper();
  const auto add = [&](const std::string& name, const std::function<void(UpdateParameters&)>& change) {
    change(p);
    rows.push_back({name, p});
  };
  const auto instead = [&](const std::string& name, const std::function<void(UpdateParameters&)>& change) {
    UpdateParameters other = p;
    change(other);
    rows.push_back({name, other});
  };
  add("paper, inverse third case", [](auto&) {});
  instead("paper, printed third case", [](auto& q) { q.impact = ImpactRule::kEquation5Printed; });
  add("- sigma-point difference", [](auto& q) { q.difference = Difference::kNone; });
  add("closest approach", [](auto& q) {
    q.impact = ImpactRule::kClosestApproach;
    q.least_impact = UpdateParameters{}.least_impact;
  });
  add("+ noisy-or", [](auto& q) { q.combination = Combination::kNoisyOr; });
  add("+ surface crossing", [](auto& q) { q.surface_crossing = true; });
  add("+ 1 m end guard", [](auto& q) { q.end_guard = UpdateParameters{}.end_guard; });
  add("+ memory of 1000 points", [](auto& q) { q.max_count = UpdateParameters{}.max_count; });
  add("+ three confirmations", [](auto& q) { q.confirmations = UpdateParameters{}.confirmations; });
  add("+ viewpoint memory", [](auto& q) { q.standstill = UpdateParameters{}.standstill; });
  instead("+ coplanar-hit guard", [](auto& q) { q.surface_guard = SurfaceGuard::kCoplanarHit; });
  add("+ reobserved guard = default", [](auto& q) { q.surface_guard = SurfaceGuard::kReobserved; });
  instead("default + incidence weight", [](auto& q) { q.incidence_weight = true; });
  instead("default + soft difference", [](auto& q) { q.difference = Difference::kSoft; });
  instead("default + sigma-point difference", [](auto& q) { q.difference = Difference::kSigmaPoints; });
  return rows;
}

std::vector<PosedScan> read_all(PosedScans scans) {
  std::vector<PosedScan> all;
  while (auto posed = scans.next()) all.push_back(std::move(*posed));
  return all;
}

/// kitti_0005_drive: a map built of all scans, then updated over them.
class DriveTrial {
 public:
  explicit DriveTrial(const std::filesystem::path& folder)
      : scans_(read_all(PosedScans(folder / "scans", folder / "poses_kitti.txt"))),
        boxes_(read_labelled_boxes(folder / "boxes_velo.csv")) {
    boxes_.resize(scans_.size());
  }

  DriveScore run(double edge, UpdateParameters parameters) const {
    parameters.lidar.min_range = 2.5;  // the vehicle's own roof
    Octree octree(VoxelGrid{edge});
    for (const PosedScan& s : scans_) add_scan(octree, s.scan, s.T_map_sensor, parameters);
    Viewpoint viewpoint(parameters.standstill);
    for (const PosedScan& s : scans_) {
      update(octree, s.scan, s.T_map_sensor, parameters, viewpoint.novelty(s.T_map_sensor));
    }
    DriveScore score;
    for (std::size_t i = 0; i < scans_.size(); ++i) {
      add_to_score(score, scans_[i].scan, scans_[i].T_map_sensor, boxes_[i],
                   i + DriveScore::kLastScans >= scans_.size(), [&](const Eigen::Vector3d& p_map) {
                     return claims(octree, p_map, DriveScore::kPoseSigma);
                   });
    }
    return score;
  }

 private:
  std::vector<PosedScan> scans_;
  std::vector<std::vector<LabelledBox>> boxes_;
};

/// kitti_redlight_standstill: a map of scans 55 to 60, updated over 61 to 76 from one place.
class RedlightTrial {
 public:
  explicit RedlightTrial(const std::filesystem::path& folder) {
    ScanSource source(folder / "scans");
    while (auto scan = source.next()) scans_.push_back(std::move(*scan));
    if (scans_.size() < kUpdated + kBuilt) throw std::runtime_error(folder.string() + ": has too few scans");
    scans_.erase(scans_.begin(), scans_.end() - kUpdated - kBuilt);
    Points early;
    Points late;
    for (std::size_t i = 0; i < scans_.size(); ++i) {
      Points& points = i < kBuilt ? early : late;
      if (i < kBuilt || i + 3 >= scans_.size()) {
        points.insert(points.end(), scans_[i].p_sensor.begin(), scans_[i].p_sensor.end());
      }
    }
    const std::vector<double> distances = nearest_distances(early, late);
    for (std::size_t i = 0; i < early.size(); ++i) {
      if (distances[i] < kStillThere && early[i].norm() > 2.5) still_there_.push_back(early[i]);
    }
  }

  /// Share of the surface that is still there which the map keeps.
  double run(double edge, UpdateParameters parameters) const {
    parameters.lidar.min_range = 2.5;
    Octree octree(VoxelGrid{edge});
    Viewpoint viewpoint(parameters.standstill);
    for (std::size_t i = 0; i < kBuilt; ++i) add_scan(octree, scans_[i], Pose{}, parameters);
    for (std::size_t i = kBuilt; i < scans_.size(); ++i) {
      update(octree, scans_[i], Pose{}, parameters, viewpoint.novelty(Pose{}));
    }
    return share_true(still_there_, [&](const Eigen::Vector3d& p_map) {
      return claims(octree, p_map, DriveScore::kPoseSigma);
    });
  }

 private:
  static constexpr std::ptrdiff_t kBuilt = 6;
  static constexpr std::ptrdiff_t kUpdated = 16;

  std::vector<Scan> scans_;
  Points still_there_;
};

YardScore run(const YardTrial& trial, const UpdateParameters& parameters) {
  Octree octree = trial.initial_map();
  Viewpoint viewpoint(parameters.standstill);
  for (std::size_t i = 0; i < trial.size(); ++i) {
    update(octree, trial.scan(i), trial.pose(i), parameters, viewpoint.novelty(trial.pose(i)));
  }
  return trial.score(octree);
}

struct Options {
  std::filesystem::path data;
  std::string only;  ///< part of the names of the rules to score; empty for all
  bool as_json = false;
};

void run_ablation(const Options& options) {
  const DriveTrial drive(options.data / "kitti_0005_drive");
  const RedlightTrial redlight(options.data / "kitti_redlight_standstill");
  const Yard yard = make_yard();
  const std::vector<Pose> standstill(kStandstillScans, yard.T_map_sensor[yard.T_map_sensor.size() / 2]);
  Json rows = Json::array();
  std::vector<Rule> all = rules();
  std::erase_if(all, [&](const Rule& rule) { return rule.name.find(options.only) == std::string::npos; });
  ProgressBar bar(2 * all.size());
  for (std::size_t done = 0; const double edge : {0.2, 0.4}) {
    const YardTrial driving(edge, yard.T_map_sensor, yard);
    const YardTrial standing(edge, standstill, yard);
    if (!options.as_json) {
      fmt::print(
          "\nleaf {} m                         | real drive                    | red  | yard, drive | yard,\n"
          "rule                             | static parked moving  AA      | light| SA     DA   | still\n",
          edge);
    }
    for (const Rule& rule : all) {
      const DriveScore real = drive.run(edge, rule.parameters);
      const double kept = redlight.run(edge, rule.parameters);
      const YardScore driven = run(driving, rule.parameters);
      const YardScore stood = run(standing, rule.parameters);
      rows.push_back({{"leaf", edge},
                      {"rule", rule.name},
                      {"drive_static_kept", real.all_static.value()},
                      {"drive_static_kept_in_labelled_view", real.seen_static.value()},
                      {"drive_parked_kept", real.parked.value()},
                      {"drive_moving_removed", real.removed()},
                      {"drive_associated_accuracy", real.associated_accuracy()},
                      {"redlight_kept", kept},
                      {"yard_SA", driven.static_accuracy},
                      {"yard_DA", driven.dynamic_accuracy},
                      {"yard_standstill_SA", stood.static_accuracy}});
      bar.show(++done);
      if (options.as_json) continue;
      fmt::print("{:<32} | {:.4f} {:.4f} {:.4f} {:.4f}  | {:.4f}| {:.4f} {:.4f}| {:.4f}\n", rule.name,
                 real.all_static.value(), real.parked.value(), real.removed(), real.associated_accuracy(),
                 kept, driven.static_accuracy, driven.dynamic_accuracy, stood.static_accuracy);
      std::fflush(stdout);
    }
  }
  if (options.as_json) fmt::print("{}", dump(rows));
}

}  // namespace

void add_experiment(CLI::App& app) {
  CLI::App* experiment = app.add_subcommand("experiment", "Repeat a published measurement");
  experiment->require_subcommand(1);
  CLI::App* verb = experiment->add_subcommand("ablation", "Score the update's rules, one added at a time");
  const auto options = std::make_shared<Options>();
  verb->add_option("--data", options->data,
                   "Folder with kitti_0005_drive and kitti_redlight_standstill (docs/results.md)")
      ->required()
      ->type_name("DIR");
  verb->add_option("--only", options->only, "Score only the rules whose name has this in it")
      ->type_name("TEXT");
  add_json_option(*verb, options->as_json);
  verb->callback([options] { run_ablation(*options); });
}

}  // namespace evermap
