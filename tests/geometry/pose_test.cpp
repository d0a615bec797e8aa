// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>
#include <support/random_geometry.hpp>

#include <gtest/gtest.h>

#include <evermap/geometry/pose.hpp>

namespace evermap {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector3d;
using test::Random;

const double kPi = std::acos(-1.0);

Matrix4d homogeneous(const Pose& pose) {
  Matrix4d T = Matrix4d::Identity();
  T.topLeftCorner<3, 3>() = pose.rotation;
  T.topRightCorner<3, 1>() = pose.translation;
  return T;
}

/// The power series of the matrix exponential, with scaling and squaring, in long double.
Matrix4d exponential(const Twist& twist) {
  using Matrix = Eigen::Matrix<long double, 4, 4>;
  Matrix X = Matrix::Zero();
  const Eigen::Matrix<long double, 6, 1> t = twist.cast<long double>();
  X << 0, -t[5], t[4], t[0], t[5], 0, -t[3], t[1], -t[4], t[3], 0, t[2], 0, 0, 0, 0;
  X /= 1024;
  Matrix sum = Matrix::Identity();
  Matrix term = Matrix::Identity();
  for (int i = 1; i < 30; ++i) {
    term = term * X / static_cast<long double>(i);
    sum += term;
  }
  for (int i = 0; i < 10; ++i) sum = sum * sum;
  return sum.cast<double>();
}

Twist twist_of(const Vector3d& translation, const Vector3d& rotation) {
  Twist twist;
  twist << translation, rotation;
  return twist;
}

Pose random_pose(Random& random) { return {random.rotation(), random.in_cube(100)}; }

/// Angles from nothing to just below pi, crowded at both ends and around the switch to the series.
double random_angle(Random& random) {
  switch (random.integer(0, 3)) {
    case 0:
      return random.uniform(0, kPi);
    case 1:
      return random.log_uniform(1e-12, 1);
    case 2:
      return random.uniform(0.5e-4, 2e-4);
    default:
      return kPi - random.log_uniform(1e-7, 0.1);
  }
}

TEST(PoseExp, EqualsTheMatrixExponential) {
  Random random(1);
  for (int i = 0; i < 5000; ++i) {
    const Vector3d translation = random.in_cube(10);
    const Twist twist = twist_of(translation, random_angle(random) * random.direction());
    EXPECT_LE((homogeneous(exp(twist)) - exponential(twist)).norm(), 1e-11) << twist.transpose();
  }
  EXPECT_EQ(homogeneous(exp(Twist::Zero())), Matrix4d::Identity());
}

TEST(PoseExp, IsARotation) {
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const Twist twist = twist_of(Vector3d::Zero(), random_angle(random) * random.direction());
    EXPECT_TRUE(is_rotation(exp(twist).rotation, 1e-14));
  }
}

/// A hundred metres of translation: the errors of the rotational factors show.
TEST(PoseLog, UndoesExp) {
  Random random(3);
  double worst_translation = 0, worst_rotation = 0, worst_angle = 0;
  for (int i = 0; i < 20000; ++i) {
    const double angle = random_angle(random);
    const Twist twist = twist_of(100 * random.direction(), angle * random.direction());
    const Twist found = log(exp(twist));
    const double error = (found - twist).head<3>().norm();
    if (error > worst_translation) {
      worst_translation = error;
      worst_angle = angle;
    }
    worst_rotation = std::max(worst_rotation, (found - twist).tail<3>().norm());
  }
  EXPECT_LE(worst_rotation, 1e-13);
  EXPECT_LE(worst_translation, 1e-10) << "[m] of 100 m, at an angle of " << worst_angle << " rad";
}

TEST(PoseLog, NearlyHalfATurn) {
  Random random(4);
  for (const double short_of : {1e-2, 1e-5, 1e-8, 1e-12}) {
    for (int i = 0; i < 200; ++i) {
      const Twist twist = twist_of(random.in_cube(10), (kPi - short_of) * random.direction());
      EXPECT_LE((log(exp(twist)) - twist).norm(), 1e-12) << short_of;
    }
  }
}

