// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <nlohmann/json.hpp>

#include "app/program.hpp"

namespace evermap {
namespace {

/// A straight drive along x, one pose a metre and a tenth of a second, `y` [m] beside it.
std::string tum(int poses, double time, double y = 0) {
  std::string text;
  for (int i = 0; i < poses; ++i) {
    text +=
        std::to_string(time + 0.1 * i) + " " + std::to_string(i) + " " + std::to_string(y) + " 0 0 0 0 1\n";
  }
  return text;
}
std::string kitti(int poses, double y = 0) {
  std::string text;
  for (int i = 0; i < poses; ++i) {
    text += "1 0 0 " + std::to_string(i) + " 0 1 0 " + std::to_string(y) + " 0 0 1 0\n";
  }
  return text;
}

class EvaluateTest : public ProgramTest {
 protected:
  nlohmann::json score(const std::string& found, const std::string& truth,
                       const std::vector<std::string>& more = {}) const {
    make("found.txt", found);
    make("truth.txt", truth);
    std::vector<std::string> arguments = {"evaluate", "--trajectory", name("found.txt"), name("truth.txt"),
                                          "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Result result = run(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::json::parse(result.out);
  }
};

TEST_F(EvaluateTest, TrajectoriesWithTimesAreMatchedByTime) {
  const auto json = score(tum(50, 100.101, 0.5), tum(60, 100));
  EXPECT_EQ(json["matched_by"], "time");
  EXPECT_EQ(json["poses"], 50);
  EXPECT_EQ(json["unmatched_found"], 0);
  EXPECT_EQ(json["unmatched_true"], 10);
  EXPECT_NEAR(json["ate_rmse_m"].get<double>(), std::hypot(1, 0.5), 1e-9);  // one scan late
  EXPECT_NEAR(json["ate_max_m"].get<double>(), std::hypot(1, 0.5), 1e-9);
  EXPECT_NEAR(json["ate_rmse_aligned_m"].get<double>(), 0, 1e-9);
  EXPECT_NEAR(json["rotation_rmse_deg"].get<double>(), 0, 1e-9);
  EXPECT_NEAR(json["drift_percent"].get<double>(), 0, 1e-9);
  EXPECT_EQ(json["drift_stretch_m"], 49);
  EXPECT_EQ(json["fraction_lost"], 1);
}

TEST_F(EvaluateTest, TrajectoriesWithoutTimesAreMatchedByOrder) {
  const auto json = score(tum(10, 5, 0.25), kitti(10));
  EXPECT_EQ(json["matched_by"], "order");
  EXPECT_EQ(json["poses"], 10);
  EXPECT_EQ(json["unmatched_found"], 0);
  EXPECT_EQ(json["unmatched_true"], 0);
  EXPECT_NEAR(json["ate_rmse_m"].get<double>(), 0.25, 1e-9);
  EXPECT_EQ(json["fraction_lost"], 0);
}

TEST_F(EvaluateTest, PosesOfAStandingSensorHaveNoDrift) {
  EXPECT_TRUE(score(kitti(1), kitti(1))["drift_percent"].is_null());
}

TEST_F(EvaluateTest, TrajectoriesReadAsALineEach) {
  make("found.txt", kitti(10, 0.25));
  make("truth.txt", kitti(10));
  const Result result = run({"evaluate", "--trajectory", name("found.txt"), name("truth.txt")});
  EXPECT_EQ(result.out,
            "poses      10 matched by order; without a partner: 0 found, 0 true\n"
            "ATE        0.2500 m rms, 0.2500 m at most; 0.0000 m rms after rigid alignment\n"
            "rotation   0.0000 deg rms, 0.0000 deg at most\n"
            "drift      0.000 % over stretches of 9.0 m\n"
            "lost       0.00 % of the poses, more than 1 m or 5 degrees off\n");
}

// Their order says nothing where some are missing, and who knows which.
TEST_F(EvaluateTest, PosesWithoutTimesMustBeAsMany) {
  make("found.txt", tum(9, 100));
  make("truth.txt", kitti(10));
  expect_failed({"evaluate", "--trajectory", name("found.txt"), name("truth.txt")},
                "nothing tells which belong together");
}

TEST_F(EvaluateTest, TimesThatAreAScanApartAreNoticed) {
  make("found.txt", tum(20, 100.1));
  make("truth.txt", tum(21, 100));
  const Result shifted = run({"evaluate", "--trajectory", name("found.txt"), name("truth.txt")});
  EXPECT_NE(shifted.err.find("fit the true ones of the scan before better, 0.0000 m rms"), std::string::npos)
      << shifted.err;
  make("found.txt", tum(20, 100, 0.4));
  EXPECT_EQ(run({"evaluate", "--trajectory", name("found.txt"), name("truth.txt")}).err, "");
}

TEST_F(EvaluateTest, TrajectoriesOfOtherTimesAreRefused) {
  make("found.txt", tum(5, 0));
  make("truth.txt", tum(5, 1000));
  expect_failed({"evaluate", "--trajectory", name("found.txt"), name("truth.txt")},
                "no pose is within 0.02 s of one of");
  EXPECT_EQ(score(tum(5, 0.03), tum(5, 0), {"--max-time-difference", "0.04"})["poses"], 5);
}

TEST_F(EvaluateTest, SaysWhatIsMissing) {
  const Result result = run({"evaluate"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.err.find("MAP.evm, or --trajectory, is required"), std::string::npos) << result.err;
  EXPECT_EQ(run({"evaluate", "a.evm", "scans", "--poses", "p.txt"}).exit_code, 2);
  EXPECT_EQ(run({"evaluate", "a.evm", "--trajectory", "a", "b"}).exit_code, 2);
}

}  // namespace
}  // namespace evermap
