// SPDX-License-Identifier: BSD-3-Clause
// Contacts against cases that can be worked out by hand.
#include <gtest/gtest.h>

#include <cmath>

#include "rigid_body_testing.hpp"

namespace pusht::rigid_body {
namespace {

constexpr double kTiny = 1e-15;
const Box kBar = kCourseModel.parts[0].box;
const Heading kStraight = {1.0, 0.0};

void expectVector(const Eigen::Vector2d& found, const Eigen::Vector2d& expected, double tolerance = kTiny) {
  EXPECT_NEAR(found.x(), expected.x(), tolerance);
  EXPECT_NEAR(found.y(), expected.y(), tolerance);
}

TEST(TouchNearest, Face) {
  const auto contact = touchNearest({0.02, 0.029}, 0.015, kBar, {0.0, 0.0}, kStraight, 0.0);
  EXPECT_TRUE(contact.touching);
  EXPECT_NEAR(contact.depth, 0.001, kTiny);
  expectVector(contact.normal, {0.0, -1.0});
  expectVector(contact.point, {0.02, 0.0145});
}

TEST(TouchNearest, Corner) {
  const double away = 0.01 / std::sqrt(2.0);
  const auto contact = touchNearest({0.06 + away, 0.015 + away}, 0.015, kBar, {0.0, 0.0}, kStraight, 0.0);
  EXPECT_NEAR(contact.depth, 0.005, kTiny);
  const double half = 1.0 / std::sqrt(2.0);
  expectVector(contact.normal, {-half, -half}, 1e-14);
  expectVector(contact.point, {0.06 + 0.0025 * half * -1.0, 0.015 - 0.0025 * half}, 1e-14);
}

TEST(TouchNearest, CenterInside) {
  const auto contact = touchNearest({0.055, 0.001}, 0.015, kBar, {0.0, 0.0}, kStraight, 0.0);
  EXPECT_NEAR(contact.depth, 0.015 + 0.005, kTiny);
  expectVector(contact.normal, {-1.0, 0.0});
}

TEST(TouchNearest, Apart) {
  EXPECT_FALSE(touchNearest({0.0, 0.0301}, 0.015, kBar, {0.0, 0.0}, kStraight, 0.0).touching);
  EXPECT_TRUE(touchNearest({0.0, 0.0301}, 0.015, kBar, {0.0, 0.0}, kStraight, 0.001).touching) << "within the margin";
}

TEST(TouchNearest, TurnsWithTheTee) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2d place(random(-0.09, 0.09), random(-0.05, 0.05));
    const Eigen::Vector2d moved(random(-0.3, 0.3), random(-0.3, 0.3));
    const Heading heading = headingOf(random(-kPi, kPi));
    const auto here = touchNearest(place, 0.015, kBar, {0.0, 0.0}, kStraight, 0.0);
    const auto there = touchNearest(moved + heading.toTable(place), 0.015, kBar, moved, heading, 0.0);
    EXPECT_NEAR(here.depth, there.depth, 1e-14);
    expectVector(there.normal, heading.toTable(here.normal), 1e-10);
    expectVector(there.point, moved + heading.toTable(here.point), 1e-11);
  }
}

TEST(TouchDiscs, OnTheLineBetweenThem) {
  const auto contact = touchDiscs({0.03, 0.04}, 0.03, {0.0, 0.0}, 0.025, 0.0);
  EXPECT_NEAR(contact.depth, 0.005, kTiny);
  expectVector(contact.normal, {0.6, 0.8});
  expectVector(contact.point, {0.0225 * 0.6, 0.0225 * 0.8});
  EXPECT_FALSE(touchDiscs({0.0, 0.0}, 0.03, {0.0, 0.0}, 0.025, 0.0).touching) << "there is no normal";
}

TEST(TouchWall, IsItsInnerFace) {
  for (const Wall& wall : kCourseModel.walls) {
    Eigen::Vector2d place = {0.1, 0.2};
    place[wall.axis] = wall.side * 0.376;
    const auto contact = touchWall(place, 0.015, wall, 0.0);
    EXPECT_TRUE(contact.touching);
    EXPECT_NEAR(contact.depth, 0.001, kTiny);
    EXPECT_NEAR(contact.point[wall.axis], wall.side * 0.3905, kTiny);
    EXPECT_EQ(contact.normal[wall.axis], -wall.side);
    EXPECT_EQ(contact.normal[1 - wall.axis], 0.0);
  }
}

/// In the middle of a face there is one answer, and the portal finds it to its tolerance.
TEST(TouchPortal, AgreesWithTheNearestPointsOnAFace) {
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const double depth = random(1e-5, 1e-3);
    const Heading heading = headingOf(random(-kPi, kPi));
    const Eigen::Vector2d center(random(-0.2, 0.2), random(-0.2, 0.2));
    const Eigen::Vector2d place = center + heading.toTable({random(-0.05, 0.05), 0.03 - depth});
    const auto nearest = touchNearest(place, 0.015, kBar, center, heading, 0.0);
    const auto portal = touchPortal(place, kPusherRadius, kBar, center, heading);
    ASSERT_TRUE(portal.touching);
    EXPECT_NEAR(portal.depth, nearest.depth, 2e-6);
    EXPECT_GT(portal.normal.dot(nearest.normal), 0.99);
    EXPECT_NEAR(portal.normal.norm(), 1.0, 1e-15);
  }
}

TEST(TouchPortal, HasANormalWhereThePointIsOnThePushersAxis) {
  const auto contact = touchPortal({0.1, 0.1}, kPusherRadius, kBar, {0.1, 0.1}, kStraight);
  ASSERT_TRUE(contact.touching);
  EXPECT_NEAR(contact.normal.norm(), 1.0, 1e-15);
}

TEST(Refine, KeepsTheMarginOfHardContacts) {
  const Eigen::Vector2d place(0.0, 0.0305);  // half a millimeter from the bar
  for (const double margin : {0.0, simple::kMargin}) {
    auto contact = touchNearest(place, 0.015, kBar, {0.0, 0.0}, kStraight, margin);
    refine(place, kPusherRadius, kBar, {0.0, 0.0}, kStraight, contact);
    EXPECT_EQ(contact.touching, margin > 0.0);
  }
}

TEST(TouchPortal, FindsNothingWhereNothingTouches) {
  EXPECT_FALSE(touchPortal({0.0, 0.0301}, kPusherRadius, kBar, {0.0, 0.0}, kStraight).touching);
}

TEST(Impedance, IsMuJoCosCurve) {
  EXPECT_DOUBLE_EQ(impedance(0.0), 0.9);
  EXPECT_DOUBLE_EQ(impedance(0.00025), 0.9 + 0.05 * 0.125);
  EXPECT_DOUBLE_EQ(impedance(0.0005), 0.925);
  EXPECT_DOUBLE_EQ(impedance(0.00075), 0.9 + 0.05 * 0.875);
  EXPECT_DOUBLE_EQ(impedance(0.001), 0.95);
  EXPECT_DOUBLE_EQ(impedance(0.5), 0.95);
}

}  // namespace
}  // namespace pusht::rigid_body