/// Exactly pi has two logarithms; either gives the pose back.
TEST(PoseLog, HalfATurn) {
  for (const Vector3d& diagonal : {Vector3d(1, -1, -1), Vector3d(-1, 1, -1), Vector3d(-1, -1, 1)}) {
    const Pose pose{diagonal.asDiagonal(), Vector3d(1, 2, 3)};
    const Twist twist = log(pose);
    EXPECT_NEAR(twist.tail<3>().norm(), kPi, 1e-15);
    EXPECT_LE((homogeneous(exp(twist)) - homogeneous(pose)).norm(), 1e-14);
  }
}

TEST(PoseLog, ExpUndoesLog) {
  Random random(5);
  for (int i = 0; i < 5000; ++i) {
    const Pose pose = random_pose(random);
    EXPECT_LE((homogeneous(exp(log(pose))) - homogeneous(pose)).norm(), 1e-11);
  }
  EXPECT_EQ(log(Pose{}).norm(), 0);
}

TEST(Pose, ComposesLikeMatrices) {
  Random random(6);
  for (int i = 0; i < 1000; ++i) {
    const Pose T_a_b = random_pose(random);
    const Pose T_b_c = random_pose(random);
    const Vector3d p_c = random.in_cube(10);
    EXPECT_LE((homogeneous(T_a_b * T_b_c) - homogeneous(T_a_b) * homogeneous(T_b_c)).norm(), 1e-12);
    EXPECT_LE((T_a_b * (T_b_c * p_c) - (T_a_b * T_b_c) * p_c).norm(), 1e-12);
  }
}

TEST(Pose, InverseUndoes) {
  Random random(7);
  for (int i = 0; i < 1000; ++i) {
    const Pose pose = random_pose(random);
    EXPECT_LE((homogeneous(pose.inverse() * pose) - Matrix4d::Identity()).norm(), 1e-12);
    EXPECT_LE((homogeneous(pose * pose.inverse()) - Matrix4d::Identity()).norm(), 1e-12);
  }
}

TEST(IsRotation, RefusesWhatIsNone) {
  Random random(8);
  const Matrix3d R = random.rotation();
  EXPECT_TRUE(is_rotation(R, 1e-12));
  EXPECT_FALSE(is_rotation(1.001 * R, 1e-3));
  EXPECT_TRUE(is_rotation(1.001 * R, 3e-3));
  EXPECT_FALSE(is_rotation(-R, 1e-3));  // a reflection
  EXPECT_FALSE(is_rotation(Matrix3d::Zero(), 0.5));
  Matrix3d broken = R;
  broken(1, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(is_rotation(broken, 1e9));
  broken(1, 2) = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(is_rotation(broken, 1e9));
}

TEST(NearestRotation, IsItselfForARotation) {
  Random random(9);
  for (int i = 0; i < 1000; ++i) {
    const Matrix3d R = random.rotation();
    EXPECT_LE((nearest_rotation(R) - R).norm(), 1e-14);
    EXPECT_LE((nearest_rotation(3 * R) - R).norm(), 1e-14);
  }
}

TEST(NearestRotation, NoRotationIsNearer) {
  Random random(10);
  for (int i = 0; i < 500; ++i) {
    Matrix3d M;
    M << random.normal3(), random.normal3(), random.normal3();  // half of them left-handed
    const Matrix3d nearest = nearest_rotation(M);
    EXPECT_TRUE(is_rotation(nearest, 1e-12));
    const double distance = (M - nearest).norm();
    for (int k = 0; k < 20; ++k) {
      EXPECT_GE((M - random.rotation()).norm(), distance - 1e-12);
      const Pose turn = exp(twist_of(Vector3d::Zero(), 1e-3 * random.direction()));
      EXPECT_GE((M - turn.rotation * nearest).norm(), distance - 1e-12);
    }
  }
}

}  // namespace
}  // namespace evermap
