// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "run.hpp"

#include <chrono>
#include <csignal>
#include <stdexcept>

#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/task_arena.h>
#include <spdlog/spdlog.h>

#include "command_line.hpp"
#include "cpu_time.hpp"
#include "progress_bar.hpp"
#include <evermap/files/file_error.hpp>

namespace evermap {
namespace {

// A signal handler can reach nothing but a global.
volatile std::sig_atomic_t g_stop_requested = 0;
constexpr int kStopSignals[] = {SIGINT, SIGTERM, SIGHUP};
void request_stop(int signal) { g_stop_requested = signal; }

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

std::string dropped_in_words(const ScanResult::PointCounts& points) {
  return fmt::format(
      "{} not finite, {} at the origin, {} nearer than min range, {} on the vehicle, "
      "{} farther than max range, {} beyond the grid",
      points.not_finite, points.at_origin, points.near, points.on_vehicle, points.far, points.out_of_grid);
}

void check_any_used(const ScanResult::PointCounts& points, const std::filesystem::path& file) {
  if (points.used > 0) return;
  throw FileError(file, fmt::format("no usable point among {}: {}; check the ranges and the scans",
                                    points.total, dropped_in_words(points)));
}

std::string point_time_in_words(const CloudNotes& notes) { return notes.time ? notes.time->describe() : ""; }

void catch_stop_signals() {
  for (const int signal : kStopSignals) std::signal(signal, request_stop);
}

void forget_stop_signals() {
  for (const int signal : kStopSignals) std::signal(signal, SIG_DFL);
}

int stop_signal() { return g_stop_requested; }

int thread_count(int threads) { return threads > 0 ? threads : oneapi::tbb::info::default_concurrency(); }

void end_as(const Run& run) {
  if (run.stopped_by != 0) throw Interrupted(run.stopped_by);
  if (!run.failure.empty()) throw std::runtime_error(run.failure);
}

Run run_over(std::size_t scans, int threads, const std::function<bool(const TakeScan& take)>& next) {
  catch_stop_signals();
  const int count = thread_count(threads);
  // Without the first, TBB would never start more workers than there are cores.
  const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism,
                                          static_cast<std::size_t>(count));
  oneapi::tbb::task_arena arena(count);
  Run run;
  run.scans_total = scans;
  const ProgressBar bar(scans);
  const TakeScan take = [&run](const Work& work) {
    const double wall = wall_seconds();
    const double cpu = cpu_seconds();
    ScanResult result = work();
    run.wall.push_back(wall_seconds() - wall);
    run.cpu.push_back(cpu_seconds() - cpu);
    run.points += result.points;
    run.scans_empty += result.reject_reason == RejectReason::kNoUsablePoint ? 1 : 0;
    return result;
  };
  arena.execute([&] {
    while (stop_signal() == 0 && next(take)) bar.show(std::min(++run.scans_done, scans));
  });
  if (run.scans_done < scans) run.stopped_by = stop_signal();
  return run;
}

Run run_over(PosedScans& scans, int threads, MapMaintainer& maintainer, const LookAtScan& look) {
  std::string last;
  std::string point_time;
  Run run = run_over(scans.size(), threads, [&](const TakeScan& take) {
    const std::optional<PosedScan> posed = scans.next();
    if (!posed) return false;
    last = posed->place;
    if (point_time.empty()) point_time = point_time_in_words(scans.notes());
    const ScanResult result =
        take([&] { return maintainer.process(posed->scan, posed->T_map_sensor, posed->T_map_sensor_begin); });
    if (result.reject_reason == RejectReason::kNone) {
      spdlog::debug("{}: {} points used, {:.1f} % of the rays contradict the map", last, result.points.used,
                    100 * result.contradicting_fraction.value_or(0));
    } else {
      spdlog::warn("{}: skipped, it {}", last, to_string(result.reject_reason));
    }
    if (look) look(*posed, result);
    return true;
  });
  for (const std::string& remark : scans.remarks()) spdlog::warn(remark);
  run.point_time = point_time;
  run.failure = scans.failure();
  if (run.stopped_by == 0) check_any_used(run.points, last);
  return run;
}

LookAtScan check_poses(PoseCheck& check, const RunOptions& options) {
  return [&](const PosedScan& posed, const ScanResult& result) {
    check.note(posed.index, posed.T_map_sensor);
    if (options.is_forced || !result.is_written || !check.wants(posed.index)) return;
    check.add(posed.index, posed.scan, result.contradicting_fraction.value_or(0));
    const std::string verdict = check.verdict();
    if (!verdict.empty()) throw FileError(options.poses, verdict + "; --force goes on all the same");
  };
}

}  // namespace evermap
