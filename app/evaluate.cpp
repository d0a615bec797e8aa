// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <memory>

#include <fmt/core.h>

#include "options.hpp"
#include "posed_scans.hpp"
#include "progress_bar.hpp"
#include "report.hpp"
#include "verbs.hpp"
#include <evermap/evaluation/labelled_drive.hpp>
#include <evermap/evaluation/map_claims.hpp>
#include <evermap/io/labelled_boxes.hpp>
#include <evermap/io/map_file.hpp>

namespace evermap {
namespace {

struct Options {
  std::filesystem::path map;
  std::filesystem::path scans;
  std::filesystem::path poses;
  std::filesystem::path boxes;
  bool as_json = false;
};

DriveScore score_drive(const Octree& octree, PosedScans& scans,
                       const std::vector<std::vector<LabelledBox>>& boxes) {
  DriveScore score;
  ProgressBar bar(scans.size());
  for (std::size_t i = 0; auto posed = scans.next(); ++i) {
    add_to_score(score, posed->scan, posed->T_map_sensor,
                 i < boxes.size() ? boxes[i] : std::vector<LabelledBox>{},
                 i + DriveScore::kLastScans >= scans.size(),
                 [&](const Eigen::Vector3d& p_map) { return claims(octree, p_map, DriveScore::kPoseSigma); });
    bar.show(i + 1);
  }
  return score;
}

void run(const Options& options) {
  const Octree octree = load_map(options.map);
  const auto boxes = read_labelled_boxes(options.boxes);
  PosedScans scans(options.scans, options.poses);
  const DriveScore score = score_drive(octree, scans, boxes);
  if (options.as_json) {
    fmt::print("{}", dump({{"static_kept", score.all_static.value()},
                           {"static_kept_in_labelled_view", score.seen_static.value()},
                           {"parked_kept", score.parked.value()},
                           {"moving_removed", score.removed()},
                           {"associated_accuracy", score.associated_accuracy()}}));
    return;
  }
  fmt::print("static kept      {:.4f}   ({:.4f} in the labelled view)\n", score.all_static.value(),
             score.seen_static.value());
  fmt::print("parked kept      {:.4f}\nmoving removed   {:.4f}\n", score.parked.value(), score.removed());
  fmt::print("sqrt(static kept x moving removed)   {:.4f}\n", score.associated_accuracy());
}

}  // namespace

void add_evaluate(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("evaluate", "Score a map on raw points of labelled scans");
  const auto options = std::make_shared<Options>();
  verb->add_option("MAP.evm", options->map, "Map to score")->required();
  verb->add_option("SCANS", options->scans, "Folder of scans")->required();
  verb->add_option("--poses", options->poses, "Poses of the scans (TUM or KITTI)")->required();
  verb->add_option("--boxes", options->boxes, "Labelled boxes (.csv) with a column 'moving'")->required();
  add_json_option(*verb, options->as_json);
  verb->callback([options] { run(*options); });
}

}  // namespace evermap
