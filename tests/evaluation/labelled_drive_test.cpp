// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <support/random_geometry.hpp>
#include <support/reference_drive_score.hpp>

#include <gtest/gtest.h>

namespace evermap {
namespace {

using test::Random;
using test::ReferenceDriveScore;
using Motion = LabelledBox::Motion;

const char* name_of(PointClass kind) {
  switch (kind) {
    case PointClass::kStatic:
      return "static";
    case PointClass::kParked:
      return "parked";
    case PointClass::kMoving:
      return "moving";
    case PointClass::kExcluded:
      return "excluded";
  }
  return "";
}

PointClass class_of(const Eigen::Vector3d& p, const std::vector<LabelledBox>& boxes) {
  Scan scan;
  scan.p_sensor = {p};
  return classify(scan, boxes).at(0);
}

/// Boxes that overlap more often than those of a street, so that their order matters.
std::vector<LabelledBox> random_boxes(Random& random) {
  std::vector<LabelledBox> boxes;
  for (int i = random.integer(0, 8); i > 0; --i) {
    boxes.push_back({random.in_cube(8),
                     {random.uniform(0.1, 6), random.uniform(0.1, 3), random.uniform(0.1, 3)},
                     random.uniform(-7, 7),
                     static_cast<Motion>(random.integer(-1, 1))});
  }
  return boxes;
}

/// Points all around, half of them in and just outside of the boxes.
Scan random_scan(const std::vector<LabelledBox>& boxes, Random& random) {
  Scan scan;
  for (int i = 0; i < 200; ++i) scan.p_sensor.push_back(random.in_cube(10));
  for (int i = 0; i < 200 && !boxes.empty(); ++i) {
    const auto at = static_cast<std::size_t>(random.integer(0, static_cast<int>(boxes.size()) - 1));
    const LabelledBox& box = boxes[at];
    const Eigen::AngleAxisd turn(box.yaw, Eigen::Vector3d::UnitZ());
    scan.p_sensor.emplace_back(box.center_sensor + turn * box.size.cwiseProduct(random.in_cube(0.7)));
  }
  return scan;
}

/// A map that claims every other cube of space.
bool claims_chequered(const Eigen::Vector3d& p_map) {
  const Eigen::Vector3d cube = p_map.array().floor();
  return std::fmod(std::abs(cube.sum()), 2) == 1;
}

void expect_equal(const DriveScore::Fraction& fraction, std::size_t points, std::size_t claimed) {
  EXPECT_EQ(fraction.points, points);
  EXPECT_EQ(fraction.claimed, claimed);
}

TEST(LabelledDrive, ScoresAsItsDescriptionSays) {
  Random random(1);
  DriveScore score;
  ReferenceDriveScore reference;
  for (int i = 0; i < 200; ++i) {
    const std::vector<LabelledBox> boxes = random_boxes(random);
    const Scan scan = random_scan(boxes, random);
    Twist twist;
    for (int k = 0; k < 6; ++k) twist[k] = random.uniform(-3, 3);
    const bool is_last = i >= 150;
    add_to_score(score, scan, exp(twist), boxes, is_last, claims_chequered);
    reference.add(scan, exp(twist), boxes, is_last, claims_chequered);
    const std::vector<PointClass> classes = classify(scan, boxes);
    for (std::size_t k = 0; k < classes.size(); ++k) {
      ASSERT_EQ(name_of(classes[k]), ReferenceDriveScore::kind_of(scan.p_sensor[k], boxes));
    }
  }
  expect_equal(score.all_static, reference.static_points, reference.static_claimed);
  expect_equal(score.seen_static, reference.seen_points, reference.seen_claimed);
  expect_equal(score.parked, reference.parked_points, reference.parked_claimed);
  expect_equal(score.moving, reference.moving_points, reference.moving_claimed);
  for (const auto& fraction : {score.all_static, score.seen_static, score.parked, score.moving}) {
    EXPECT_GT(fraction.points, 1000U);
    EXPECT_NEAR(fraction.value(), 0.5, 0.1);
  }
}

TEST(LabelledDrive, BoxesAreGrownByTheLabelsNoise) {
  const LabelledBox box{{10, 0, 0}, {4, 2, 2}, M_PI / 2, Motion::kParked};  // its length lies along y
  EXPECT_EQ(class_of({10, 2.09, 0}, {box}), PointClass::kParked);
  EXPECT_EQ(class_of({10, 2.11, 0}, {box}), PointClass::kStatic);
  EXPECT_EQ(class_of({11.09, 0, 0}, {box}), PointClass::kParked);
  EXPECT_EQ(class_of({11.11, 0, 0}, {box}), PointClass::kStatic);
  EXPECT_EQ(class_of({10, 0, -1.09}, {box}), PointClass::kParked);
  EXPECT_EQ(class_of({10, 0, 1.11}, {box}), PointClass::kStatic);
}

TEST(LabelledDrive, TheGroundUnderAMoverIsExcluded) {
  const LabelledBox box{{10, 0, 0}, {4, 2, 2}, 0, Motion::kMoving};
  EXPECT_EQ(class_of({10, 0, -1.05}, {box}), PointClass::kExcluded);
  EXPECT_EQ(class_of({10, 0, -0.86}, {box}), PointClass::kExcluded);
  EXPECT_EQ(class_of({10, 0, -0.84}, {box}), PointClass::kMoving);
  const LabelledBox parked{{10, 0, 0}, {4, 2, 2}, 0, Motion::kParked};
  EXPECT_EQ(class_of({10, 0, -1.05}, {parked}), PointClass::kParked);
}

TEST(LabelledDrive, TheVehicleItselfAndUncertainBoxesAreExcluded) {
  EXPECT_EQ(class_of({2.4, 0, 0}, {}), PointClass::kExcluded);
  EXPECT_EQ(class_of({2.6, 0, 0}, {}), PointClass::kStatic);
  const LabelledBox uncertain{{10, 0, 0}, {4, 2, 2}, 0, Motion::kUncertain};
  const LabelledBox parked{{10, 0, 0}, {4, 2, 2}, 0, Motion::kParked};
  const LabelledBox moving{{10, 0, 0}, {4, 2, 2}, 0, Motion::kMoving};
  EXPECT_EQ(class_of({10, 0, 0}, {parked, uncertain}), PointClass::kExcluded);
  EXPECT_EQ(class_of({10, 0, 0}, {moving, parked}), PointClass::kMoving);
}

/// What the README's headline is made of, by hand.
TEST(LabelledDrive, AccuraciesAreThoseOfStaticKeptAndMovingRemoved) {
  const LabelledBox moving{{10, 0, 0}, {4, 2, 2}, 0, Motion::kMoving};
  Scan scan;
  scan.p_sensor = {{5, 0, 0}, {0, 5, 0}, {-5, 0, 0}, {20, 0, 0}, {10, 0, 0}, {9, 0, 0}};
  const auto claim = [](const Eigen::Vector3d& p) { return p.x() < 9.5; };  // one static, one mover lost
  DriveScore score;
  add_to_score(score, scan, {}, {moving}, false, claim);
  expect_equal(score.all_static, 4, 3);
  expect_equal(score.seen_static, 2, 1);
  expect_equal(score.moving, 2, 1);
  EXPECT_EQ(score.removed(), 0.5);
  EXPECT_DOUBLE_EQ(score.associated_accuracy(), std::sqrt(0.75 * 0.5));
  EXPECT_DOUBLE_EQ(score.harmonic_accuracy(), 2 * 0.75 * 0.5 / (0.75 + 0.5));
  add_to_score(score, scan, {}, {moving}, true, claim);  // the last scans' movers are still there
  expect_equal(score.all_static, 8, 6);
  expect_equal(score.moving, 2, 1);
}

}  // namespace
}  // namespace evermap
