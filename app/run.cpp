// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "run.hpp"

#include <chrono>
#include <csignal>

#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/task_arena.h>
#include <spdlog/spdlog.h>

#include "experiments/machine.hpp"
#include "progress_bar.hpp"
#include <evermap/io/io_error.hpp>

namespace evermap {
namespace {

// A signal handler can reach nothing but a global.
volatile std::sig_atomic_t g_stop_requested = 0;
void request_stop(int) { g_stop_requested = 1; }

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

PointCounts::PointCounts(const Scan& scan, const ScanSummary& summary)
    : total(summary.points + scan.dropped_not_finite + scan.dropped_at_origin),
      used(summary.points - summary.dropped_near - summary.dropped_far - summary.dropped_out_of_grid),
      not_finite(scan.dropped_not_finite),
      at_origin(scan.dropped_at_origin),
      near(summary.dropped_near),
      far(summary.dropped_far),
      out_of_grid(summary.dropped_out_of_grid) {}

PointCounts& PointCounts::operator+=(const PointCounts& other) {
  for (const auto count :
       {&PointCounts::total, &PointCounts::used, &PointCounts::not_finite, &PointCounts::at_origin,
        &PointCounts::near, &PointCounts::far, &PointCounts::out_of_grid}) {
    this->*count += other.*count;
  }
  return *this;
}

void check_any_used(const PointCounts& points, const std::filesystem::path& file) {
  if (points.used > 0) return;
  throw IoError(
      file,
      fmt::format("no usable point among {}: {} not finite, {} at the origin, {} nearer than min range, "
                  "{} farther than max range, {} beyond the grid; leave the scan and its pose out",
                  points.total, points.not_finite, points.at_origin, points.near, points.far,
                  points.out_of_grid));
}

Run run_over(std::size_t scans, int threads, const std::function<void(const TakeScan& take)>& next) {
  std::signal(SIGINT, request_stop);
  std::signal(SIGTERM, request_stop);
  const int count = threads > 0 ? threads : oneapi::tbb::info::default_concurrency();
  // Without the first, TBB would never start more workers than there are cores.
  const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism,
                                          static_cast<std::size_t>(count));
  oneapi::tbb::task_arena arena(count);
  Run run;
  run.scans_total = scans;
  const ProgressBar bar(scans);
  const TakeScan take = [&run](const Scan& scan, const Work& work) {
    const double wall = wall_seconds();
    const double cpu = cpu_seconds();
    const PointCounts points(scan, work());
    run.wall.push_back(wall_seconds() - wall);
    run.cpu.push_back(cpu_seconds() - cpu);
    run.points += points;
    return points;
  };
  arena.execute([&] {
    while (run.scans_done < scans && !g_stop_requested) {
      next(take);
      bar.show(++run.scans_done);
    }
  });
  return run;
}

Run run_over(PosedScans& scans, int threads, const UpdateMap& update) {
  return run_over(scans.size(), threads, [&](const TakeScan& take) {
    const PosedScan posed = scans.next().value();
    const PointCounts points = take(posed.scan, [&] { return update(posed.scan, posed.T_map_sensor); });
    check_any_used(points, posed.file);
    spdlog::debug("{}: {} points used", posed.file.string(), points.used);
  });
}

}  // namespace evermap
