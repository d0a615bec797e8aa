// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/page.hpp"

#include <fmt/format.h>

#include "experiments/machine.hpp"

namespace evermap {

namespace {

using Best = HtmlTable::Best;

HtmlTable glance_table(const std::vector<Story>& stories) {
  HtmlTable table{
      "SA: share of the unchanged surface that the map kept. DA: share of the removed surface that it "
      "erased. AHD: how far "
      "map and truth are apart, the larger of the two mean distances. At the end of each run.",
      {{"data", Best::kNone, 0},
       {"SA, OctoMap", Best::kNone, 3},
       {"SA, evermap", Best::kNone, 3},
       {"DA, OctoMap", Best::kNone, 3},
       {"DA, evermap", Best::kNone, 3},
       {"AHD [m], OctoMap", Best::kNone, 3},
       {"AHD [m], evermap", Best::kNone, 3}},
      {}};
  for (const Story& story : stories) {
    for (const Glance& g : story.glances) {
      table.rows.push_back({g.where, g.octomap_kept, g.evermap_kept, g.octomap_erased, g.evermap_erased,
                            g.octomap_apart, g.evermap_apart});
    }
  }
  return table;
}

HtmlTable aim_table(const std::vector<Story>& stories) {
  HtmlTable table{"What evermap's default is meant to reach, and what it reached here",
                  {{"data", Best::kNone, 0},
                   {"aim", Best::kNone, 0},
                   {"reached", Best::kNone, 0},
                   {"met", Best::kNone, 0}},
                  {}};
  for (const Story& story : stories) {
    for (const Aim& aim : story.aims)
      table.rows.push_back({aim.where, aim.what, aim.reached, aim.is_met ? "yes" : "NO"});
  }
  return table;
}

Story overview(const std::vector<Story>& stories) {
  Story story{"At a glance"};
  story.blocks.emplace_back(
      Paragraph{"A robot has a map from a survey. The world changes, and each contender updates the same map "
                "with the same scans. "
                "OctoMap, the usual grid mapper, takes each ray as proof that all it crosses is free. Rays "
                "that graze the ground erase "
                "it: look for orange in the pictures. A map that nobody updates keeps what is gone: look for "
                "blue. evermap asks of "
                "each ray whether it truly contradicts the surface in a leaf."});
  const HtmlTable glances = glance_table(stories);
  const HtmlTable aims = aim_table(stories);
  if (!glances.rows.empty()) story.blocks.emplace_back(glances);
  if (!aims.rows.empty()) story.blocks.emplace_back(aims);
  return story;
}

Story choices(const Setup& setup) {
  Story story{"How it was measured"};
  for (const char* text :
       {"Simulated truth is exact: the surface at the moment of the measurement, without "
        "what moves, sampled each 0.17 m "
        "(0.23 m in the pit); distances from the map to it are exact. A surface counts as "
        "observed where some ray of "
        "the run ended in its voxel of 0.2 m. COV and the distance from truth to map are "
        "taken over the observed "
        "truth; ACC and the distance from map to truth over all points of the map in the "
        "measured area (of more than "
        "250,000, each so many one), which are right where any true surface is. "
        "Uncropped: over the whole truth.",
        "SA and DA are taken on points that at least 4 rays crossed and left more than "
        "1.5 leaves behind. A point is "
        "kept when its leaf is occupied and it lies in the leaf's 99 % ellipsoid, widened "
        "by how well the point is "
        "known (2 cm simulated, 5 cm real); for a grid, when its voxel is occupied. One "
        "point per leaf stands for the "
        "map: the Gaussian's mean, or the voxel's centre.",
        "Every contender has its default parameters in all experiments. Real truth: what "
        "the drive's scans show of "
        "what does not move, each 0.05 m; COV, SA and DA on voxels of 0.1 m that at least 3 scans "
        "hit and that no more scans saw through than hit. The pit is driven with "
        "every second scan, at leaves below 0.3 m with every third of 21 s: "
        "OctoMap takes seconds for each."}) {
    story.blocks.emplace_back(Paragraph{text});
  }
  if (setup.is_quick)
    story.blocks.emplace_back(
        Paragraph{"This was a quick run: few scans, one leaf size. The figures of a full run differ."});
  return story;
}

}  // namespace

void write_page(const Laboratory& laboratory, const Setup& setup, const std::vector<Story>& stories) {
  HtmlReport page("evermap: maps that stay true");
  std::vector<Story> all{overview(stories)};
  all.insert(all.end(), stories.begin(), stories.end());
  all.push_back(choices(setup));
  std::string markdown;
  for (const Story& story : all) {
    add_to(page, story, laboratory.folder());
    markdown += markdown_of(story);
  }
  page.heading("Machine and versions");
  page.facts(machine_facts());
  page.code(fmt::format("evermap experiment all -o DIR --data DATA{} --seed {}",
                        setup.is_quick ? " --quick" : "", setup.seed));
  page.save(laboratory.folder() / "index.html");
  laboratory.write("experiments.md", markdown);
}

Json to_json(const Experiment& experiment, const std::vector<Json>& results) {
  Json all = Json::object();
  for (std::size_t i = 0; i < results.size(); ++i) {
    Json result = results[i];
    if (result.contains("contenders")) {
      for (Json& contender : result["contenders"]) {
        if (contender.is_object()) contender.erase("picture");
      }
    }
    all[experiment.units[i].name] = {{"settings", experiment.units[i].settings},
                                     {"result", std::move(result)}};
  }
  return all;
}

}  // namespace evermap
