// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <memory>

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include "birds_eye.hpp"
#include "options.hpp"
#include "report.hpp"
#include "verbs.hpp"
#include <evermap/history/map_store.hpp>
#include <evermap/io/detail/atomic_file.hpp>

namespace evermap {
namespace {

struct UpdateOptions {
  std::filesystem::path map;
  RunOptions run;
  std::filesystem::path output;
  ParameterOptions parameters;
  std::filesystem::path report;  ///< folder; empty when not asked for
  JournalParameters journal{.scans = 0};
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
  write_json(folder / "report.json", to_json(report));
  // Whoever interrupts waits for the end: of a large map, pictures take longer than saving it.
  if (report.run.stopped_by == 0) write_pictures(folder, before, after, report.change.difference);
}

void run_update(const UpdateOptions& options) {
  const Parameters parameters = parameters_of(options.parameters);
  prepare_outputs(options);
  MapStore store(options.output, options.patience);
  PosedScans scans(options.run.scans, options.run.poses, parameters.lidar.scan_period, options.run.reading);
  MapMaintainer maintainer(load_start(options.map, store), parameters);
  const Octree before = maintainer.map();
  spdlog::info("{}: {} leaves", options.map.string(), before.leaf_count());
  PoseCheck check(before, parameters.lidar, scans.poses());
  MapCause cause = cause_of("update", options.run.scans, parameters);
  store.begin(before, cause, options.journal);
  const LookAtScan look_at_poses = check_poses(check, options.run);
  const Run run =
      run_over(scans, options.run.threads, maintainer, [&](const PosedScan& posed, const ScanResult& result) {
        look_at_poses(posed, result);
        store.acknowledge([&] { return maintainer.map(); }, posed.index + 1);
      });
  const Octree octree = maintainer.map();
  cause.what += fmt::format(", {} scans", run.scans_done);
  put_in_place(store, octree, cause);
  const ChangeReport report{{options.output, before, octree}, run};
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
  add_report_option(*verb, options->report);
  add_sync_option(*verb, options->journal);
  add_wait_option(*verb, options->patience);
  add_json_option(*verb, options->as_json);
  verb->callback([options] { run_update(*options); });
}

}  // namespace evermap
