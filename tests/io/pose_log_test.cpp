// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <optional>

#include "files/file_fixture.hpp"
#include <evermap/io/detail/pose_log.hpp>

namespace evermap {
namespace {

class PoseLogTest : public FileTest {
 protected:
  static std::vector<StampedPose> trajectory(int poses) {
    std::vector<StampedPose> result;
    for (int i = 0; i < poses; ++i)
      result.push_back({0.1 * i, {Eigen::Matrix3d::Identity(), {1.0 * i, 0, 0}}});
    return result;
  }
  std::string rows(int poses) {
    write_tum_poses(path("expected.txt"), trajectory(poses));
    return content(path("expected.txt"));
  }
};

TEST_F(PoseLogTest, HasEveryPoseAsItCameAndGoesWhenTheRunIsOver) {
  make("poses.txt", "of the run before");
  PoseLog log(path("poses.txt"));
  EXPECT_EQ(log.path(), path("poses.txt.part"));
  for (const int poses : {0, 1, 2, 2, 7}) {
    log.extend(trajectory(poses));
    log.sync();
    EXPECT_EQ(content(log.path()), poses == 0 ? "" : rows(poses));
    EXPECT_EQ(content(path("poses.txt")), "of the run before");
  }
  log.discard();
  EXPECT_FALSE(std::filesystem::exists(log.path()));
}

TEST_F(PoseLogTest, StaysWhereARunEndedByAnErrorUnlessThereIsNothingInIt) {
  std::optional<PoseLog> log(path("poses.txt"));
  log->extend(trajectory(3));
  log.reset();
  EXPECT_EQ(content(path("poses.txt.part")), rows(3));
  log.emplace(path("poses.txt"));
  EXPECT_EQ(content(path("poses.txt.part")), "");
  log.reset();
  EXPECT_FALSE(std::filesystem::exists(path("poses.txt.part")));
}

TEST_F(PoseLogTest, WhatCannotBeWrittenIsSaid) {
  file_error(path("none/poses.txt.part"), "No such file", [&] { PoseLog log(path("none/poses.txt")); });
  std::filesystem::create_symlink("/dev/full", path("full.txt.part"));
  PoseLog full(path("full.txt"));
  file_error(path("full.txt.part"), "No space left", [&] { full.extend(trajectory(1)); });
}

}  // namespace
}  // namespace evermap
