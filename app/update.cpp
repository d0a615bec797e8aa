// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <memory>

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include "journaled_run.hpp"
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
  JournalParameters journal;
  double patience = 0;  ///< [s]
  bool resume = false;
  bool as_json = false;
};

void prepare_outputs(const UpdateOptions& options) {
  check_writable(options.output);
  if (!options.report.empty()) prepare_report(options.report);
}

void run_update(const UpdateOptions& options) {
  const Parameters parameters = parameters_of(options.parameters);
  prepare_outputs(options);
  MapStore store(options.output, options.patience);
  MapCause cause = cause_of("update", options.run.scans, parameters);
  ScanOptions reading = options.run.reading;
  if (options.resume) reading.selection.skip = scans_before(options.output, cause);
  PosedScans scans(options.run.scans, options.run.poses, parameters.lidar.scan_period, reading);
  MapMaintainer maintainer(load_start(options.resume ? options.output : options.map, store), parameters);
  const Octree before = maintainer.map();
  spdlog::info("{}: {} leaves", options.map.string(), before.leaf_count());
  PoseCheck check(before, parameters.lidar, scans.poses());
  const Run run = run_journaled(scans, options.run, maintainer, check, store, options.journal, cause,
                                reading.selection.skip);
  const Octree octree = maintainer.map();
  if (run.stopped_by != 0 && leave_if_large(store, octree, options.journal, cause.scans)) end_as(run);
  put_in_place(store, octree, cause);
  const ChangeReport report{{options.output, before, octree}, run};
  if (!options.report.empty()) {
    // Whoever interrupts waits for the end: of a large map, pictures take longer than saving it.
    if (run.stopped_by != 0) {
      write_json(options.report / kReportName, to_json(report));
    } else {
      write_report(options.report, to_json(report), report.change, before, octree);
    }
  }
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
  verb->add_flag("--resume", options->resume,
                 "Go on with an update that was stopped or killed, after the last scan that OUT.evm has");
  add_mode_option(*verb, options->parameters);
  add_range_options(*verb, options->parameters);
  add_config_option(*verb, options->parameters);
  add_report_option(*verb, options->report);
  add_sync_option(*verb, options->journal);
  CLI::Option* sync = verb->get_option("--sync")->default_str("10, or 0 for a map that is new");
  add_wait_option(*verb, options->patience);
  add_json_option(*verb, options->as_json);
  verb->callback([options, sync] {
    std::error_code error;
    // A journal tells what changed since the map that is in place.
    const bool is_new = !std::filesystem::exists(options->output, error);
    if (sync->count() == 0 && is_new) options->journal.scans = 0;
    run_update(*options);
  });
}

}  // namespace evermap
