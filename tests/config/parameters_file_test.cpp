// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "files/file_fixture.hpp"
#include <evermap/config/parameters_file.hpp>

namespace evermap {
namespace {

class ParametersFileTest : public FileTest {
 protected:
  void refuses(const std::string& text, const std::string& place, const std::string& why) {
    const auto file = make("parameters.yaml", text);
    Parameters parameters;
    try {
      read_parameters(file, parameters);
      ADD_FAILURE() << "took: " << text;
    } catch (const FileError& error) {
      const std::string what = error.what();
      EXPECT_NE(what.find(file.string() + ": at " + place), std::string::npos) << what;
      EXPECT_NE(what.find(why), std::string::npos) << what;
    }
  }
};

TEST_F(ParametersFileTest, SetsWhatItNamesAndNothingElse) {
  const auto file =
      make("parameters.yaml",
           "lidar:\n  max_range: 60\nupdate:\n  impact: equation5_printed\n  trim_leaves: true\n"
           "gate: {lost_after: 9}\nrollback:\n  scans: 3  # a comment\n");
  Parameters parameters;
  read_parameters(file, parameters);
  EXPECT_EQ(parameters.lidar.max_range, 60);
  EXPECT_TRUE(parameters.lidar.vehicle_box.isEmpty());
  EXPECT_EQ(parameters.lidar.min_range, Parameters{}.lidar.min_range);
  EXPECT_EQ(parameters.update.impact, ImpactRule::kEquation5Printed);
  EXPECT_TRUE(parameters.update.trim_leaves);
  EXPECT_EQ(parameters.localization.gate.lost_after, 9);
  EXPECT_EQ(parameters.rollback.scans, 3);
}

TEST_F(ParametersFileTest, AFileOfCommentsSetsNothing) {
  Parameters parameters = Parameters::paper();
  read_parameters(make("parameters.yaml", "# nothing\n"), parameters);
  EXPECT_EQ(to_yaml(parameters), to_yaml(Parameters::paper()));
}

TEST_F(ParametersFileTest, TakesWhatItWrote) {
  Parameters written = Parameters::paper();
  written.lidar.scan_period = 0.05;
  written.lidar.vehicle_box = {Eigen::Vector3d(-1.5, -0.5, -1), Eigen::Vector3d(0.25, 0.5, 0.1)};
  written.update.hit = 1.5;
  written.localization.gate.memory = 17;
  Parameters read;
  read_parameters(make("parameters.yaml", to_yaml(written)), read);
  EXPECT_EQ(to_yaml(read), to_yaml(written));
  EXPECT_EQ(read.lidar.vehicle_box.min(), written.lidar.vehicle_box.min());
  EXPECT_EQ(read.lidar.vehicle_box.max(), written.lidar.vehicle_box.max());
  EXPECT_NE(to_yaml(read), to_yaml(Parameters{}));
}

TEST_F(ParametersFileTest, EveryParameterStandsOnALineWithItsDefaultAndMeaning) {
  std::istringstream lines(to_yaml(Parameters{}));
  int parameters = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.front() != ' ') continue;
    ++parameters;
    EXPECT_NE(line.find("# "), std::string::npos) << line;
    EXPECT_NE(line.find("default "), std::string::npos) << line;
    EXPECT_GT(line.size() - line.find(": ", line.find("default ")), 10U) << line;
  }
  EXPECT_GT(parameters, 40);
}

TEST_F(ParametersFileTest, MistakesAreNamedWithTheirLine) {
  refuses("lidar:\n  max_rang: 60\n", "line 2", "max_rang");
  refuses("lidra:\n  max_range: 60\n", "line 1", "lidra");
  refuses("lidar:\n  max_range: 60\n  max_range: 70\n", "line 3", "max_range");
  refuses("lidar:\n  max_range: far\n", "line 2", "max_range");
  refuses("lidar:\n  vehicle_box: [1, 2, 3]\n", "line 2", "vehicle_box");
  refuses("update:\n  hit: 1e308\n", "line 2", "hit");
  refuses("update:\n  hit: .nan\n", "line 2", "hit");
  refuses("update:\n  forgetting: 1.1\n", "line 2", "forgetting");
  refuses("update:\n  confirmations: 2.5\n", "line 2", "confirmations");
  refuses("update:\n  confirmations: 0\n", "line 2", "confirmations");
  refuses("update:\n  trim_leaves: perhaps\n", "line 2", "trim_leaves");
  refuses("update:\n  impact: equation6\n", "line 2", "closest_approach");
  refuses("- a\n- b\n", "line 1", "");
  refuses("lidar: [1, 2]\n", "line 1", "lidar");
}

}  // namespace
}  // namespace evermap
