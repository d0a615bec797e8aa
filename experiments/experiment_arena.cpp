// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <numbers>
#include <random>

#include <fmt/format.h>

#include "experiments/experiment.hpp"
#include "experiments/pcl_localizer.hpp"
#include "experiments/pose_judge.hpp"
#include <evermap/geometry/detail/degree.hpp>
#include <evermap/localization/detail/perturbation.hpp>
#include <evermap/maintenance/map_maintainer.hpp>
#include <evermap/maintenance/survey.hpp>
#include <evermap/scan/detail/ray_bundle.hpp>
#include <evermap/simulation/draw.hpp>
#include <evermap/simulation/random_world.hpp>
#include <evermap/simulation/scenario_drive.hpp>
#include <evermap/update/detail/map_updater.hpp>

namespace evermap {
namespace {

/// A short drive through a world that nobody tuned anything on.
struct Trial {
  std::uint64_t seed;
  std::string_view kind;
  RandomDrive drive;
  double leaf;                   ///< [m]
  std::string mount;             ///< of the sensor
  bool is_surveyed;              ///< else the robot drove here before, with known poses
  bool maintains;                ///< the map, with the poses that it finds
  std::string odometry;          ///< none, true, drifting or slipping
  Eigen::Vector3d shift;         ///< [m] of the frame, so that walls lie anywhere in the grid
  double start_off, start_turn;  ///< [m] and [rad] by which the first pose is wrong
};

Trial trial_of(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Trial trial;
  trial.seed = seed;
  trial.kind = kWorldKinds[seed % kWorldKinds.size()];
  trial.drive.channels = one_of(random, {16, 32, 64, 128});
  trial.drive.starts_at_speed = one_of(random, {true, false});
  trial.drive.changed = one_of(random, {0.0, 0.1, 0.2, 0.3, 0.5});
  trial.leaf = one_of(random, {0.1, 0.2, 0.2, 0.4, 0.4, 0.8});
  trial.mount = one_of(random, {"upright", "upright", "tilted", "upside down"});
  trial.is_surveyed = one_of(random, {true, true, false});
  trial.maintains = one_of(random, {true, false});
  trial.odometry = one_of(random, {"none", "none", "true", "drifting", "slipping"});
  for (int axis = 0; axis < 3; ++axis) trial.shift[axis] = uniform(random, 0, 1);
  const double off = one_of(random, {0.0, 0.3, 1.0});
  trial.start_off = off;
  trial.start_turn = 10 * off * kDegree;
  return trial;
}

/// How the sensor is mounted on the robot.
Pose mount_of(const Trial& trial) {
  Twist turn = Twist::Zero();
  if (trial.mount == "tilted") turn[4] = 30 * kDegree;
  if (trial.mount == "upside down") turn[3] = std::numbers::pi;
  return exp(turn);
}

/// Odometry as wheels give it, from the true poses.
class Odometry {
 public:
  explicit Odometry(std::string kind) : kind_(std::move(kind)) {}

  std::optional<Pose> next(const Pose& T_map_sensor) {
    constexpr int kSlip = 12;  // the scan before which the wheels turn in place
    if (scans_++ > 0) {
      Pose step = T_before_.inverse() * T_map_sensor;
      if (kind_ == "drifting") step.translation *= 1.01;
      if (kind_ == "slipping" && scans_ == kSlip) step.translation.setZero();
      T_odom_ = T_odom_ * step;
    }
    T_before_ = T_map_sensor;
    if (kind_ == "none") return std::nullopt;
    return T_odom_;
  }

 private:
  std::string kind_;
  int scans_ = 0;
  Pose T_before_, T_odom_;
};

/// The scans and poses of the drive, in the shifted frame, by the mounted sensor.
struct Drive {
  explicit Drive(const Trial& trial)
      : driven(parse_scenario(fmt::format("arena {}", trial.seed),
                              random_world(trial.kind, trial.seed, trial.drive))) {
    const Pose T_robot_sensor = mount_of(trial);
    const Pose T_sensor_robot = T_robot_sensor.inverse();
    for (std::size_t i = 0; i < driven.size(); ++i) {
      scans.push_back(driven.scan(i).scan);
      Pose T_map_sensor = driven.T_map_sensor(i) * T_robot_sensor;
      worlds_pose.push_back(T_map_sensor);
      const Pose T_sensor_world = T_map_sensor.inverse();
      at_end.push_back(driven.in_map(i, scans.back()));
      for (Eigen::Vector3d& p : at_end.back()) p = T_sensor_world * p;
      for (Eigen::Vector3d& p : scans.back().p_sensor) p = T_sensor_robot * p;
      T_map_sensor.translation += trial.shift;
      poses.push_back(T_map_sensor);
    }
  }

