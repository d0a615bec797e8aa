// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// How long a scan takes in evermap and in other maps: the same scans of the same quarry, one thread, CPU
// time, in turns.
#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "drive.hpp"
#include "experiments/machine.hpp"
#include "experiments/race.hpp"
#include <evermap/evaluation/contender.hpp>

namespace evermap {
namespace {

struct Options {
  std::vector<double> leaves{1.0, 0.8, 0.6, 0.4, 0.2, 0.1};  ///< [m]
  std::vector<std::string> against{"OctoMap", "OctoMap, voxel means"};
  std::size_t scans = 0;  ///< 0: as many as `default_scans`
  std::string json;
};

struct Times {
  double median;     ///< [ms] a scan
  double low, high;  ///< [ms] 10 % and 90 % of the scans are faster
};

struct Result {
  std::string name;
  Times times;
  std::size_t memory_bytes;
};

constexpr std::size_t kMostScans = 60;
/// OctoMap needs seconds a scan when leaves are small.
std::size_t default_scans(double leaf) { return leaf < 0.15 ? 15 : leaf < 0.3 ? 30 : kMostScans; }

Times summarize(std::vector<double> seconds) {
  std::sort(seconds.begin(), seconds.end());
  const auto at = [&](double share) {
    return 1e3 * seconds[static_cast<std::size_t>(share * static_cast<double>(seconds.size() - 1) + 0.5)];
  };
  return {at(0.5), at(0.1), at(0.9)};
}

using Contenders = std::vector<std::unique_ptr<Contender>>;

/// All begin with an empty map.
Contenders contenders(const std::vector<std::string>& against, double leaf) {
  Contenders all;
  std::vector<std::string> names{"evermap default", "evermap paper"};
  names.insert(names.end(), against.begin(), against.end());
  for (const std::string& name : names) {
    all.push_back(make_contender(name, leaf));
    if (!all.back()) throw std::runtime_error(name + " was not found when evermap was built");
  }
  return all;
}

std::vector<Result> compete(const Contenders& contenders, const Drive& drive, std::size_t scans) {
  const auto seconds = race(contenders, scans, [&](std::size_t scan) {
    return AlignedScan{drive.scans[scan], drive.T_map_sensor[scan]};
  });
  std::vector<Result> results;
  for (std::size_t c = 0; c < contenders.size(); ++c) {
    results.push_back({contenders[c]->name(), summarize(seconds[c]), contenders[c]->memory_bytes()});
  }
  return results;
}

nlohmann::ordered_json describe() {
  return {{"cpu", processor()},
          {"compiler", compiler()},
          {"flags", EVERMAP_FLAGS},
          {"evermap", EVERMAP_VERSION},
          {"octomap", make_contender("OctoMap", 1)->version()},
          {"threads", 1},
          {"clock", "CPU time of the process"},
          {"data", "scenario quarry, 64 x 1024 beams, some 42,000 returns a scan, 200 m range"}};
}

void print(double leaf, std::size_t scans, const std::vector<Result>& results) {
  const double reference = results[2].times.median;
  for (const Result& r : results) {
    fmt::print("{:4.1f} {:6} {:20} {:9.2f} {:9.2f} {:9.2f} {:10.1f} {:10.1f}\n", leaf, scans, r.name,
               r.times.median, r.times.low, r.times.high, reference / r.times.median,
               static_cast<double>(r.memory_bytes) / 1e6);
  }
  std::fflush(stdout);  // the next leaf size may take minutes
}

nlohmann::ordered_json to_json(double leaf, std::size_t scans, const std::vector<Result>& results) {
  nlohmann::ordered_json json = {{"leaf_m", leaf}, {"scans", scans}, {"contenders", {}}};
  for (const Result& r : results) {
    json["contenders"].push_back({{"name", r.name},
                                  {"median_ms", r.times.median},
                                  {"p10_ms", r.times.low},
                                  {"p90_ms", r.times.high},
                                  {"ratio", results[2].times.median / r.times.median},
                                  {"memory_bytes", r.memory_bytes}});
  }
  return json;
}

void run_all(const Options& options) {
  nlohmann::ordered_json report = describe();
  for (const auto& [key, value] : report.items()) fmt::print("{:9} {}\n", key, value.dump());
  fmt::print("\n{:>4} {:>6} {:20} {:>9} {:>9} {:>9} {:>10} {:>10}\n", "leaf", "scans", "", "median", "10 %",
             "90 %", "ratio", "map");
  fmt::print("{:>4} {:>6} {:20} {:>9} {:>9} {:>9} {:>10} {:>10}\n", "[m]", "", "", "[ms]", "[ms]", "[ms]", "",
             "[MB]");
  const Drive drive = drive_through_quarry(std::max(options.scans, kMostScans));
  for (const double leaf : options.leaves) {
    const std::size_t scans = options.scans > 0 ? options.scans : default_scans(leaf);
    const std::vector<Result> results = compete(contenders(options.against, leaf), drive, scans);
    print(leaf, scans, results);
    report["leaves"].push_back(to_json(leaf, scans, results));
  }
  if (options.json.empty()) return;
  std::ofstream file(options.json);
  file << report.dump(2) << '\n';
  if (!file.flush()) throw std::runtime_error(options.json + ": cannot be written");
}

}  // namespace
}  // namespace evermap

int main(int argc, char** argv) {
  evermap::Options options;
  CLI::App app("Times evermap and other maps on the same scans, one thread, CPU time");
  app.add_option("--leaf", options.leaves, "Leaf edges")->type_name("METRES")->check(CLI::Range(0.05, 2.0));
  app.add_option("--against", options.against, "Contenders; the first is what ratios are taken to")
      ->check(CLI::IsMember(evermap::contender_names()))
      ->capture_default_str();
  app.add_option("--scans", options.scans, "Scans of the drive; the first third is not counted")
      ->check(CLI::Range(3, 1000));
  app.add_option("--json", options.json, "Also write the figures to this file");
  CLI11_PARSE(app, argc, argv);

  try {
    evermap::run_all(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_versus: {}\n", error.what());
    return 1;
  }
}
