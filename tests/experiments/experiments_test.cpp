// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <map>
#include <stdexcept>
#include <thread>

#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>

#include "app/program.hpp"
#include "experiments/experiment.hpp"
#include "experiments/ground_map.hpp"
#include "experiments/metrics.hpp"
#include "experiments/outdated_drive.hpp"
#include "experiments/redlight_dataset.hpp"
#include "experiments/result_cache.hpp"
#include "experiments/result_file.hpp"
#include "experiments/scenario_dataset.hpp"
#include <evermap/files/file_error.hpp>

namespace evermap {
namespace {

ScenarioChoice small_yard() {
  return {.scenario = "yard", .scans = 8, .survey_spacing = 0.2, .truth_spacing = 0.31};
}

const ScenarioDataset& yard() {
  static const ScenarioDataset dataset(small_yard(), 1);
  return dataset;
}

Json comparison(const ComparisonRules& rules) {
  return compare_mappers(yard(), usual_mappers(rules.leaf, yard().lidar), rules,
                         [](std::size_t, std::size_t) {});
}

TEST(ComparisonTest, MeasuresAllMappersAlongTheRunAndAtItsEnd) {
  std::vector<std::size_t> progress;
  const Json result = compare_mappers(yard(), usual_mappers(0.8, yard().lidar),
                                      {.leaf = 0.8, .measurements = 4, .has_view = true},
                                      [&](std::size_t done, std::size_t total) {
                                        EXPECT_EQ(total, 8u);
                                        progress.push_back(done);
                                      });
  EXPECT_EQ(progress, (std::vector<std::size_t>{1, 2, 3, 4, 5, 6, 7, 8}));
  std::map<std::string, Json> mappers;
  for (const Json& mapper : result["mappers"]) mappers[mapper["name"]] = mapper;
  EXPECT_EQ(result["mappers"].front()["name"], "static map");
  EXPECT_EQ(result["mappers"].back()["name"], "evermap default");
  EXPECT_EQ(mappers.count("OctoMap, voxel means"), 0);
  for (const auto& [name, mapper] : mappers) {
    std::vector<int> scans;
    for (const Json& row : mapper["rows"]) scans.push_back(row["scan"]);
    EXPECT_EQ(scans, (std::vector<int>{1, 3, 5, 7})) << name;
    EXPECT_GT(at_end(mapper, "COV 0.5"), 0.5) << name;
    EXPECT_GT(at_end(mapper, "SA"), 0.3) << name;
  }
  // Nobody updates the static map: it keeps all, erases nothing, and stays as far from the truth.
  EXPECT_GT(at_end(mappers["static map"], "SA"), 0.99);
  EXPECT_LT(at_end(mappers["static map"], "DA"), 0.1);
  EXPECT_GT(at_end(mappers["evermap default"], "DA"), at_end(mappers["static map"], "DA"));
  EXPECT_TRUE(at_end(mappers["static map"], "nothing").is_null());
}

TEST(ComparisonTest, ThreadsDoNotMatter) {
  const ComparisonRules rules{.leaf = 0.8, .measurements = 2, .has_view = true};
  const std::string with_all = comparison(rules).dump();
  const oneapi::tbb::global_control one_thread(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(comparison(rules).dump(), with_all);
}

TEST(ComparisonTest, PoseNoiseBelongsToItsSeed) {
  const auto with_noise = [](double translation, std::uint64_t seed) {
    Mappers mappers;
    mappers.push_back(make_mapper("evermap default", 0.8, yard().lidar));
    const ComparisonRules rules{.leaf = 0.8, .noise = {translation, translation, seed}};
    return compare_mappers(yard(), std::move(mappers), rules, [](std::size_t, std::size_t) {}).dump();
  };
  EXPECT_EQ(with_noise(0.05, 1), with_noise(0.05, 1));
  EXPECT_NE(with_noise(0.05, 1), with_noise(0.05, 2));
  EXPECT_NE(with_noise(0.05, 1), with_noise(0, 1));
}

TEST(ScenarioDatasetTest, TruthIsWithoutWhatMoves) {
  const ScenarioDataset dataset(
      {.scenario = "passing", .every = 60, .scans = 121, .truth_spacing = 0.41, .view = {}}, 1);
  ASSERT_EQ(dataset.scans().size(), 3u);
  EXPECT_EQ(dataset.number(2), 120u);
  ASSERT_EQ(dataset.dynamic_objects().size(), 1u);
  EXPECT_EQ(dataset.dynamic_objects()[0].name, "pedestrian");
  const Points& pedestrian = dataset.dynamic_objects()[0].p_map[1];
  ASSERT_GT(pedestrian.size(), 20u);
  const Truth truth = dataset.truth(1);
  const std::vector<double> distances = truth.distances(pedestrian);
  EXPECT_GT(*std::max_element(distances.begin(), distances.end()), 0.5);  // the head is above all that stays
  EXPECT_LT(truth.observed.size(), truth.surface.size());
  EXPECT_GT(truth.observed.size(), truth.surface.size() / 40);
  EXPECT_TRUE(dataset.changes(0.4).removed.empty());
}

TEST(ScenarioDatasetTest, DistancesToTheSurfaceAreExact) {
  const Truth truth = yard().truth(7);
  Points lifted = truth.observed;
  lifted.resize(200);
  EXPECT_LT(nearest_distances(lifted, truth.surface).front(), 1e-9);
  for (const double distance : truth.distances(lifted)) EXPECT_LT(distance, 1e-6);
  for (Eigen::Vector3d& p : lifted) p.z() += 0.05;
  for (const double distance : truth.distances(lifted)) {
    EXPECT_LT(distance, 0.0501);  // samples alone, 0.31 m apart, would say up to 0.2 m
  }
}

/// Ten points in a row, of which a map may have some.
struct Row : testing::Test {
  Row() {
    for (int i = 0; i < 10; ++i) points.emplace_back(0.5 + i, 0.5, 0);
    truth = {points, points, [this](const Points& map) { return nearest_distances(map, points); }};
  }
  Points points;
  Truth truth;
  Eigen::AlignedBox2d area{Eigen::Vector2d(0, 0), Eigen::Vector2d(10, 1)};
};
using MetricsTest = Row;

TEST_F(MetricsTest, CountCoverageAndAccuracy) {
  const Points map{
      {0.5, 0.5, 0.15}, {1.5, 0.5, 0}, {2.5, 0.5, 0.3}, {50, 0.5, 0}};  // the last is not measured
  const Json row = measure_surface(map, truth, area, 0.4);
  EXPECT_DOUBLE_EQ(row["COV 0.1"], 0.1);
  EXPECT_DOUBLE_EQ(row["COV 0.2"], 0.2);
  EXPECT_DOUBLE_EQ(row["COV l"], 0.3);
  EXPECT_DOUBLE_EQ(row["ACC 0.1"], 1.0 / 3);
  EXPECT_DOUBLE_EQ(row["ACC l"], 1);
  EXPECT_NEAR(row["map to truth"], 0.15, 1e-12);
  EXPECT_GT(row["AHD"], 1);  // holes
}

TEST_F(MetricsTest, PicturesTellHolesFromGhosts) {
  Points map(points.begin(), points.begin() + 5);
  map.emplace_back(0.5, 0.5, 3);
  const Json picture = seen_from_above(map, truth, area, 0.4);
  ASSERT_EQ(picture.size(), 4u);  // 1 m in cells of 0.3 m
  const std::string row = picture[1];
  ASSERT_EQ(row.size(), 34u);
  const auto at = [&](double x) { return static_cast<Cell>(row[static_cast<std::size_t>(x / kCellEdge)]); };
  EXPECT_EQ(at(0.5), Cell::kGhost);
  EXPECT_EQ(at(1.5), Cell::kKept);
  EXPECT_EQ(at(7.5), Cell::kHole);
  EXPECT_EQ(at(2.0), Cell::kNothing);
}

TEST(GroundMapTest, KnowsFreeGround) {
  Points surface;
  for (double x = 0.1; x < 20; x += 0.2) {
    for (double y = 0.1; y < 20; y += 0.2) surface.emplace_back(x, y, 0.01 * x);
  }
  for (double z = 0; z < 2; z += 0.1) surface.emplace_back(5, 5, z);  // a post
  const GroundMap ground(surface);
  EXPECT_NEAR(ground.height({10.2, 3}).value(), 0.1, 0.01);
  EXPECT_FALSE(ground.height({30, 3}).has_value());
  EXPECT_TRUE(ground.is_free({12, 12}, 0.7, {3, 1}));
  EXPECT_FALSE(ground.is_free({6, 5}, 0, {3, 1}));  // the post
  EXPECT_TRUE(ground.is_free({6, 5}, 1.57, {3, 0.5}));
  EXPECT_FALSE(ground.is_free({20, 12}, 0, {3, 1}));  // half of it was not seen
  EXPECT_GT(ground.standing({5, 5}, 3), 10u);
  EXPECT_EQ(ground.standing({12, 12}, 3), 0u);
}

std::filesystem::path data() {
  const char* named = std::getenv("EVERMAP_DATA");
  return named ? named : EVERMAP_DEFAULT_DATA;
}

TEST(OutdatedDriveTest, TheSurveyIsOutdatedAndTheTruthIsNot) {
  const std::filesystem::path folder = data() / "kitti_0005_drive";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << folder << " is not there";
  const OutdatedDrive dataset(folder, 6);
  ASSERT_EQ(dataset.scans().size(), 6u);
  const Truth truth = dataset.truth(5);
  EXPECT_GT(truth.observed.size(), 20000u);
  const Changes changes = dataset.changes(0.4);
  EXPECT_GT(changes.unchanged.size(), 10000u);
  EXPECT_GT(changes.removed.size(), 100u);
  for (const double distance : truth.distances(changes.removed)) EXPECT_GT(distance, 0.2);
  for (const double distance : nearest_distances(changes.unchanged, dataset.survey()))
    EXPECT_LE(distance, 0.05);
}

TEST(RedlightDatasetTest, TrafficIsNoSurface) {
  const std::filesystem::path folder = data() / "kitti_redlight_standstill";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << folder << " is not there";
  const RedlightDataset dataset(folder);
  ASSERT_EQ(dataset.scans().size(), 22u);
  EXPECT_EQ(dataset.number(21), 76u);
  ASSERT_EQ(dataset.dynamic_objects().size(), 1u);
  // A car passes on the other carriageway: at scan 64 its middle is near (-0.7, 20.3).
  const Points& traffic = dataset.dynamic_objects()[0].p_map[9];
  Points car;
  std::copy_if(traffic.begin(), traffic.end(), std::back_inserter(car), [](const Eigen::Vector3d& p) {
    return (p.head<2>() - Eigen::Vector2d(-0.7, 20.3)).norm() < 3;
  });
  ASSERT_GT(car.size(), 50u);
  std::vector<double> distances = dataset.truth(0).distances(car);
  std::sort(distances.begin(), distances.end());
  EXPECT_GT(distances[distances.size() / 2], 0.3);
}

using ResultCacheTest = FileTest;

TEST_F(ResultCacheTest, KeepsWhatWasComputed) {
  int computed = 0;
  const auto unit = [&](int scans) {
    return Unit{"part", "Part", {{"scans", scans}}, [&computed](const Progress& progress) {
                  progress(1, 1);
                  ++computed;
                  return Json{{"value", NAN}, {"count", computed}};
                }};
  };
  const Progress ignore = [](std::size_t, std::size_t) {};
  const ResultCache cache(path("results"), false);
  EXPECT_FALSE(cache.stored(unit(1)).has_value());
  const Json first = cache.result(unit(1), ignore);
  EXPECT_EQ(first["count"], 1);
  EXPECT_TRUE(first["value"].is_null());  // JSON has no NaN
  EXPECT_EQ(ResultCache(path("results"), false).result(unit(1), ignore), first);
  EXPECT_EQ(computed, 1);
  EXPECT_EQ(cache.result(unit(2), ignore)["count"], 2);  // other settings
  EXPECT_EQ(cache.result(unit(1), ignore), first);       // which do not drive out the first

  for (const auto& entry : std::filesystem::directory_iterator(path("results/units"))) {
    std::filesystem::resize_file(entry.path(), 40);
  }
  EXPECT_FALSE(cache.stored(unit(1)).has_value());
  EXPECT_EQ(cache.result(unit(1), ignore)["count"], 3);
}

TEST_F(ResultCacheTest, ComputesUnitsSideBySideAndTimedOnesAlone) {
  std::atomic<int> at_work = 0;
  std::atomic<int> most_beside_timed = 0;
  std::vector<Unit> units;
  for (int i = 0; i < 24; ++i) {
    const bool is_timed = i % 4 == 1;
    const auto compute = [&, i, is_timed](const Progress& progress) {
      ++at_work;
      std::atomic<int> sum = 0;
      oneapi::tbb::parallel_for(0, 100, [&](int k) { sum += i * k; });
      if (is_timed) most_beside_timed = std::max<int>(most_beside_timed, at_work - 1);
      progress(1, 2);
      progress(2, 2);
      --at_work;
      return Json{{"sum", sum.load()}};
    };
    units.push_back({fmt::format("part_{}", i), "", Json::object(), compute, is_timed});
  }
  const ResultCache cache(path("results"), false);
  std::vector<std::vector<std::size_t>> watched(units.size());
  cache.compute(units, [&](std::size_t i, std::size_t done, std::size_t) { watched[i].push_back(done); });
  EXPECT_EQ(most_beside_timed, 0);
  for (std::size_t i = 0; i < units.size(); ++i) {
    EXPECT_EQ(watched[i], (std::vector<std::size_t>{0, 1, 2}));
    EXPECT_EQ(cache.stored(units[i]).value()["sum"], 4950 * i);
  }
}

TEST_F(ResultCacheTest, AUnitThatFailsDoesNotTakeOthersWithIt) {
  std::vector<Unit> units{{"fine", "", Json::object(), [](const Progress&) { return Json{{"value", 1}}; }}};
  for (int i = 0; i < 8; ++i)
    units.push_back({fmt::format("bad_{}", i), "", Json::object(),
                     [](const Progress&) -> Json { throw std::runtime_error("no scans"); }});
  const ResultCache cache(path("results"), false);
  const oneapi::tbb::global_control one_thread(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_THROW(cache.compute(units, [](std::size_t, std::size_t, std::size_t) {}), std::runtime_error);
  EXPECT_TRUE(cache.stored(units[0]).has_value());
  EXPECT_FALSE(cache.stored(units[1]).has_value());
}

TEST_F(ResultCacheTest, TakesResultsOfAnotherBuildOnlyWhenTold) {
  const Unit unit{"part", "", Json::object(), [](const Progress&) { return Json{{"value", 1}}; }};
  ResultCache(path("results"), false).result(unit, {});
  for (const auto& entry : std::filesystem::directory_iterator(path("results/units"))) {
    std::string text = content(entry.path());
    Json kept = Json::parse(text);
    kept["program"] = "another";
    std::ofstream(entry.path()) << kept.dump();
  }
  EXPECT_FALSE(ResultCache(path("results"), false).stored(unit).has_value());
  EXPECT_TRUE(ResultCache(path("results"), true).stored(unit).has_value());
}

TEST_F(ResultCacheTest, RefusesFoldersOfOthers) {
  std::filesystem::create_directory(path("mine"));
  make("mine/thesis.tex", "years of work");
  EXPECT_THROW(ResultCache(path("mine"), false), FileError);
  EXPECT_FALSE(std::filesystem::exists(path("mine/units")));
  make("file", "x");
  EXPECT_THROW(ResultCache(path("file"), false), FileError);
}

TEST(ResultFileTest, OneLineOfCsvForEachFigure) {
  const Experiment experiment{"x", {{"unit_1", "Unit 1", {{"leaf", 2}}, {}}, {"unit_2", "Unit 2", {}, {}}}};
  const Json comparison = Json::parse(R"({"scans": 2, "mappers": [
      {"name": "one, or two", "rows": [{"SA": 0.5, "scan": 3}, {"SA": null, "scan": 7}],
       "end": {"DA": 0.25, "error": [1, 2]}, "view": ["kk"]}]})");
  const Json rules = Json::parse(R"({"paper": {"kept": 0.75}})");
  const Json units = to_json(experiment, {comparison, rules});
  EXPECT_EQ(units["unit_1"]["settings"]["leaf"], 2);
  EXPECT_EQ(units["unit_2"]["title"], "Unit 2");
  EXPECT_EQ(to_csv(units),
            "unit,mapper,scan,metric,value\nunit_1,\"one, or two\",3,\"SA\",0.5\n"
            "unit_1,\"one, or two\",,\"DA\",0.25\nunit_2,\"paper\",,\"kept\",0.75\n");
  EXPECT_FALSE(without_views(units)["unit_1"]["result"]["mappers"][0].contains("view"));
}

class ExperimentTest : public ProgramTest {
 protected:
  std::vector<std::string> timing(const std::string& leaves,
                                  const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"timing", "-o", name("results"), "--quick", "--leaf", leaves};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
};

TEST_F(ExperimentTest, WritesResultsAndComputesNothingTwice) {
  const Result first = run(timing("2"));
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_EQ(first.out, "results  " + name("results/timing.json") + "\n");
  EXPECT_NE(first.err.find("part 1 of 2: timing_2"), std::string::npos) << first.err;
  const std::string text = content(path("results/timing.json"));
  const Json whole = Json::parse(text);
  EXPECT_EQ(whole["command"],
            "build/release/experiments/evermap_experiments timing -o DIR --quick --seed 1 --leaf 2");
  EXPECT_TRUE(whole["quick"]);
  EXPECT_TRUE(whole["machine"].contains("processor"));
  EXPECT_NE(content(path("results/timing.csv")).find("timing_2,\"OctoMap\",,\"median_ms\","),
            std::string::npos);

  const Result second = run(timing("2"));
  EXPECT_NE(second.err.find("timing_2 (kept from an earlier run)"), std::string::npos) << second.err;
  EXPECT_EQ(content(path("results/timing.json")), text);
  const Json all = Json::parse(run(timing("2", {"--json"})).out);
  EXPECT_EQ(all["timing"]["timing_2"]["settings"]["leaf"], 2);
  EXPECT_EQ(all["timing"]["timing_2_empty"]["settings"]["start"], "empty");
}

TEST_F(ExperimentTest, GoesOnWhereItWasInterrupted) {
  const auto finished = [&] {
    std::error_code error;
    const std::filesystem::directory_iterator units(path("results/units"), error);
    return error ? 0 : std::count_if(begin(units), end(units), [](const auto& entry) {
      return entry.path().extension() == ".json";
    });
  };
  const auto process = start(timing("2,1.6"));
  const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (finished() == 0 && std::chrono::steady_clock::now() < patience) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  process->send(SIGKILL);
  process->wait();
  ASSERT_GT(finished(), 0);
  const Result rest = run(timing("2,1.6"));
  EXPECT_EQ(rest.exit_code, 0) << rest.err;
  EXPECT_NE(rest.err.find("timing_2 (kept from an earlier run)"), std::string::npos) << rest.err;
  EXPECT_TRUE(std::filesystem::exists(path("results/timing.json")));
}

TEST_F(ExperimentTest, RefusesWhatCannotBe) {
  std::filesystem::create_directory(path("mine"));
  make("mine/notes", "x");
  expect_failed({"c", "-o", name("mine")}, "evermap_experiments did not write");
  EXPECT_EQ(run({"c", "-o", name("results"), "--leaf", "-1"}).exit_code, 2);
  EXPECT_EQ(run({"d", "-o", name("results")}).exit_code, 2);
  EXPECT_FALSE(std::filesystem::exists(path("results")));
}

TEST(SetupTest, RealDataThatIsMissingIsLeftOutAndSaidSo) {
  evermap::Setup setup;
  for (const auto& make : {experiment_a, experiment_b}) {
    setup.data.clear();
    const Experiment without = make(setup);
    ASSERT_EQ(without.left_out.size(), 1u);
    EXPECT_NE(without.left_out[0].find("no --data"), std::string::npos);
    EXPECT_FALSE(without.units.empty());
    setup.data = "/nowhere";
    const Experiment elsewhere = make(setup);
    ASSERT_EQ(elsewhere.left_out.size(), 1u);
    EXPECT_NE(elsewhere.left_out[0].find("/nowhere/kitti"), std::string::npos);
    EXPECT_EQ(elsewhere.units.size(), without.units.size());
  }
}

}  // namespace
}  // namespace evermap
