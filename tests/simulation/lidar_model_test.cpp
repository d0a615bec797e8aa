// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <evermap/simulation/lidar_model.hpp>

namespace evermap {
namespace {

TEST(LidarModel, BeamsSpanTheFieldOfViewAndTheCircle) {
  const LidarModel lidar;
  constexpr double kHalf = std::numbers::pi / 8;
  EXPECT_EQ(lidar.beams(), 65536);
  EXPECT_TRUE(lidar.direction(0).isApprox(Eigen::Vector3d(std::cos(kHalf), 0, std::sin(kHalf)), 1e-12));
  EXPECT_TRUE(lidar.direction(63).isApprox(Eigen::Vector3d(std::cos(kHalf), 0, -std::sin(kHalf)), 1e-12));
  // A quarter turn later the beam looks to the left, y.
  EXPECT_TRUE(
      lidar.direction(256 * 64).isApprox(Eigen::Vector3d(0, std::cos(kHalf), std::sin(kHalf)), 1e-12));
}

TEST(LidarModel, DirectionsHaveLengthOneAndDiffer) {
  const LidarModel lidar;
  for (int beam = 1; beam < lidar.beams(); beam += 7) {
    EXPECT_NEAR(lidar.direction(beam).norm(), 1, 1e-12);
    EXPECT_GT((lidar.direction(beam) - lidar.direction(beam - 1)).norm(), 1e-3);
  }
}

TEST(LidarModel, ASingleChannelLooksAtTheTopOfItsField) {
  LidarModel lidar;
  lidar.channels = 1;
  lidar.elevation_max = 0;
  EXPECT_TRUE(lidar.direction(0).isApprox(Eigen::Vector3d::UnitX(), 1e-12));
}

}  // namespace
}  // namespace evermap
