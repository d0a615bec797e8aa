// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// Drives the loop through the quarry again and again: does the memory stay as it is, and how long does the
// slowest scan in a hundred take?
#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <unistd.h>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <oneapi/tbb/global_control.h>

#include "cpu_time.hpp"
#include "drive.hpp"
#include "experiments/result_file.hpp"
#include <evermap/maintenance/map_maintainer.hpp>

namespace evermap {
namespace {

struct Options {
  double leaf = 0.1;  ///< [m]
  std::size_t scans = 10000;
  std::size_t every = 6;  ///< scan of the loop is kept in memory and driven
  std::string folder = "endurance";
};

/// [MB] of this process.
double resident() {
  std::ifstream file("/proc/self/statm");
  double pages = 0, resident_pages = 0;
  if (!(file >> pages >> resident_pages)) throw std::runtime_error("/proc/self/statm: cannot be read");
  return 1e-6 * resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE));
}

double quantile(std::vector<double> values, double fraction) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(fraction * static_cast<double>(values.size() - 1) + 0.5)];
}

/// Some scans in a row.
struct Stretch {
  double scans_before;  ///< and of the stretch itself
  double median_ms, p99_ms;
  double resident_mb, map_mb;
};

/// What experiments/report.py plots.
Json figure_of(const std::vector<Stretch>& stretches) {
  const auto points = [&](double Stretch::*value) {
    Json list = Json::array();
    for (const Stretch& stretch : stretches) list.push_back({stretch.scans_before, stretch.*value});
    return list;
  };
  return {
      {{"title", "CPU time of a scan"},
       {"x", "scans"},
       {"y", "[ms]"},
       {"from_zero", true},
       {"series", {{"median", points(&Stretch::median_ms)}, {"99 % are faster", points(&Stretch::p99_ms)}}}},
      {{"title", "Memory"},
       {"x", "scans"},
       {"y", "[MB]"},
       {"from_zero", true},
       {"series",
        {{"resident, without the scans", points(&Stretch::resident_mb)},
         {"the map", points(&Stretch::map_mb)}}}}};
}

void run(const Options& options) {
  constexpr std::size_t kStretches = 50;
  const Drive drive = drive_through_quarry(600 / options.every, options.every);
  MapMaintainer maintainer(Octree(VoxelGrid{.edge = options.leaf}));
  std::filesystem::create_directories(options.folder);
  const double resident_before = resident();
  std::vector<Stretch> stretches;
  std::vector<double> all, recent;  // [ms]
  std::size_t refused = 0;
  fmt::print("{:>8} {:>10} {:>10} {:>14} {:>10}\n", "scans", "median", "99 %", "resident", "map");
  fmt::print("{:>8} {:>10} {:>10} {:>14} {:>10}\n", "", "[ms]", "[ms]", "[MB]", "[MB]");
  for (std::size_t scan = 0; scan < options.scans; ++scan) {
    const std::size_t at = scan % drive.scans.size();
    const double begin = cpu_seconds();
    refused += maintainer.process(drive.scans[at], drive.T_map_sensor[at]).is_written ? 0 : 1;
    recent.push_back(1e3 * (cpu_seconds() - begin));
    if ((scan + 1) % std::max<std::size_t>(1, options.scans / kStretches) != 0) continue;
    stretches.push_back({static_cast<double>(scan + 1), quantile(recent, 0.5), quantile(recent, 0.99),
                         resident() - resident_before,
                         1e-6 * static_cast<double>(maintainer.map().memory_bytes())});
    const Stretch& last = stretches.back();
    fmt::print("{:>8} {:>10.2f} {:>10.2f} {:>14.1f} {:>10.1f}\n", scan + 1, last.median_ms, last.p99_ms,
               last.resident_mb, last.map_mb);
    std::fflush(stdout);
    all.insert(all.end(), recent.begin(), recent.end());
    recent.clear();
  }
  const Stretch& fifth = stretches[stretches.size() / 5];
  fmt::print(
      "\nleaf {} m, {} scans, {} refused: median {:.1f} ms, 99 % within {:.1f} ms, slowest {:.1f} ms of "
      "CPU\n",
      options.leaf, options.scans, refused, quantile(all, 0.5), quantile(all, 0.99), quantile(all, 1));
  fmt::print("resident memory after {:.0f} scans {:.1f} MB, at the end {:.1f} MB: {:+.2f} %\n",
             fifth.scans_before, fifth.resident_mb, stretches.back().resident_mb,
             100 * (stretches.back().resident_mb / fifth.resident_mb - 1));
  write_file(std::filesystem::path(options.folder) / "endurance.json",
             dump({{"figures", {{"endurance", figure_of(stretches)}}}}));
}

}  // namespace
}  // namespace evermap

int main(int argc, char** argv) {
  evermap::Options options;
  CLI::App app("Drives a loop again and again; reports time and memory");
  app.add_option("--leaf", options.leaf, "Leaf edge")
      ->type_name("METRES")
      ->check(CLI::Range(0.05, 2.0))
      ->capture_default_str();
  app.add_option("--scans", options.scans, "Scans in all")
      ->check(CLI::Range(100, 1000000))
      ->capture_default_str();
  app.add_option("--every", options.every, "Scans of the loop that are driven: every n-th")
      ->check(CLI::Range(1, 60))
      ->capture_default_str();
  app.add_option("-o,--output", options.folder, "Folder for the figures to plot")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const oneapi::tbb::global_control one_thread(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  try {
    evermap::run(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_endurance: {}\n", error.what());
    return 1;
  }
}
