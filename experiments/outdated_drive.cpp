// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/outdated_drive.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <unordered_map>
#include <utility>

#include "experiments/ground_map.hpp"
#include "posed_scans.hpp"
#include <evermap/evaluation/labelled_drive.hpp>
#include <evermap/geometry/voxel_key.hpp>
#include <evermap/io/detail/labelled_boxes.hpp>

namespace evermap {
namespace {

constexpr double kSpacing = 0.05;  ///< [m] of the survey's points
constexpr double kStep = 0.3;      ///< [m] by which things are off

/// A labelled box in the map.
struct PlacedBox {
  Pose T_map_box;        ///< x along its length
  Eigen::Vector3d size;  ///< [m]
  double range;          ///< [m] from which it was labelled

  PlacedBox(const LabelledBox& box, const Pose& T_map_sensor)
      : size(box.size), range(box.center_sensor.norm()) {
    const Pose T_sensor_box{Eigen::AngleAxisd(box.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix(),
                            box.center_sensor};
    T_map_box = T_map_sensor * T_sensor_box;
  }

  /// Above the wheels, and a little more around.
  bool contains(const Eigen::Vector3d& p_map) const {
    constexpr double kGrowth = 0.2;  // [m] labels and poses are that exact
    constexpr double kWheels = 0.2;  // [m] below is ground
    const Eigen::Vector3d p_box = T_map_box.inverse() * p_map;
    const Eigen::Vector3d half = size / 2 + Eigen::Vector3d::Constant(kGrowth);
    return (p_box.cwiseAbs() - half).maxCoeff() <= 0 && p_box.z() + size.z() / 2 >= kWheels;
  }
};

bool any_contains(const std::vector<PlacedBox>& boxes, const Eigen::Vector3d& p_map) {
  return std::any_of(boxes.begin(), boxes.end(), [&](const PlacedBox& box) { return box.contains(p_map); });
}

using Boxes = std::vector<std::vector<LabelledBox>>;

/// Where anything ever moved. What stands there in scans without labels is a mover's trail as well.
std::vector<PlacedBox> movers_of(const Boxes& boxes, const std::vector<AlignedScan>& scans) {
  std::vector<PlacedBox> movers;
  for (std::size_t i = 0; i < scans.size() && i < boxes.size(); ++i) {
    for (const LabelledBox& box : boxes[i]) {
      if (box.motion != LabelledBox::Motion::kParked) movers.emplace_back(box, scans[i].T_map_sensor);
    }
  }
  return movers;
}

/// Each parked vehicle once, as it was labelled from the nearest.
std::vector<PlacedBox> parked_of(const Boxes& boxes, const std::vector<AlignedScan>& scans) {
  constexpr double kSame = 2;  // [m] between labels of one vehicle
  std::vector<PlacedBox> parked;
  for (std::size_t i = 0; i < scans.size() && i < boxes.size(); ++i) {
    for (const LabelledBox& box : boxes[i]) {
      if (box.motion != LabelledBox::Motion::kParked) continue;
      const PlacedBox placed(box, scans[i].T_map_sensor);
      const auto known = std::find_if(parked.begin(), parked.end(), [&](const PlacedBox& other) {
        return (other.T_map_box.translation - placed.T_map_box.translation).norm() < kSame;
      });
      if (known == parked.end()) {
        parked.push_back(placed);
      } else if (placed.range < known->range) {
        *known = placed;
      }
    }
  }
  return parked;
}

/// The rays of scans up to where a surface may begin that is itself seen at a flat angle or a little off.
std::vector<ScanRays> free_rays(std::vector<ScanRays> rays) {
  constexpr double kLeast = 1;     // [m]
  constexpr double kShare = 0.15;  // of the range: a quarter of a metre above flat ground
  for (ScanRays& scan : rays) {
    for (Eigen::Vector3d& end : scan.ends) {
      const double range = (end - scan.origin).norm();
      end -= (end - scan.origin) * std::min(1.0, std::max(kLeast / range, kShare));
    }
  }
  return rays;
}

/// What does not move, of all scans.
struct StaticSurface {
  Points all;
  Points confirmed;  ///< of voxels that several scans hit, and of which no more scans saw through: noise, and
                     ///< trails that nobody labelled, are not among them
};

StaticSurface static_surface(const std::vector<AlignedScan>& scans, const std::vector<ScanRays>& rays,
                             const Boxes& boxes, const std::vector<PlacedBox>& movers) {
  constexpr int kConfirmations = 3;
  struct Voxel {
    Eigen::Vector3d p_map;
    std::size_t last_scan;
    int scans = 1;
  };
  const VoxelGrid grid{.edge = 2 * kSpacing};
  std::unordered_map<std::uint64_t, Voxel> voxels;
  StaticSurface surface;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const std::vector<PointClass> classes =
        classify(scans[i].scan, i < boxes.size() ? boxes[i] : std::vector<LabelledBox>{});
    for (std::size_t k = 0; k < classes.size(); ++k) {
      if (classes[k] != PointClass::kStatic && classes[k] != PointClass::kParked) continue;
      const Eigen::Vector3d p_map = scans[i].T_map_sensor * scans[i].scan.p_sensor[k];
      const auto key = grid.key(p_map);
      if (!key) continue;
      surface.all.push_back(p_map);
      Voxel& voxel = voxels.try_emplace(key->bits(), Voxel{p_map, i}).first->second;
      if (voxel.last_scan != i) ++voxel.scans;
      voxel.last_scan = i;
    }
  }
  surface.all = thinned(surface.all, kSpacing);
  std::erase_if(surface.all, [&](const Eigen::Vector3d& p) { return any_contains(movers, p); });
  Points hit;
  std::vector<int> times;
  for (const auto& [key, voxel] : voxels) {
    if (voxel.scans < kConfirmations || any_contains(movers, voxel.p_map)) continue;
    hit.push_back(voxel.p_map);
    times.push_back(voxel.scans);
  }
  const std::vector<std::uint8_t> seen_through = scans_beyond(hit, grid, free_rays(rays), 0);
  for (std::size_t i = 0; i < hit.size(); ++i) {
    if (seen_through[i] <= times[i]) surface.confirmed.push_back(hit[i]);
  }
  return surface;
}

/// A place beside or on the way that was driven.
struct Site {
  Eigen::Vector2d xy;
  double yaw;       ///< [rad] of the way there
  double distance;  ///< [m] to the way
};

/// Places around the way, the nearest first.
std::vector<Site> sites_along(const std::vector<AlignedScan>& scans) {
  constexpr double kReach = 22;  // [m]
  const Eigen::Vector2d way =
      (scans.back().T_map_sensor.translation - scans.front().T_map_sensor.translation).head<2>();
  const double yaw = std::atan2(way.y(), way.x());
  Eigen::AlignedBox2d area;
  for (const AlignedScan& s : scans) area.extend(s.T_map_sensor.translation.head<2>());
  std::vector<Site> sites;
  const Eigen::Vector2d corner = area.min().array() - kReach;
  const Eigen::Vector2i meters = (area.sizes().array() + 2 * kReach).cast<int>();
  for (int x = 0; x <= meters.x(); ++x) {
    for (int y = 0; y <= meters.y(); ++y) {
      Site site{corner + Eigen::Vector2d(x, y), yaw, std::numeric_limits<double>::infinity()};
      for (const AlignedScan& s : scans) {
        site.distance = std::min(site.distance, (s.T_map_sensor.translation.head<2>() - site.xy).norm());
      }
      if (site.distance < kReach) sites.push_back(site);
    }
  }
  std::stable_sort(sites.begin(), sites.end(),
                   [](const Site& a, const Site& b) { return a.distance < b.distance; });
  return sites;
}

/// Changes the survey.
class Outdating {
 public:
  Outdating(Points survey, const std::vector<AlignedScan>& scans, std::vector<PlacedBox> parked)
      : survey_(std::move(survey)), ground_(survey_), sites_(sites_along(scans)), parked_(std::move(parked)) {
    for (const PlacedBox& box : parked_) taken_.emplace_back(box.T_map_box.translation.head<2>());
  }

