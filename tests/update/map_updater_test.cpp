// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstring>
#include <functional>
#include <optional>
#include <ostream>
#include <string>
#include <support/random_geometry.hpp>
#include <support/reference_update.hpp>
#include <support/toy_scene.hpp>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <evermap/maintenance/parameters.hpp>
#include <evermap/update/detail/map_updater.hpp>

namespace evermap {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;
using test::Random;
using test::ReferenceLeaf;
using test::ReferenceUpdate;
using test::ToyScene;

/// One way to run the update, and where.
struct Mode {
  std::string name;
  Parameters parameters;
  std::optional<Parameters> base;     ///< what it varies, if any
  double edge = 0.4;                  ///< [m]
  Vector3d place = Vector3d::Zero();  ///< [m]
  int points = 900;                   ///< of each scan
};

void PrintTo(const Mode& mode, std::ostream* out) { *out << mode.name; }

Mode varied(const std::string& name, const Parameters& base, const std::function<void(Parameters&)>& change) {
  Mode mode{name, base, base};
  change(mode.parameters);
  return mode;
}

/// Where surfaces have leaves enough to be regions.
Mode at_fine_leaves(Mode mode) {
  mode.edge = 0.2;
  mode.points = 1900;
  return mode;
}

using P = Parameters;

/// The default mode, each of its rules switched, and without the guards, which hide what some rules do.
std::vector<Mode> default_modes() {
  const Parameters standard;
  Parameters bare;
  bare.update.spare_reobserved = false;
  bare.update.surface_crossing = false;
  bare.update.hit_margin = 0;
  return {
      {"Default", standard, {}},
      {"DefaultFineLeaves", standard, {}, 0.2},
      {"DefaultDense", standard, {}, 0.4, Vector3d::Zero(), 4000},
      {"DefaultFarAway", standard, {}, 0.4, Vector3d(1e6, -5e6, 500)},
      varied("Equation5Inverse", standard, [](P& p) { p.update.impact = ImpactRule::kEquation5Inverse; }),
      varied("Equation5Printed", standard, [](P& p) { p.update.impact = ImpactRule::kEquation5Printed; }),
      varied("Maximum", standard, [](P& p) { p.update.combination = Combination::kMaximum; }),
      varied("NoGuard", standard, [](P& p) { p.update.spare_reobserved = false; }),
      varied("SigmaPoints", standard, [](P& p) { p.update.trim_leaves = true; }),
      varied("AnyImpact", standard, [](P& p) { p.update.least_impact = 0; }),
      varied("LittleTolerance", standard, [](P& p) { p.update.surface_tolerance = 1; }),
      varied("OneConfirmation", standard, [](P& p) { p.update.confirmations = 1; }),
      varied("TwoConfirmations", standard, [](P& p) { p.update.confirmations = 2; }),
      varied("ShortMemory", standard, [](P& p) { p.update.max_count = 5; }),
      varied("LowClamp", standard, [](P& p) { p.update.max_log_odds = 2.5; }),
      varied("NoLongTerm", standard, [](P& p) { p.update.long_term_hit = 0; }),
      varied("LongTermSoon", standard,
             [](P& p) { p.update.long_term_hit = 3, p.update.long_term_max_log_odds = 5; }),
      varied("ForgetsNothing", standard, [](P& p) { p.update.forgetting = 0; }),
      varied("EveryHitMoves", standard, [](P& p) { p.update.settled = 0; }),
      varied("HardlyAnyHitMoves", standard, [](P& p) { p.update.settled = 20; }),
      varied("SureOfExtent", standard, [](P& p) { p.update.extent_prior = 0; }),
      varied("UnsureOfExtent", standard, [](P& p) { p.update.extent_prior = 8; }),
      varied("NoPatch", standard, [](P& p) { p.update.patch_radius = 0; }),
      at_fine_leaves(varied("NoRegions", standard, [](P& p) { p.update.rim_gone = 0; })),
      at_fine_leaves(varied("RegionsGoEasily", standard, [](P& p) { p.update.rim_gone = 0.1; })),
      varied("NearOnly", standard, [](P& p) { p.lidar.min_range = 4, p.lidar.max_range = 15; }),
      varied("CoarseSensor", standard, [](P& p) { p.lidar.range_sigma = 0.05; }),
      {"Bare", bare, {}},
      varied("BareCrossing", bare, [](P& p) { p.update.surface_crossing = true; }),
      varied("BareHitMargin", bare, [](P& p) { p.update.hit_margin = 100; }),
      varied("BareReobserved", bare, [](P& p) { p.update.spare_reobserved = true; }),
  };
}

/// The paper's mode and each of its rules switched.
std::vector<Mode> paper_modes() {
  const Parameters paper = Parameters::paper();
  return {
      {"Paper", paper, {}},
      {"PaperFineLeaves", paper, {}, 0.2},
      {"PaperFarAway", paper, {}, 0.4, Vector3d(1e6, -5e6, 500)},
      varied("PaperPrinted", paper, [](P& p) { p.update.impact = ImpactRule::kEquation5Printed; }),
      varied("PaperClosestApproach", paper,
             [](P& p) {
               p.update.impact = ImpactRule::kClosestApproach;
               p.update.trim_leaves = false;
             }),
      varied("PaperNoisyOr", paper, [](P& p) { p.update.combination = Combination::kNoisyOr; }),
      varied("PaperReobserved", paper, [](P& p) { p.update.spare_reobserved = true; }),
      varied("PaperNoDifference", paper, [](P& p) { p.update.trim_leaves = false; }),
      varied("PaperHitMargin", paper, [](P& p) { p.update.hit_margin = 100; }),
      varied("PaperThreeConfirmations", paper, [](P& p) { p.update.confirmations = 3; }),
  };
}

AlignedBox3d box_at(double x, double y, double size, const Vector3d& place) {
  const Vector3d corner = place + Vector3d(x, y, 0);
  return {corner, corner + Vector3d(size, size, 1.5 * size)};
}

/// A drive past boxes of which some vanish and one appears after the third scan.
struct Drive {
  struct Stop {
    Scan scan;
    Pose T_map_sensor;
    bool builds;  ///< the initial map, or an update
  };
  std::vector<Stop> stops;

