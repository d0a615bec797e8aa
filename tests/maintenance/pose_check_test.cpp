// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <numeric>
#include <string>
#include <support/toy_scene.hpp>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <evermap/maintenance/detail/pose_check.hpp>
#include <evermap/maintenance/map_maintainer.hpp>

namespace evermap {
namespace {

using Eigen::Vector3d;
using Poses = std::vector<Pose>;

/// A drive through boxes, the map that it makes, and mistakes with its poses.
class PoseCheckTest : public ::testing::Test {
 protected:
  PoseCheckTest() {
    MapMaintainer mapper(Octree(VoxelGrid{0.4}), {}, MapMode::kMapping);
    for (int i = 0; i < 24; ++i) {
      const Eigen::AngleAxisd turned(0.3 + 0.06 * i, Vector3d::UnitZ());
      poses_.push_back({turned.toRotationMatrix(), Vector3d(0.7 * i, 0.02 * i * i, 1.5)});
      scans_.push_back(scene_.scan(poses_.back(), 4000, 0.01, random_));
      mapper.process(scans_.back(), poses_.back());
    }
    map_ = mapper.map();
  }

  std::string verdict(const Poses& poses, double contradicting = 0) const {
    PoseCheck check(map_, {}, poses);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      if (check.wants(i)) check.add(i, scans_[i], contradicting);
    }
    return check.verdict();
  }
  /// The same when the scans make a map.
  std::string verdict_of_build(const Poses& poses) const {
    PoseCheck check(Octree(VoxelGrid{0.4}), {}, poses);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      if (check.wants(i)) check.add(i, scans_[i], 0);
    }
    return check.verdict();
  }
  template <class Change>
  Poses changed(Change&& change) const {
    Poses poses = poses_;
    for (Pose& pose : poses) pose = change(pose);
    return poses;
  }
  void expect(const Poses& poses, const std::string& words) const {
    EXPECT_NE(verdict(poses).find(words), std::string::npos) << words << ": " << verdict(poses);
  }

  test::Random random_{7};
  test::ToyScene scene_{0,
                        {{Vector3d(8, -6, 0), Vector3d(9, -2, 3)},
                         {Vector3d(12, 3, 0), Vector3d(15, 5, 2)},
                         {Vector3d(20, -8, 0), Vector3d(21, 9, 4)},
                         {Vector3d(3, 12, 0), Vector3d(14, 13, 3)},
                         {Vector3d(16, 14, 0), Vector3d(17, 25, 3)}}};
  Poses poses_;
  std::vector<Scan> scans_;
  Octree map_{VoxelGrid{0.4}};
};

TEST_F(PoseCheckTest, NothingIsSaidAgainstPosesThatFit) {
  EXPECT_EQ(verdict(poses_), "");
  EXPECT_EQ(verdict(poses_, 0.5), "");  // a map full of ghosts
  EXPECT_EQ(verdict(changed([&](const Pose& pose) {
              return Pose{pose.rotation, pose.translation + random_.in_cube(0.05)};
            })),
            "");
}

TEST_F(PoseCheckTest, ScansThatMakeAMapAreToLieOnEachOther) {
  EXPECT_EQ(verdict_of_build(poses_), "");
  const Pose T_camera_lidar{(Eigen::Matrix3d() << 0, -1, 0, 0, 0, -1, 1, 0, 0).finished(), Vector3d::Zero()};
  const std::string of_camera = verdict_of_build(changed([&](const Pose& pose) {
    return poses_.front() * T_camera_lidar * (poses_.front().inverse() * pose) * T_camera_lidar.inverse();
  }));
  EXPECT_NE(of_camera.find("do not lie on each other"), std::string::npos) << of_camera;
  EXPECT_NE(of_camera.find("of a camera"), std::string::npos) << of_camera;
  const std::string inverse = verdict_of_build(changed([](const Pose& pose) { return pose.inverse(); }));
  EXPECT_NE(inverse.find("give their inverse"), std::string::npos) << inverse;
  EXPECT_EQ(verdict_of_build(Poses(poses_.size(), poses_.front())), "");  // it may have stood
}

TEST_F(PoseCheckTest, NothingIsSaidAgainstADriveBesideTheMap) {
  EXPECT_EQ(verdict(changed([](const Pose& pose) {
              return Pose{pose.rotation, pose.translation + Vector3d(500, 0, 0)};
            })),
            "");
}

TEST_F(PoseCheckTest, MistakesAreNamed) {
  const Pose T_camera_lidar{(Eigen::Matrix3d() << 0, -1, 0, 0, 0, -1, 1, 0, 0).finished(), Vector3d::Zero()};
  expect(changed([&](const Pose& pose) { return pose * T_camera_lidar.inverse(); }), "of a camera");
  expect(changed([&](const Pose& pose) {
           return poses_.front() * T_camera_lidar * (poses_.front().inverse() * pose) *
                  T_camera_lidar.inverse();
         }),
         "of a camera");
  expect(changed([](const Pose& pose) { return pose.inverse(); }), "give their inverse");
  expect(changed([](const Pose& pose) {
           const Eigen::Quaterniond q(pose.rotation);
           return Pose{Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y()).toRotationMatrix(), pose.translation};
         }),
         "begin with w");
  expect(changed([](const Pose& pose) {
           const Eigen::Matrix3d mirror = Vector3d(1, -1, 1).asDiagonal();
           return Pose{mirror * pose.rotation * mirror, mirror * pose.translation};
         }),
         "y axis points the other way");

  Poses shifted = poses_;
  std::rotate(shifted.begin(), shifted.end() - 1, shifted.end());
  expect(shifted, "a scan early or late");
  std::rotate(shifted.begin(), shifted.begin() + 2, shifted.end());
  expect(shifted, "a scan early or late");

  std::vector<std::size_t> by_name(poses_.size());
  std::iota(by_name.begin(), by_name.end(), 0U);
  std::sort(by_name.begin(), by_name.end(),
            [](std::size_t a, std::size_t b) { return std::to_string(a) < std::to_string(b); });
  Poses sorted;
  for (const std::size_t i : by_name) sorted.push_back(poses_[i]);
  expect(sorted, "sorted by name");
}

TEST_F(PoseCheckTest, PosesThatContradictTheMapAreRefusedWithoutACauseToo) {
  const Poses elsewhere = changed([](const Pose& pose) {
    const Eigen::AngleAxisd turned(2.1, Vector3d(0.2, 0.3, 1).normalized());
    return Pose{turned.toRotationMatrix() * pose.rotation, pose.translation + Vector3d(5, 3, 1)};
  });
  EXPECT_EQ(verdict(elsewhere), "");
  EXPECT_NE(verdict(elsewhere, 0.4).find("are poses and map of this drive?"), std::string::npos);
}

}  // namespace
}  // namespace evermap