  Points finish() {
    if (parked_.empty()) throw std::runtime_error("no parked vehicle is labelled, so none can be moved");
    shift_what_stands();
    raise_a_strip();
    move_vehicles();
    return std::move(survey_);
  }

 private:
  bool is_apart(const Eigen::Vector2d& xy, double distance) const {
    return std::all_of(taken_.begin(), taken_.end(),
                       [&](const auto& other) { return (other - xy).norm() > distance; });
  }

  /// The nearest place for a rectangle of that half size [m].
  Site take(const Eigen::Vector2d& half, double least_distance) {
    for (const Site& site : sites_) {
      if (site.distance < least_distance || !is_apart(site.xy, half.x() + 4)) continue;
      if (!ground_.is_free(site.xy, site.yaw, half)) continue;
      taken_.push_back(site.xy);
      return site;
    }
    throw std::runtime_error("beside the drive there is not enough free ground");
  }

  void shift_what_stands() {
    constexpr double kEdge = 3;  // [m]
    const auto standing = [&](const Site& site) {
      const bool is_beside = site.distance > 5 && site.distance < 14 && is_apart(site.xy, 6);
      return is_beside ? ground_.standing(site.xy, kEdge) : 0;
    };
    const Site site = *std::max_element(sites_.begin(), sites_.end(), [&](const Site& a, const Site& b) {
      return standing(a) < standing(b);
    });
    taken_.push_back(site.xy);
    const Eigen::Vector2d step = kStep * Eigen::Vector2d(std::cos(site.yaw), std::sin(site.yaw));
    for (Eigen::Vector3d& p : survey_) {
      if ((p.head<2>() - site.xy).lpNorm<Eigen::Infinity>() > kEdge / 2) continue;
      if (p.z() > ground_.height(p.head<2>()).value_or(p.z()) + kStep) p.head<2>() += step;
    }
  }