  Drive(const Vector3d& place, int points, std::uint64_t seed) {
    Random random(seed);
    const AlignedBox3d wall = box_at(20, -15, 30, place), stays = box_at(5, -2.5, 1, place);
    const ToyScene before{place.z(), {wall, stays, box_at(4, -0.6, 1.1, place), box_at(6.5, 1, 1.4, place)}};
    const ToyScene after{place.z(), {wall, stays, box_at(8, -0.3, 1, place)}};
    for (int i = 0; i < 10; ++i) {
      Pose T_map_sensor;
      T_map_sensor.rotation =
          Eigen::AngleAxisd(random.uniform(-0.1, 0.1), Vector3d::UnitZ()).toRotationMatrix();
      T_map_sensor.translation = place + Vector3d(0.15 * i + 0.013, random.uniform(-0.3, 0.3), 1.2);
      const ToyScene& scene = i < 3 ? before : after;
      stops.push_back({scene.scan(T_map_sensor, points, 0.02, random), T_map_sensor, i < 3});
    }
  }
};

/// What a comparison saw, so that it cannot pass by having seen nothing.
struct Seen {
  int compared = 0;
  int ambiguous = 0;
  int erased = 0;
  int weakened = 0;
};

ReferenceLeaf read(const Octree& octree, VoxelKey key) {
  const Leaf& leaf = *octree.find(key);
  const Gaussian surface = octree.gaussian(key, leaf);
  return {surface.mean, surface.covariance, surface.count, static_cast<double>(leaf.log_odds)};
}

void expect_close(const ReferenceLeaf& found, const ReferenceLeaf& expected, double edge) {
  EXPECT_NEAR(found.log_odds, expected.log_odds, 1e-4);
  EXPECT_LE((found.mean - expected.mean).norm(), 1e-4 * edge);
  EXPECT_LE((found.covariance - expected.covariance).norm(), 1e-4 * expected.covariance.trace());
  EXPECT_NEAR(found.count, expected.count, 1e-4 * expected.count);
}

/// Compares leaf by leaf. Where any outcome is right, the reference goes on with the map's.
void compare(const Octree& octree, ReferenceUpdate& reference, Seen& seen) {
  for (const VoxelKey key : reference.ambiguous) {
    reference.leaves.erase(key);
    if (octree.find(key)) reference.leaves[key] = read(octree, key);
    ++seen.ambiguous;
  }
  ASSERT_EQ(octree.leaf_count(), reference.leaves.size());
  for (const auto& [key, expected] : reference.leaves) {
    ASSERT_NE(octree.find(key), nullptr) << key.voxel().transpose();
    expect_close(read(octree, key), expected, octree.grid().edge);
    if (::testing::Test::HasFailure()) FAIL() << "leaf " << key.voxel().transpose();
    ++seen.compared;
  }
}

class MapUpdaterMode : public ::testing::TestWithParam<Mode> {};

void integrate(Octree& octree, const Drive::Stop& stop, const Parameters& parameters) {
  const BundleGrid bundles = condense(stop.scan, stop.T_map_sensor, octree.grid(), parameters.lidar);
  if (stop.builds) {
    add(octree, bundles, parameters.update);
  } else {
    update(octree, bundles, parameters.update);
  }
}

TEST_P(MapUpdaterMode, EqualsTheReference) {
  const Mode& mode = GetParam();
  const VoxelGrid grid = VoxelGrid::around(mode.place, mode.edge);
  Seen seen;
  for (const std::uint64_t seed : {1, 2}) {
    Octree octree(grid);
    ReferenceUpdate reference(grid);
    for (const Drive::Stop& stop : Drive(mode.place, mode.points, seed).stops) {
      const auto before = reference.leaves;
      integrate(octree, stop, mode.parameters);
      if (stop.builds) {
        reference.add(stop.scan, stop.T_map_sensor, mode.parameters);
      } else {
        reference.update(stop.scan, stop.T_map_sensor, mode.parameters);
      }
      compare(octree, reference, seen);
      if (HasFatalFailure()) return;
      for (const auto& [key, leaf] : before) {
        const auto now = reference.leaves.find(key);
        seen.erased += now == reference.leaves.end();
        seen.weakened += now != reference.leaves.end() && now->second.log_odds < leaf.log_odds;
      }
    }
  }
  EXPECT_GT(seen.compared, 2000);
  EXPECT_LT(seen.ambiguous, seen.compared / 20);
  EXPECT_GT(seen.erased, 5);
  EXPECT_GT(seen.weakened, 5);
  RecordProperty("compared", seen.compared);
  RecordProperty("ambiguous", seen.ambiguous);
  RecordProperty("erased", seen.erased);
  RecordProperty("weakened", seen.weakened);
}

std::vector<std::pair<VoxelKey, Leaf>> leaves_of(const Octree& octree) {
  std::vector<std::pair<VoxelKey, Leaf>> leaves;
  octree.for_each_leaf([&](VoxelKey key, const Leaf& leaf) { leaves.emplace_back(key, leaf); });
  return leaves;
}

bool same_bits(const std::pair<VoxelKey, Leaf>& a, const std::pair<VoxelKey, Leaf>& b) {
  static_assert(sizeof(Leaf) == 11 * sizeof(float), "padding would make bytes differ");
  return a.first == b.first && std::memcmp(&a.second, &b.second, sizeof(Leaf)) == 0;
}

Octree driven(const Mode& mode, const Parameters& parameters) {
  Octree octree(VoxelGrid::around(mode.place, mode.edge));
  for (const Drive::Stop& stop : Drive(mode.place, mode.points, 1).stops) {
    integrate(octree, stop, parameters);
  }
  return octree;
}

/// Otherwise the comparison above would not have tested the switch.
TEST_P(MapUpdaterMode, MattersInThisDrive) {
  const Mode& mode = GetParam();
  if (!mode.base) return;
  const auto base = leaves_of(driven(mode, *mode.base));
  const auto found = leaves_of(driven(mode, mode.parameters));
  EXPECT_FALSE(std::equal(base.begin(), base.end(), found.begin(), found.end(), same_bits));
}

INSTANTIATE_TEST_SUITE_P(Default, MapUpdaterMode, ::testing::ValuesIn(default_modes()),
                         [](const auto& instance) { return instance.param.name; });
INSTANTIATE_TEST_SUITE_P(Paper, MapUpdaterMode, ::testing::ValuesIn(paper_modes()),
                         [](const auto& instance) { return instance.param.name; });

TEST(MapUpdater, IsBitIdenticalForAnyNumberOfThreads) {
  const Drive drive(Vector3d::Zero(), 8000, 3);
  for (const Parameters& parameters : {Parameters{}, Parameters::paper()}) {
    std::vector<std::pair<VoxelKey, Leaf>> alone;
    for (const int threads : {1, 2, 3, 8}) {
      const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism,
                                              static_cast<std::size_t>(threads));
      oneapi::tbb::task_arena arena(threads);
      Octree octree(VoxelGrid{0.2});
      arena.execute([&] {
        for (const Drive::Stop& stop : drive.stops) {
          integrate(octree, stop, parameters);
        }
      });
      const auto leaves = leaves_of(octree);
      EXPECT_GT(leaves.size(), 1000U);
      if (threads == 1) alone = leaves;
      EXPECT_TRUE(std::equal(leaves.begin(), leaves.end(), alone.begin(), alone.end(), same_bits)) << threads;
    }
  }
}

