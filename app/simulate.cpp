// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdint>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <oneapi/tbb/parallel_for.h>

#include "command_line.hpp"
#include "progress_bar.hpp"
#include "verbs.hpp"
#include <evermap/evaluation/observed_surface.hpp>
#include <evermap/files/file_error.hpp>
#include <evermap/io/detail/atomic_file.hpp>
#include <evermap/io/detail/pcd.hpp>
#include <evermap/io/detail/ply.hpp>
#include <evermap/io/poses.hpp>
#include <evermap/simulation/scenario_drive.hpp>

namespace evermap {
namespace {

/// The first line of scenario.yaml in a folder that this verb has written and may write again.
constexpr std::string_view kFirstLine = "# Written by evermap simulate";
constexpr double kObservedReach = 0.1;  ///< [m] from a ray's end to the surface that it observed

struct SimulateOptions {
  std::string scenario;
  std::filesystem::path folder;
  std::optional<int> scans;
  std::optional<std::uint64_t> seed;
  std::vector<std::size_t> truth;
  double spacing = 0.1;  ///< [m]
};

Scenario scenario_of(const SimulateOptions& options) {
  const std::vector<std::string> shipped = shipped_scenario_names();
  const bool is_shipped = std::find(shipped.begin(), shipped.end(), options.scenario) != shipped.end();
  const bool is_path = options.scenario.find_first_of("./") != std::string::npos;
  Scenario scenario =
      is_shipped || !is_path ? shipped_scenario(options.scenario) : read_scenario(options.scenario);
  scenario.scans = options.scans.value_or(scenario.scans);
  scenario.seed = options.seed.value_or(scenario.seed);
  return scenario;
}

/// The scans at whose ends the truth is wanted, in order.
std::vector<std::size_t> truth_indices(const SimulateOptions& options, const ScenarioDrive& drive) {
  std::vector<std::size_t> indices = options.truth;
  if (indices.empty()) indices.push_back(drive.size() - 1);
  std::sort(indices.begin(), indices.end());
  indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
  if (indices.back() < drive.size()) return indices;
  throw std::runtime_error(
      fmt::format("--truth {}: the {} scans are numbered from 0", indices.back(), drive.size()));
}

bool is_ours(const std::filesystem::path& folder) {
  std::ifstream file(folder / "scenario.yaml");
  std::string line;
  std::getline(file, line);
  return line.starts_with(kFirstLine);
}

/// Takes away what an earlier run has written, first of all what makes it look complete.
void clear(const std::filesystem::path& folder) {
  std::filesystem::remove(folder / "poses.txt");
  std::filesystem::remove_all(folder / "scans");
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name == "survey.ply" || (name.starts_with("truth_") && name.ends_with(".ply"))) {
      std::filesystem::remove(entry.path());
    }
  }
}

void write_text(const std::filesystem::path& path, std::string_view text) {
  AtomicFile file(path);
  file.write(text);
  file.commit();
}

void prepare_folder(const SimulateOptions& options, const ScenarioDrive& drive) {
  try {
    std::filesystem::create_directories(options.folder);
    clear(options.folder);
    std::filesystem::create_directories(options.folder / "scans");
  } catch (const std::filesystem::filesystem_error& error) {
    throw FileError(options.folder, "cannot be prepared: " + error.code().message());
  }
  const Scenario& scenario = drive.scenario();
  write_text(options.folder / "scenario.yaml",
             fmt::format("{} from {}: {} scans, seed {}\n{}", kFirstLine, scenario.source, scenario.scans,
                         scenario.seed, scenario.text));
}

void write_survey(const std::filesystem::path& path, const std::vector<Eigen::Vector3d>& survey) {
  PointTable table{{{"x"}, {"y"}, {"z"}}, {}};
  table.values.reserve(3 * survey.size());
  for (const Eigen::Vector3d& p_map : survey)
    table.values.insert(table.values.end(), p_map.begin(), p_map.end());
  write_ply(path, table);
}

void write_scan(const std::filesystem::path& path, const LabelledScan& labelled, const ScenarioDrive& drive) {
  PointTable table{{{"x"}, {"y"}, {"z"}, {"time"}, {"object"}, {"class"}}, {}};
  const std::vector<float>& times = labelled.scan.time_offset;
  for (std::size_t i = 0; i < labelled.object.size(); ++i) {
    const Eigen::Vector3d& p = labelled.scan.p_sensor[i];
    const int object = labelled.object[i];
    table.values.insert(table.values.end(),
                        {p.x(), p.y(), p.z(), times.empty() ? 0.0 : times[i], static_cast<double>(object),
                         static_cast<double>(drive.class_of(object))});
  }
  write_pcd(path, table);
}

/// The true surface at a scan: points of an ObservedSurface and what they are on.
struct Truth {
  std::size_t scan;
  std::vector<std::uint32_t> points;
  std::vector<int> objects;
};

