// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <fmt/core.h>

#include "birds_eye.hpp"
#include "experiments/contest_story.hpp"
#include "experiments/scenario_course.hpp"
#include "options.hpp"
#include "progress_bar.hpp"
#include "report.hpp"
#include "verbs.hpp"
#include <evermap/evaluation/evermap_contender.hpp>
#include <evermap/io/atomic_file.hpp>
#include <evermap/io/map_file.hpp>

namespace evermap {
namespace {

constexpr double kShownLeaf = 0.2;  ///< [m] of the maps that are written

struct Options {
  std::filesystem::path folder = "demo";
  bool as_json = false;
};

/// The contest of one leaf size, and evermap's map at its end.
struct Outcome {
  double leaf;  ///< [m]
  Json result;
  std::optional<Octree> after;
};

Outcome run_contest(const Course& course, double leaf) {
  Outcome outcome{leaf, {}, {}};
  const ProgressBar bar(course.scans().size());
  const ContestRules rules{.leaf = leaf,
                           .measurements = 6,
                           .has_picture = true,
                           .at_end = [&](const Contender& contender, const Points&, const Truth&) {
                             if (contender.name() == kEvermap) outcome.after = *contender.gaussian_map();
                             return Json::object();
                           }};
  outcome.result = hold_contest(course, usual_contenders(leaf, course.lidar), rules,
                                [&](std::size_t done, std::size_t) { bar.show(done); });
  return outcome;
}

const std::vector<std::string>& measures() {
  static const std::vector<std::string> list{"SA", "DA", "COV 0.1", "COV 0.2", "ACC 0.1", "ACC 0.2", "AHD"};
  return list;
}

HtmlTable comparison(const std::vector<Outcome>& outcomes) {
  using Best = HtmlTable::Best;
  HtmlTable table{
      "SA: unchanged surface kept. DA: removed surface erased. COV, ACC: share of the true surface near the "
      "map, of "
      "the map near the true surface [m]. AHD: distance between the two [m].",
      {{"leaf", Best::kNone, 1}, {"map", Best::kNone, 0}},
      {}};
  for (const std::string& measure : measures()) table.columns.push_back({measure, Best::kNone, 4});
  for (const Outcome& outcome : outcomes) {
    for (const std::string& name : contenders_of(outcome.result)) {
      table.rows.push_back({outcome.leaf, name});
      for (const std::string& measure : measures()) {
        table.rows.back().emplace_back(at_end(outcome.result, name, measure));
      }
    }
  }
  return table;
}

Json to_json(const std::vector<Outcome>& outcomes) {
  Json rows = Json::array();
  for (const Outcome& outcome : outcomes) {
    for (const std::string& name : contenders_of(outcome.result)) {
      Json row{{"leaf", outcome.leaf}, {"map", name}};
      for (const std::string& measure : measures()) row[measure] = at_end(outcome.result, name, measure);
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

Story tell(const std::vector<Outcome>& outcomes, const std::filesystem::path& folder) {
  Story story{"A yard that changed"};
  story.blocks.emplace_back(Paragraph{
      "Since the survey one box vanished, one appeared, one moved by 0.25 m, and a heap grew. A robot drives "
      "through for 6 s. What each map became:"});
  story.blocks.emplace_back(comparison(outcomes));
  story.blocks.emplace_back(Figure{"change.png", "What evermap changed in its map."});
  story.blocks.emplace_back(Figure{"before.png", "The map before, by height."});
  story.blocks.emplace_back(Figure{"after.png", "The map after, by height."});
  for (const Outcome& outcome : outcomes) {
    tell_contest(story, folder, fmt::format("yard_{}", outcome.leaf),
                 fmt::format("yard, leaf {} m", outcome.leaf), outcome.result,
                 {.curves = {{"COV 0.2", "COV within 0.2 m"}, {"AHD", "AHD", true}},
                  .figure = "How much of the true surface the map covers, and how far the two are apart",
                  .view = "The yard from above at the end"});
  }
  return story;
}

void run(const Options& options) {
  make_folder(options.folder);
  check_writable(options.folder / "after.evm");
  const ScenarioCourse course({.scenario = "yard", .survey_spacing = 0.05, .truth_spacing = 0.09}, 1);
  std::vector<Outcome> outcomes;
  for (const double leaf : {kShownLeaf, 0.4}) outcomes.push_back(run_contest(course, leaf));

  EvermapContender before("before", kShownLeaf, Parameters{});
  before.start(course.survey());
  const Octree& after = outcomes.front().after.value();
  save_map(options.folder / "before.evm", *before.gaussian_map());
  save_map(options.folder / "after.evm", after);
  write_pictures(options.folder, *before.gaussian_map(), after, compare(*before.gaussian_map(), after));
  const Story story = tell(outcomes, options.folder);
  HtmlReport page("evermap: a demonstration");
  add_to(page, story, options.folder);
  page.save(options.folder / "index.html");

  if (options.as_json) {
    fmt::print("{}", dump(to_json(outcomes)));
    return;
  }
  fmt::print("{}\nMaps and pictures ({} m), and index.html, are in {}/\n",
             text_of({"A yard that changed", {comparison(outcomes)}}), kShownLeaf, options.folder.string());
}

}  // namespace

void add_demo(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("demo", "Simulate a yard that changed, and maintain its map");
  const auto options = std::make_shared<Options>();
  verb->add_option("-o,--output", options->folder, "Folder for maps and pictures")
      ->type_name("DIR")
      ->capture_default_str();
  add_json_option(*verb, options->as_json);
  verb->callback([options] { run(*options); });
}

}  // namespace evermap
