// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <memory>

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include "birds_eye.hpp"
#include "options.hpp"
#include "report.hpp"
#include "verbs.hpp"
#include <evermap/io/detail/atomic_file.hpp>
#include <evermap/io/detail/map_lock.hpp>
#include <evermap/io/detail/map_undo.hpp>
#include <evermap/io/map_file.hpp>

namespace evermap {
namespace {

struct UpdateOptions {
  std::filesystem::path map;
  RunOptions run;
  std::filesystem::path output;
  ParameterOptions parameters;
  std::filesystem::path report;  ///< folder; empty when not asked for
  bool undo_log = false;
  double patience = 0;  ///< [s]
  bool as_json = false;
};

void prepare_outputs(const UpdateOptions& options) {
  check_writable(options.output);
  if (options.report.empty()) return;
  make_folder(options.report);
  check_writable(options.report / "report.json");
}

void write_report(const std::filesystem::path& folder, const ChangeReport& report, const Octree& before,
                  const Octree& after) {
  AtomicFile file(folder / "report.json");
  file.write(dump(to_json(report)));
  file.commit();
  // Whoever interrupts waits for the end: of a large map, pictures take longer than saving it.
  if (report.run.stopped_by == 0) write_pictures(folder, before, after, report.difference);
}

void run_update(const UpdateOptions& options) {
  const Parameters parameters = parameters_of(options.parameters);
  prepare_outputs(options);
  const MapLock lock(options.output, options.patience);
  PosedScans scans(options.run.scans, options.run.poses, parameters.lidar.scan_period, options.run.reading);
  MapMaintainer maintainer(load_map(options.map), parameters);
  const Octree before = maintainer.map();
  spdlog::info("{}: {} leaves", options.map.string(), before.leaf_count());
  PoseCheck check(before, parameters.lidar, scans.poses());
  const Run run = run_over(scans, options.run.threads, maintainer, check_poses(check, options.run));
  const Octree octree = maintainer.map();
  options.undo_log ? save_map_with_undo(options.output, octree) : save_map(options.output, octree);
  const ChangeReport report{options.output, run, LeafCounts(before), LeafCounts(octree),
                            compare(before, octree)};
  if (!options.report.empty()) write_report(options.report, report, before, octree);
  fmt::print("{}", options.as_json ? dump(to_json(report)) : to_text(report));
  end_as(run);
}

}  // namespace

void add_update(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("update", "Bring a map up to date with posed scans");
  const auto options = std::make_shared<UpdateOptions>();
  verb->add_option("MAP.evm", options->map, "Map to start from")->required();
  add_run_options(*verb, options->run);
  verb->add_option("-o,--output", options->output, "Map to write; may be the one to start from")
      ->required()
      ->type_name("OUT.evm");
  add_mode_option(*verb, options->parameters);
  add_range_options(*verb, options->parameters);
  add_config_option(*verb, options->parameters);
  verb->add_option("--report", options->report,
                   "Folder for report.json and pictures of before, after and the change")
      ->type_name("DIR");
  add_undo_log_option(*verb, options->undo_log);
  add_wait_option(*verb, options->patience);
  add_json_option(*verb, options->as_json);
  verb->callback([options] { run_update(*options); });
}

}  // namespace evermap