Truth truth_of(const ScenarioDrive& drive, std::size_t scan, double spacing, ObservedSurface& surface) {
  Truth truth{scan, {}, {}};
  Points points;
  for (const auto& [p_map, object] : drive.truth(scan, spacing)) {
    points.push_back(p_map);
    truth.objects.push_back(object);
  }
  truth.points = surface.add_surface(points);
  return truth;
}

void write_truth(const std::filesystem::path& path, const Truth& truth, const ObservedSurface& surface,
                 bool observed_only, const ScenarioDrive& drive) {
  PointTable table{{{"x"}, {"y"}, {"z"}, {"object"}, {"class"}}, {}};
  if (!observed_only) table.values.reserve(truth.points.size() * table.columns.size());
  for (std::size_t i = 0; i < truth.points.size(); ++i) {
    if (observed_only && !surface.is_observed(truth.points[i])) continue;
    const Eigen::Vector3d& p = surface.point(truth.points[i]);
    const int object = truth.objects[i];
    table.values.insert(table.values.end(), {p.x(), p.y(), p.z(), static_cast<double>(object),
                                             static_cast<double>(drive.class_of(object))});
  }
  write_ply(path, table);
}

/// Writes the truth at a scan: all, and what the run had observed by then.
void write_truths(const std::filesystem::path& folder, const Truth& truth, const ObservedSurface& surface,
                  const ScenarioDrive& drive) {
  write_truth(folder / fmt::format("truth_{:06}.ply", truth.scan), truth, surface, false, drive);
  write_truth(folder / fmt::format("truth_{:06}_observed.ply", truth.scan), truth, surface, true, drive);
}

/// Writes scans [begin, end) side by side and gives their ray ends.
std::vector<Points> write_scans(const std::filesystem::path& folder, const ScenarioDrive& drive,
                                std::size_t begin, std::size_t end) {
  std::vector<Points> ends(end - begin);
  oneapi::tbb::parallel_for(begin, end, [&](std::size_t i) {
    const LabelledScan labelled = drive.scan(i);
    write_scan(folder / "scans" / fmt::format("{:06}.pcd", i), labelled, drive);
    ends[i - begin] = drive.in_map(i, labelled.scan);
  });
  return ends;
}

void write_drive(const SimulateOptions& options, const ScenarioDrive& drive,
                 const std::vector<std::size_t>& scans) {
  constexpr std::size_t kSideBySide = 16;
  ObservedSurface surface(kObservedReach);
  std::vector<Truth> truths;
  truths.reserve(scans.size());
  for (const std::size_t scan : scans) truths.push_back(truth_of(drive, scan, options.spacing, surface));
  ProgressBar bar(drive.size());
  auto truth = truths.begin();
  for (std::size_t done = 0; done < drive.size();) {
    std::size_t end = std::min(done + kSideBySide, drive.size());
    if (truth != truths.end()) end = std::min(end, truth->scan + 1);
    for (const Points& of_scan : write_scans(options.folder, drive, done, end)) {
      if (truth != truths.end()) surface.add_ends(of_scan);
    }
    done = end;
    bar.show(done);
    if (truth == truths.end() || done <= truth->scan) continue;
    write_truths(options.folder, *truth++, surface, drive);
  }
}

void run_simulate(const SimulateOptions& options) {
  const ScenarioDrive drive(scenario_of(options));
  const std::vector<std::size_t> truths = truth_indices(options, drive);
  check_may_fill(options.folder, "evermap simulate", [&] { return is_ours(options.folder); });
  prepare_folder(options, drive);
  write_survey(options.folder / "survey.ply", drive.survey(options.spacing));
  write_drive(options, drive, truths);
  std::vector<StampedPose> poses;
  for (std::size_t i = 0; i < drive.size(); ++i) poses.push_back({drive.time(i), drive.T_map_sensor(i)});
  write_tum_poses(options.folder / "poses.txt", poses);
  fmt::print("folder   {}\nscans    {}\n", options.folder.string(), drive.size());
}

}  // namespace

void add_simulate(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("simulate", "Simulate a drive through a world that changes");
  const auto options = std::make_shared<SimulateOptions>();
  verb->add_option("SCENARIO", options->scenario,
                   fmt::format("File .yaml, or one of: {}", fmt::join(shipped_scenario_names(), " ")))
      ->required();
  verb->add_option("-o,--output", options->folder, "Folder for scans, poses, survey and truth")
      ->required()
      ->type_name("DIR");
  verb->add_option("--scans", options->scans, "Scans to simulate instead of the scenario's")
      ->check(CLI::Range(1, 1000000))
      ->type_name("N");
  verb->add_option("--seed", options->seed, "Seed of the sensor's noise instead of the scenario's")
      ->type_name("S");
  verb->add_option("--truth", options->truth, "Scans, from 0, at which the true surface is written")
      ->delimiter(',')
      ->type_name("I,J,..")
      ->default_str("the last");
  verb->add_option("--spacing", options->spacing, "Between points of survey and truth")
      ->check(CLI::Range(0.01, 10.0))
      ->type_name("M")
      ->capture_default_str();
  verb->callback([options] { run_simulate(*options); });
}

}  // namespace evermap
