// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstring>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/program.hpp"

namespace evermap {
namespace {

using Json = nlohmann::json;

class VerbsTest : public ProgramTest {};

TEST_F(VerbsTest, WrongUsageIsExitCode2) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{},
        {"bogus"},
        {"import"},
        {"info", "a.evm", "--bogus"},
        {"info", "a.evm", "b.evm"},
        {"import", "a.pcd", "-r", "wide", "-o", "a.evm"},
        {"config", "--mode", "best"},
        {"update", "a.evm", "b", "--poses", "c", "-o", "d", "--threads", "0"},
        {"build", "b", "--poses", "c", "-r", "0.4", "-o", "d", "--min-range", "-1"}}) {
    const Result result = run(arguments);
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_TRUE(result.err.starts_with("evermap: ")) << result.err;
    EXPECT_EQ(result.out, "");
  }
}

TEST_F(VerbsTest, HelpShowsDefaultsAndUnits) {
  EXPECT_EQ(run({"--version"}).out, "evermap " EVERMAP_VERSION "\n");
  EXPECT_NE(run({"--help"}).out.find("update"), std::string::npos);
  const std::string help = run({"update", "--help"}).out;
  for (const char* text : {"--max-range M", "=200", "=default", "=all cores"}) {
    EXPECT_NE(help.find(text), std::string::npos) << text;
  }
}