  void raise_a_strip() {
    const Eigen::Vector2d half(5, 0.9);
    const Site site = take(half, 3.5);
    const Eigen::Rotation2Dd turn(-site.yaw);
    for (Eigen::Vector3d& p : survey_) {
      const Eigen::Vector2d p_site = turn * (p.head<2>() - site.xy);
      if ((p_site.cwiseAbs() - half).maxCoeff() > 0) continue;
      if (p.z() < ground_.height(p.head<2>()).value_or(p.z()) + kStep) p.z() += kStep;
    }
  }

  /// Takes each parked vehicle out and puts copies where the ground is free.
  void move_vehicles() {
    constexpr std::size_t kCopies = 6;
    std::vector<Points> vehicles(parked_.size());  // in the frames of their boxes
    std::erase_if(survey_, [&](const Eigen::Vector3d& p) {
      for (std::size_t i = 0; i < parked_.size(); ++i) {
        if (!parked_[i].contains(p)) continue;
        vehicles[i].push_back(parked_[i].T_map_box.inverse() * p);
        return true;
      }
      return false;
    });
    for (std::size_t copy = 0; copy < kCopies; ++copy) {
      const std::size_t i = copy % parked_.size();
      const Eigen::Vector3d& size = parked_[i].size;
      const Site site = take(size.head<2>() / 2 + Eigen::Vector2d::Constant(0.3), 2.2);
      const Eigen::Vector3d middle(site.xy.x(), site.xy.y(),
                                   ground_.height(site.xy).value_or(0) + size.z() / 2);
      const Pose T_map_copy{Eigen::AngleAxisd(site.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix(), middle};
      for (const Eigen::Vector3d& p_box : vehicles[i]) survey_.emplace_back(T_map_copy * p_box);
    }
  }

  Points survey_;
  GroundMap ground_;
  std::vector<Site> sites_;
  std::vector<PlacedBox> parked_;
  std::vector<Eigen::Vector2d> taken_;  ///< [m] middles of what is changed
};

}  // namespace

OutdatedDrive::OutdatedDrive(const std::filesystem::path& folder, std::size_t scans) {
  PosedScans source(folder / "scans", (folder / "poses_kitti.txt").string(), LidarParameters{}.scan_period);
  const Boxes boxes = read_labelled_boxes(folder / "boxes_velo.csv");
  while (scans_.size() < scans) {
    auto posed = source.next();
    if (!posed) break;
    scans_.push_back({std::move(posed->scan), posed->T_map_sensor});
  }
  lidar.min_range = 2.5;  // the vehicle's own roof
  position_sigma = DriveScore::kPoseSigma;
  StaticSurface surface = static_surface(scans_, rays(), boxes, movers_of(boxes, scans_));
  surface_ = std::move(surface.all);
  confirmed_ = std::move(surface.confirmed);
  survey_ = Outdating(surface_, scans_, parked_of(boxes, scans_)).finish();

  constexpr double kMeasured = 40;  // [m] around the way, beyond which hardly anything is hit twice
  constexpr double kShown = 20;     // [m]
  for (const AlignedScan& s : scans_) view.extend(s.T_map_sensor.translation.head<2>());
  area = view;
  area.min().array() -= kMeasured;
  area.max().array() += kMeasured;
  view.min().array() -= kShown;
  view.max().array() += kShown;
  confirmed_ = within(area, confirmed_);
}

Truth OutdatedDrive::truth(std::size_t) const {
  return {within(area, thinned(surface_, 2 * kSpacing)), confirmed_,
          [this](const Points& points) { return nearest_distances(points, surface_); }};
}

Changes OutdatedDrive::changes(double leaf) const {
  const std::vector<double> to_survey = nearest_distances(confirmed_, survey_);
  const std::vector<double> to_truth = nearest_distances(survey_, surface_);
  Changes changes;
  for (std::size_t i = 0; i < confirmed_.size(); ++i) {
    if (to_survey[i] <= kSpacing) changes.unchanged.push_back(confirmed_[i]);
  }
  for (std::size_t i = 0; i < survey_.size(); ++i) {
    if (to_truth[i] > std::max(leaf / 2, kSpacing)) changes.removed.push_back(survey_[i]);
  }
  const VoxelGrid grid{.edge = leaf};
  return {contradictable(changes.unchanged, grid, rays()),
          contradictable(thinned(changes.removed, 2 * kSpacing), grid, rays())};
}

}  // namespace evermap