  ScenarioDrive driven;
  std::vector<Scan> scans;
  std::vector<std::vector<Eigen::Vector3d>> at_end;  ///< [m] points in the sensor frame of a scan's end
  std::vector<Pose> worlds_pose;                     ///< in the world's frame
  std::vector<Pose> poses;                           ///< in the map's frame, which is shifted
};

/// The points that the map is made of, in its frame [m].
std::vector<Eigen::Vector3d> cloud_of(const Trial& trial, const Drive& drive) {
  std::vector<Eigen::Vector3d> cloud;
  if (trial.is_surveyed) {
    cloud = drive.driven.survey(std::min(0.1, trial.leaf / 4));
    for (Eigen::Vector3d& p : cloud) p += trial.shift;
    return cloud;
  }
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    for (const Eigen::Vector3d& p : drive.at_end[i]) cloud.push_back(drive.poses[i] * p);
  }
  return cloud;
}

Octree map_of(const Trial& trial, const Drive& drive, const Parameters& parameters) {
  Octree map(VoxelGrid{.edge = trial.leaf});
  if (trial.is_surveyed) {
    Scan cloud;
    cloud.p_sensor = cloud_of(trial, drive);
    add_survey(map, cloud, Pose{}, parameters);
    return map;
  }
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    Scan scan;
    scan.p_sensor = drive.at_end[i];
    add(map, condense(scan, drive.poses[i], map.grid(), parameters.lidar), parameters.update);
  }
  return map;
}

/// The first pose, as wrong as the trial says, in a direction of its own.
Pose start_of(const Trial& trial, const Pose& T_map_sensor) {
  const double towards = static_cast<double>(trial.seed);  // [rad]
  Twist off = Twist::Zero();
  off.head<2>() = trial.start_off * Eigen::Vector2d(std::cos(towards), std::sin(towards));
  off[5] = trial.start_turn * (trial.seed % 2 == 0 ? 1 : -1);
  return perturb(T_map_sensor, off);
}

/// The poses that are believed of a trial's scans, none where none is.
using Believed = std::vector<std::optional<Pose>>;

/// What the judge says of them.
struct Verdict {
  int observable = 0;  ///< [scans]
  int tracked = 0;     ///< of these, believed
  std::vector<bool> wrong;
  std::vector<double> errors;  ///< [m] of what is believed

  Json to_json() const {
    return {{"observable", observable},
            {"tracked", tracked},
            {"wrong", std::count(wrong.begin(), wrong.end(), true)},
            {"errors", errors}};
  }
};

Verdict judged(const Trial& trial, const Drive& drive, const Believed& believed) {
  constexpr double kWrong = 0.05;  // [m]
  constexpr double kWrongTurn = 0.5 * kDegree;
  const RayCaster world(drive.driven.scene(0));
  Verdict verdict;
  verdict.wrong.resize(believed.size(), false);
  for (std::size_t i = 0; i < believed.size(); ++i) {
    const PoseJudge judge(world, drive.at_end[i], drive.worlds_pose[i]);
    verdict.observable += judge.is_observable() ? 1 : 0;
    if (!believed[i]) continue;
    verdict.tracked += judge.is_observable() ? 1 : 0;
    Pose in_world = *believed[i];
    in_world.translation -= trial.shift;
    const PoseJudge::Error error = judge.error(in_world);
    verdict.wrong[i] = error.translation > kWrong || error.rotation > kWrongTurn;
    verdict.errors.push_back(error.translation);
  }
  return verdict;
}

Parameters parameters_of(const Drive& drive) {
  Parameters parameters;
  parameters.lidar.range_sigma = drive.driven.scenario().lidar.range_sigma;
  return parameters;
}

std::vector<ScanResult> localize(const Trial& trial, const Drive& drive) {
  const Parameters parameters = parameters_of(drive);
  MapMaintainer maintainer(map_of(trial, drive, parameters), parameters,
                           trial.maintains ? MapMode::kMaintenance : MapMode::kLocalization,
                           start_of(trial, drive.poses.front()));
  Odometry odometry(trial.odometry);
  std::vector<ScanResult> results;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    append(results, maintainer.process(drive.scans[i], drive.driven.time(i), odometry.next(drive.poses[i])));
  }
  return results;
}