TEST_F(VerbsTest, AWallThatVanishedLeavesTheMap) {
  make_drive("before", 5, true);
  make_drive("now", 12, false);
  expect_done(build("before", "map.evm"));
  const Result result =
      run(update("map.evm", "now", "out.evm", {"--json", "--report", name("report/of/now")}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json report = Json::parse(result.out);
  EXPECT_EQ(report["scans"]["done"], 12);
  EXPECT_EQ(report["scans"]["interrupted"], false);
  EXPECT_EQ(report["points"]["total"], 12 * 32 * 720);
  EXPECT_EQ(report["points"]["used"], report["points"]["total"]);
  const Json& leaves = report["leaves"];
  EXPECT_GT(leaves["removed"], 20);
  EXPECT_GT(leaves["added"], 20);
  const auto count = [&](const char* name) { return leaves[name].get<int>(); };
  EXPECT_EQ(count("after"), count("before") + count("added") + count("border_added") - count("removed") -
                                count("border_removed"));
  EXPECT_EQ(Json::parse(content(path("report/of/now/report.json"))), report);
  for (const char* picture : {"before.png", "after.png", "change.png"}) {
    EXPECT_TRUE(content(path("report/of/now") / picture).starts_with("\x89PNG")) << picture;
  }
  EXPECT_NE(content(path("report/of/now/viewer.html")).find("id=\"map-data\""), std::string::npos);
  const Json info = Json::parse(run({"info", name("out.evm"), "--json"}).out);
  EXPECT_EQ(info["leaves"]["occupied"], leaves["after"]);
  EXPECT_EQ(info["leaves"]["pending"], leaves["pending"]);
}

TEST_F(VerbsTest, TheInputMapMayBeTheOutputMap) {
  make_drive("drive", 2, true);
  expect_done(build("drive", "map.evm"));
  expect_done(update("map.evm", "drive", "other.evm"));
  expect_done(update("map.evm", "drive", "map.evm"));
  EXPECT_TRUE(content(path("map.evm")) == content(path("other.evm")));
}

TEST_F(VerbsTest, AnyNumberOfThreadsGivesTheSameBytes) {
  make_drive("before", 3, true);
  make_drive("now", 6, false);
  expect_done(build("before", "map.evm"));
  for (const char* mode : {"default", "paper"}) {
    expect_done(update("map.evm", "now", "one.evm", {"--mode", mode, "--threads", "1"}));
    const std::string one = content(path("one.evm"));
    EXPECT_FALSE(one == content(path("map.evm")));
    for (const char* threads : {"2", "3", "8"}) {
      expect_done(update("map.evm", "now", "many.evm", {"--mode", mode, "--threads", threads}));
      EXPECT_TRUE(content(path("many.evm")) == one) << threads << " threads, " << mode;
    }
  }
}

TEST_F(VerbsTest, ImportTrustsTheWholeCloud) {
  // 300 m from the viewpoint, 0.1 m from it, and one point beyond what keys can name.
  make("cloud.pcd",
       "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 4\nHEIGHT 1\n"
       "VIEWPOINT 500000 0 0 1 0 0 0\nPOINTS 4\nDATA ascii\n300 0 0\n0.1 0 0\n1e9 0 0\nnan 0 0\n");
  const Result result = run({"import", name("cloud.pcd"), "-r", "0.4", "-o", name("map.evm"), "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json["leaves"], 2);
  EXPECT_EQ(json["points"]["used"], 2);
  EXPECT_EQ(json["points"]["dropped"]["beyond_the_grid"], 1);
  EXPECT_EQ(json["points"]["dropped"]["not_finite"], 1);
  const Json info = Json::parse(run({"info", name("map.evm"), "--json"}).out);
  EXPECT_EQ(info["leaves"]["occupied"], 2);
  EXPECT_NEAR(info["extent_m"]["greatest"][0], 500300, 0.5);
}

TEST_F(VerbsTest, ExportWritesEveryFormat) {
  make("cloud.bin", room(true));
  expect_done({"import", name("cloud.bin"), "-r", "0.4", "-o", name("map.evm")});
  const auto leaves =
      Json::parse(run({"info", name("map.evm"), "--json"}).out)["leaves"]["occupied"].get<int>();
  for (const char* out : {"out.pcd", "out.ply", "out.ot", "out.bt"}) {
    expect_done({"export", name("map.evm"), name(out)});
    EXPECT_GT(std::filesystem::file_size(path(out)), 100U) << out;
  }
  EXPECT_NE(content(path("out.pcd")).find("POINTS " + std::to_string(leaves) + "\n"), std::string::npos);
  expect_failed({"export", name("map.evm"), name("out.e57")},
                "known are .pcd, .ply, .las, .pgm, .ot and .bt");
}

TEST_F(VerbsTest, WhatIsExportedCanBeImported) {
  make("cloud.bin", room(true));
  expect_done({"import", name("cloud.bin"), "-r", "0.4", "-o", name("map.evm")});
  const auto leaves_of = [&](const char* map) {
    return Json::parse(run({"info", name(map), "--json"}).out)["leaves"]["occupied"].get<int>();
  };
  for (const char* out : {"out.pcd", "out.ply", "out.ot", "out.bt"})
    expect_done({"export", name("map.evm"), name(out)});
  expect_done({"export", name("map.evm"), name("tiles"), "--tiles", "5"});
  for (const char* file : {"out.pcd", "out.ply", "out.ot", "out.bt", "tiles"}) {
    const Result result = run({"import", name(file), "-r", "0.4", "-o", name("again.evm")});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(leaves_of("again.evm"), leaves_of("map.evm")) << file;
    const bool is_octomap = std::string_view(file).ends_with("t");
    EXPECT_EQ(result.err.find("leaves of 0.8 m (-r) lie on it better") != std::string::npos, is_octomap);
  }
}

TEST_F(VerbsTest, AMapKeepsItsFrameAndItsPlaceOnEarth) {
  make_drive("drive", 3, true);
  expect_done({"build", name("drive"), "--poses", name("drive.txt"), "-r", "0.4", "-o", name("map.evm"),
               "--map-frame", "site", "--origin", "48.137,11.575,520.5"});
  const std::string expected = "frame    site, its origin at 48.13700000 north, 11.57500000 east, 520.500 m";
  for (int i = 0; i < 2; ++i) {
    expect_done(
        {"update", name("map.evm"), name("drive"), "--poses", name("drive.txt"), "-o", name("map.evm")});
    for (const std::string map : {"map.evm", "map.evm@1"}) {
      const Result info = run({"info", name(map)});
      EXPECT_NE(info.out.find(expected), std::string::npos) << map << ": " << info.out;
    }
  }
  expect_done({"prune", name("map.evm"), "--keep", "0d", "--keep-daily", "0d"});
  expect_done({"verify", name("map.evm")});
  const Result pruned = run({"info", name("map.evm@3")});
  EXPECT_NE(pruned.out.find(expected), std::string::npos) << pruned.out << pruned.err;
  expect_done({"export", name("map.evm"), name("tiles"), "--tiles", "20"});
  EXPECT_NE(content(path("tiles") / "map_projector_info.yaml").find("latitude: 48.1370000000"),
            std::string::npos);
  EXPECT_EQ(run({"import", name("drive/10000.bin"), "-r", "0.4", "-o", name("out.evm"), "--origin", "1,2"})
                .exit_code,
            2);
  expect_failed({"import", name("drive/10000.bin"), "-r", "0.4", "-o", name("out.evm"), "--origin", "91,0,0"},
                "no place on earth");
}

TEST_F(VerbsTest, BinFieldsAreSaidWhereTheFileDoesNotTell) {
  std::vector<float> values;  // x y z intensity ring: as plausible as 4 values a point
  for (int i = 0; i < 400; ++i) {
    const float angle = 0.1F * static_cast<float>(i);
    values.insert(values.end(), {5 * std::cos(angle), 5 * std::sin(angle), 1, 2, 3});
  }
  std::string bytes(values.size() * sizeof(float), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  make("ring.bin", bytes);
  const Result unsaid = run({"import", name("ring.bin"), "-r", "0.4", "-o", name("map.evm")});
  EXPECT_TRUE(unsaid.exit_code == 0 || unsaid.err.find("--bin-fields") != std::string::npos) << unsaid.err;
  const Result said =
      run({"import", name("ring.bin"), "--bin-fields", "5", "-r", "0.4", "-o", name("map.evm"), "--json"});
  ASSERT_EQ(said.exit_code, 0) << said.err;
  EXPECT_EQ(Json::parse(said.out)["points"]["total"], 400);
  expect_failed({"import", name("ring.bin"), "--bin-fields", "7", "-r", "0.4", "-o", name("no.evm")},
                "ring.bin");
}

TEST_F(VerbsTest, ImportSaysThatAViewpointMovesTheCloud) {
  make("cloud.pcd",
       "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 50 0 0 "
       "1 0 0 0\n"
       "POINTS 2\nDATA ascii\n1 2 3\n2 2 3\n");
  const auto least_x = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"import", name("cloud.pcd"), "-r", "0.4", "-o", name("map.evm")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Result result = run(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err.find("--ignore-viewpoint") != std::string::npos, more.empty()) << result.err;
    return Json::parse(run({"info", name("map.evm"), "--json"}).out)["extent_m"]["least"][0].get<double>();
  };
  EXPECT_GT(least_x({}), 49);
  EXPECT_LT(least_x({"--ignore-viewpoint"}), 2);
}

TEST_F(VerbsTest, ConfigPrintsWhatConfigReads) {
  for (const char* mode : {"default", "paper"}) {
    const std::string printed = run({"config", "--mode", mode}).out;
    make("config.yaml", printed);
    EXPECT_EQ(run({"config", "--config", name("config.yaml")}).out, printed) << mode;
  }
  make("config.yaml",
       "update:\n  impact: equation5_printed\nlidar: {max_range: 7}\n# a comment\ngate: {lost_after: 8}\n");
  const std::string printed = run({"config", "--config", name("config.yaml")}).out;
  for (const char* line : {"\n  impact: equation5_printed ", "\n  max_range: 7 ", "\n  lost_after: 8 "}) {
    EXPECT_NE(printed.find(line), std::string::npos) << line << printed;
  }
}

TEST_F(VerbsTest, OptionsOverrideTheConfigFile) {
  make_drive("drive", 1, false);
  make("config.yaml", "lidar: {min_range: 0, max_range: 1}\n");
  const auto used = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = build("drive", "map.evm");
    arguments.insert(arguments.end(), {"--json", "--config", name("config.yaml")});
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Result result = run(arguments);
    return result.exit_code == 0 ? Json::parse(result.out)["points"]["used"].get<int>() : -result.exit_code;
  };
  EXPECT_EQ(used({}), -1);  // nothing within 1 m
  EXPECT_EQ(used({"--max-range", "100"}), 32 * 720);
  EXPECT_EQ(used({"--max-range", "100", "--vehicle-box", "-99,-99,-99,99,99,99"}), -1);  // all of it
  EXPECT_EQ(used({"--max-range", "100", "--vehicle-box", "0.1,-0.1,-0.1,-0.1,0.1,0.1"}), 32 * 720);
  const int ahead = used({"--max-range", "100", "--vehicle-box", "0,-99,-99,99,99,99"});
  EXPECT_TRUE(ahead > 0 && ahead < 32 * 720) << ahead;
  EXPECT_EQ(used({"--vehicle-box", "1,2,3,4,5"}), -2);
}

TEST_F(VerbsTest, ConfigErrorsNameFileAndLine) {
  const auto expect_error = [&](const std::string& yaml, const std::string& text) {
    make("config.yaml", yaml);
    expect_failed({"config", "--config", name("config.yaml")}, name("config.yaml") + ": at line " + text);
  };
  expect_error("update:\n  hit: 1\n  hitt: 1\n", "3: ");
  expect_error("update:\n  hit: much\n", "2: ");
  expect_error("hit: 1\n", "1: unknown key 'hit'");
  expect_error("update:\n  miss: 1\n  miss: 1\n", "3: ");
  expect_error("- hit\n", "1: ");
  expect_error("update: {\n", "");
}

}  // namespace
}  // namespace evermap
