// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "experiments/contest_story.hpp"
#include "experiments/experiment.hpp"
#include "experiments/scenario_course.hpp"

namespace evermap {
namespace {

struct Variant {
  std::uint64_t seed;
  double translation;  ///< [m] of the poses' noise
  double degrees;      ///< of the same
  bool is_registered;  ///< the poses only start the search for those that fit the map

  std::string name() const {
    if (translation == 0) return fmt::format("seed {}", seed);
    return fmt::format("poses off by {:.0f} cm and {} degrees{}", 100 * translation, degrees,
                       is_registered ? ", registered" : "");
  }
};

std::vector<Variant> variants_of(const Setup& setup) {
  const std::size_t seeds = setup.is_quick ? 0 : static_cast<std::size_t>(setup.seeds);
  std::vector<Variant> variants(seeds);
  for (std::size_t i = 0; i < seeds; ++i) variants[i] = {setup.seed + i, 0, 0, false};
  if (!setup.is_quick) variants.push_back({setup.seed, 0.01, 0.1, false});
  variants.push_back({setup.seed, 0.03, 0.3, false});
  if (!setup.is_quick) variants.push_back({setup.seed, 0.01, 0.1, true});
  if (!setup.is_quick) variants.push_back({setup.seed, 0.03, 0.3, true});
  return variants;
}

Unit unit_of(const Setup& setup, double leaf, const Variant& variant, std::size_t index) {
  const ScenarioChoice choice{.scenario = "quarry",
                              .every = 3,
                              .scans = setup.is_quick ? 12 : 150,
                              .truth_spacing = setup.is_quick ? 0.47 : 0.23,
                              .area = {Eigen::Vector2d(-80, -70), Eigen::Vector2d(80, 60)}};
  const auto compute = [=](const Progress& progress) {
    const ScenarioCourse course(choice, variant.seed);
    const PoseNoise noise{variant.translation, variant.degrees * std::numbers::pi / 180, variant.seed};
    return hold_contest(course, contenders_named({kOctoMap, kEvermap}, leaf, course.lidar),
                        {.leaf = leaf, .noise = noise, .finds_poses = variant.is_registered}, progress);
  };
  return {fmt::format("robustness_{}", index + 1),
          {{"leaf", leaf},
           {"seed", variant.seed},
           {"translation", variant.translation},
           {"degrees", variant.degrees},
           {"registered", variant.is_registered},
           {"scans", *choice.scans}},
          compute};
}

}  // namespace

Experiment experiment_robustness(const Setup& setup) {
  const double leaf = setup.leaves.empty() ? 0.4 : setup.leaves.front();
  const std::vector<Variant> variants = variants_of(setup);
  Experiment experiment{"robustness", {}, {}, {}};
  for (std::size_t i = 0; i < variants.size(); ++i)
    experiment.units.push_back(unit_of(setup, leaf, variants[i], i));
  experiment.tell = [=](const std::vector<Json>& results, const std::filesystem::path&) {
    using Best = HtmlTable::Best;
    Story story{"Robust, not tuned"};
    story.blocks.emplace_back(
        Paragraph{"The same default parameters everywhere. Here a short run through the pit is repeated with "
                  "other noise of the sensor, "
                  "and with poses that are off: normal noise, each scan and each axis by itself, of that "
                  "standard deviation. Registered: the noisy poses are taken for odometry only, and each map "
                  "is given its scans where they fit it, as `evermap localize --maintain --odometry` does."});
    HtmlTable table{fmt::format("The pit, leaf {} m, {} scans", leaf, results[0]["scans"].get<int>()),
                    {{"what differs", Best::kNone, 0},
                     {"map", Best::kNone, 0},
                     {"SA", Best::kNone, 4},
                     {"DA", Best::kNone, 4},
                     {"AA", Best::kNone, 4},
                     {"COV 0.2", Best::kNone, 4},
                     {"ACC 0.2", Best::kNone, 4},
                     {"AHD [m]", Best::kNone, 3}},
                    {}};
    for (std::size_t i = 0; i < results.size(); ++i) {
      for (const std::string& name : contenders_of(results[i])) {
        std::vector<HtmlTable::Cell> row{variants[i].name(), name};
        for (const char* measure : {"SA", "DA", "AA", "COV 0.2", "ACC 0.2", "AHD"})
          row.emplace_back(at_end(results[i], name, measure));
        table.rows.push_back(std::move(row));
      }
    }
    story.blocks.emplace_back(std::move(table));
    return story;
  };
  return experiment;
}

}  // namespace evermap