/// A repeated look pulls a leaf towards its points by its view_weight only; its word on occupancy is full.
TEST(MapUpdater, ViewWeightWeighsGeometryAlone) {
  Scan left, right;
  left.p_sensor.assign(4, {3.05, 0.1, 0.1});
  right.p_sensor.assign(4, {3.15, 0.1, 0.1});
  Octree octree(VoxelGrid{0.2});
  add(octree, condense(left, {}, octree.grid(), {}), {});
  const VoxelKey key = *octree.grid().key(left.p_sensor[0]);
  const float log_odds = octree.find(key)->log_odds;
  update(octree, condense(right, {}, octree.grid(), {}), {}, 0.25);
  EXPECT_NEAR(octree.gaussian(key, *octree.find(key)).mean.x(), (4 * 3.05 + 3.15) / 5, 1e-6);
  EXPECT_GT(octree.find(key)->log_odds, log_odds);
}

TEST(AddScan, OccupiesAtOnceAndContradictsNothing) {
  Scan wall_far, wall_near;
  for (int i = 0; i < 50; ++i) {
    wall_near.p_sensor.emplace_back(4.1, 0.05 * i - 1.2, 0.1);
    wall_far.p_sensor.emplace_back(8.1, 0.1 * i - 2.4, 0.2);
  }
  Octree octree(VoxelGrid{0.2});
  add(octree, condense(wall_near, {}, octree.grid(), {}), {});
  const std::size_t near = octree.leaf_count();
  octree.for_each_leaf([](VoxelKey, const Leaf& leaf) { EXPECT_TRUE(leaf.occupied()); });
  add(octree, condense(wall_far, {}, octree.grid(), {}), {});
  std::size_t kept = 0;
  octree.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
    EXPECT_FLOAT_EQ(leaf.log_odds, 2.197F);
    kept += octree.grid().center(key).x() < 5;
  });
  EXPECT_EQ(kept, near);
  // The update would have erased it in time: the rays behind it pass straight through.
  for (int i = 0; i < 4; ++i) update(octree, condense(wall_far, {}, octree.grid(), {}), {});
  kept = 0;
  octree.for_each_leaf([&](VoxelKey key, const Leaf&) { kept += octree.grid().center(key).x() < 5; });
  EXPECT_LT(kept, near);
}

TEST(Update, EmptyScanChangesNothing) {
  Octree octree(VoxelGrid{0.2});
  add(octree, condense(Drive(Vector3d::Zero(), 500, 4).stops[0].scan, {}, octree.grid(), {}), {});
  const auto before = leaves_of(octree);
  update(octree, condense({}, {}, octree.grid(), {}), {});
  const auto after = leaves_of(octree);
  EXPECT_TRUE(std::equal(before.begin(), before.end(), after.begin(), after.end(), same_bits));
}

}  // namespace
}  // namespace evermap
