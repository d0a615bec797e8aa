// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include "options.hpp"
#include "report.hpp"
#include "verbs.hpp"
#include <evermap/files/file_error.hpp>
#include <evermap/history/map_store.hpp>
#include <evermap/io/cloud.hpp>
#include <evermap/io/detail/scan_folder.hpp>
#include <evermap/maintenance/survey.hpp>

namespace evermap {
namespace {

struct ImportOptions {
  std::filesystem::path cloud;
  CloudOptions reading;
  std::filesystem::path map;
  double leaf = 0;  ///< [m]
  MapFrame frame;
  double patience = 0;  ///< [s]
  ParameterOptions parameters;
  bool as_json = false;
};

/// A point in the middle of the cloud, which a few stray points do not move. REQUIRES: the scan has points.
Eigen::Vector3d median(const Scan& cloud, const Pose& T_map_cloud) {
  Eigen::Vector3d result;
  std::vector<double> values(cloud.p_sensor.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(cloud.p_sensor.begin(), cloud.p_sensor.end(), values.begin(),
                   [&](const Eigen::Vector3d& p) { return (T_map_cloud * p)[axis]; });
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    result[axis] = *middle;
  }
  return result;
}

/// A cloud, or the clouds of a folder together (tiles), in the map frame where a file says where it was
/// taken.
Scan read_survey(const ImportOptions& options, CloudNotes& notes) {
  if (!std::filesystem::is_directory(options.cloud))
    return read_cloud(options.cloud, options.reading, &notes);
  ScanFolder clouds(options.cloud, options.reading);
  Scan survey;
  while (const std::optional<Scan> cloud = clouds.next()) {
    const Pose T_map_cloud = cloud->T_map_sensor.value_or(Pose{});
    for (const Eigen::Vector3d& p : cloud->p_sensor) survey.p_sensor.push_back(T_map_cloud * p);
    notes.has_viewpoint = notes.has_viewpoint || clouds.notes().has_viewpoint;
    notes.coordinate_step = std::max(notes.coordinate_step, clouds.notes().coordinate_step);
    notes.voxel = std::max(notes.voxel, clouds.notes().voxel);
  }
  return survey;
}

void run_import(const ImportOptions& options) {
  check_leaf(options.leaf);
  const Parameters parameters = parameters_of(options.parameters);
  check_writable(options.map);
  MapStore store(options.map, options.patience);
  CloudNotes notes;
  const Scan cloud = read_survey(options, notes);
  if (notes.coordinate_step > 0 && !cloud.p_sensor.empty()) {  // a few stray points do not count
    const auto usual = static_cast<float>(median(cloud, Pose{}).cwiseAbs().maxCoeff());
    notes.farthest_coordinate = static_cast<double>(usual);
    notes.coordinate_step = static_cast<double>(std::nextafter(usual, INFINITY) - usual);
  }
  check_coordinate_step(options.cloud, notes, options.leaf);
  if (notes.has_viewpoint && !options.reading.ignore_viewpoint) {
    spdlog::warn("{}: its VIEWPOINT moves the cloud; --ignore-viewpoint leaves it where its points are",
                 options.cloud.string());
  }
  constexpr double kFewestVoxels = 2;  // along a leaf, for a plane through their middles
  if (notes.voxel > 0 && options.leaf < kFewestVoxels * notes.voxel) {
    spdlog::warn("{}: voxels of {} m tell the surface to half of that; leaves of {} m (-r) lie on it better",
                 options.cloud.string(), notes.voxel, kFewestVoxels * notes.voxel);
  }
  const Pose T_map_cloud = cloud.T_map_sensor.value_or(Pose{});
  const Eigen::Vector3d center =
      cloud.p_sensor.empty() ? Eigen::Vector3d::Zero() : median(cloud, T_map_cloud);
  Octree octree(VoxelGrid::around(center, options.leaf), options.frame);
  const ScanResult::PointCounts points = add_survey(octree, cloud, T_map_cloud, parameters);
  check_any_used(points, options.cloud);
  store.create(octree, {"import of " + options.cloud.string(), ""});
  if (options.as_json) {
    fmt::print(
        "{}",
        dump({{"map", options.map.string()}, {"leaves", octree.leaf_count()}, {"points", to_json(points)}}));
  } else {
    fmt::print("map      {}\nleaves   {}\n{}", options.map.string(), octree.leaf_count(), to_text(points));
  }
}

}  // namespace

void add_import(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("import", "Make a map from a point cloud, all of which is trusted");
  const auto options = std::make_shared<ImportOptions>();
  verb->add_option("CLOUD", options->cloud,
                   "Cloud in the map frame, or folder of its tiles: " + std::string(kCloudExtensions))
      ->required();
  verb->add_option("-o,--output", options->map, "Map to write")->required()->type_name("MAP.evm");
  add_cloud_options(*verb, options->reading);
  add_frame_options(*verb, options->frame);
  verb->add_flag("--ignore-viewpoint", options->reading.ignore_viewpoint,
                 "Take the points of a PCD file as they are, whatever its VIEWPOINT says");
  add_leaf_option(*verb, options->leaf);
  add_config_option(*verb, options->parameters);
  add_wait_option(*verb, options->patience);
  add_json_option(*verb, options->as_json);
  verb->callback([options] { run_import(*options); });
}

}  // namespace evermap