Believed believed(const std::vector<ScanResult>& results) {
  Believed poses;
  for (const ScanResult& found : results)
    poses.push_back(found.is_believed() ? std::optional(found.T_map_sensor) : std::nullopt);
  return poses;
}

Believed localize_by_pcl(std::string_view method, const Trial& trial, const Drive& drive) {
  PclLocalizer localizer(method, cloud_of(trial, drive), start_of(trial, drive.poses.front()),
                         parameters_of(drive).lidar.scan_period);
  Odometry odometry(trial.odometry);
  Believed poses;
  for (std::size_t i = 0; i < drive.scans.size(); ++i)
    poses.push_back(localizer.locate(drive.scans[i], odometry.next(drive.poses[i])));
  return poses;
}

Json run_trial(std::uint64_t seed) {
  const Trial trial = trial_of(seed);
  const Drive drive(trial);
  const std::vector<ScanResult> results = localize(trial, drive);
  const Verdict verdict = judged(trial, drive, believed(results));
  int wrong_written = 0;
  for (std::size_t i = 0; i < results.size(); ++i)
    wrong_written += verdict.wrong[i] && results[i].is_written ? 1 : 0;
  Json facts{{"seed", seed},
             {"kind", trial.kind},
             {"beams", trial.drive.channels},
             {"leaf", trial.leaf},
             {"mount", trial.mount},
             {"map", trial.is_surveyed ? "survey" : "drive"},
             {"maintains", trial.maintains},
             {"odometry", trial.odometry},
             {"start", trial.start_off},
             {"at speed", trial.drive.starts_at_speed},
             {"changed", trial.drive.changed},
             {"scans", drive.scans.size()},
             {"wrong written", wrong_written}};
  facts.update(verdict.to_json());
  return facts;
}

/// The same trial by evermap and by PCL.
Json run_comparison(std::uint64_t seed) {
  const Trial trial = trial_of(seed);
  const Drive drive(trial);
  Json mappers{{"evermap", judged(trial, drive, believed(localize(trial, drive))).to_json()}};
  for (const std::string_view method : PclLocalizer::kMethods)
    mappers[std::string(method)] = judged(trial, drive, localize_by_pcl(method, trial, drive)).to_json();
  return {{"seed", seed}, {"kind", trial.kind}, {"scans", drive.scans.size()}, {"mappers", mappers}};
}

/// As many trials as there are kinds of worlds, one of each.
Unit round_of(std::string_view name, std::string_view title, Json (*run)(std::uint64_t seed),
              std::uint64_t first_seed) {
  const auto compute = [run, first_seed](const Progress& progress) {
    Json trials = Json::array();
    for (std::size_t i = 0; i < kWorldKinds.size(); ++i) {
      trials.push_back(run(first_seed + i));
      progress(i + 1, kWorldKinds.size());
    }
    return Json{{"trials", trials}};
  };
  return {fmt::format("{}_{}", name, first_seed),
          fmt::format("{} from seed {}", title, first_seed),
          {{"seed", first_seed}},
          compute};
}

}  // namespace

Experiment experiment_arena(const Setup& setup) {
  const std::uint64_t rounds = setup.is_quick ? 2 : 91;  // 22 and 1001 trials
  Experiment experiment{"arena"};
  for (std::uint64_t i = 0; i < rounds; ++i) {
    const std::uint64_t seed = setup.seed + i * kWorldKinds.size();
    experiment.units.push_back(round_of("arena", "trials", run_trial, seed));
  }
  if (setup.is_quick) return experiment;
  if (!PclLocalizer::is_available()) {
    experiment.left_out.emplace_back("PCL's NDT and GICP: evermap was built without PCL (libpcl-dev)");
    return experiment;
  }
  constexpr std::uint64_t kRoundsOfAll = 4;  // PCL takes a second a scan
  for (std::uint64_t i = 0; i < kRoundsOfAll; ++i) {
    const std::uint64_t seed = setup.seed + i * kWorldKinds.size();
    experiment.units.push_back(round_of("arena_by_all", "trials by PCL, too,", run_comparison, seed));
  }
  return experiment;
}

}  // namespace evermap
