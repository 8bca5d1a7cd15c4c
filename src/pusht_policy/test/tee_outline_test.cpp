// SPDX-License-Identifier: BSD-3-Clause
#include "../src/tee_outline.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace pusht {
namespace {

using Eigen::Vector2d;

constexpr double kRoom = 0.005;  // [m]

bool everywhere(const Vector2d& /*point*/) { return true; }

TEST(TeeOutline, GapIsTheDistanceBetweenPusherAndTee) {
  const TeeOutline outline{Physics()};
  EXPECT_NEAR(outline.gap({0.0, 0.04}), 0.01, 1e-12) << "above the bar";
  EXPECT_NEAR(outline.gap({0.03, -0.08}), 0.0, 1e-12) << "touching the stem";
  EXPECT_NEAR(outline.gap({0.09, 0.055}), 0.035, 1e-12) << "off a corner: 3, 4, 5";
  EXPECT_NEAR(outline.gap({0.0, 0.0}), -0.03, 1e-12) << "in the middle of the bar";
}

TEST(TeeOutline, PointsLieOnItAndTheirNormalsPointIn) {
  const TeeOutline outline{Physics()};
  constexpr int kPoints = 97;  // none in a corner
  for (int i = 0; i < kPoints; ++i) {
    const OutlinePoint at = outline.at((i + 0.5) / kPoints);
    EXPECT_NEAR(outline.gap(at.point), -kPusherRadius, 1e-12);
    EXPECT_NEAR(at.inward.norm(), 1.0, 1e-12);
    EXPECT_LT(outline.gap(at.point + 1e-4 * at.inward), outline.gap(at.point));
    EXPECT_EQ(outline.at((i + 0.5) / kPoints - 1.0).inward, at.inward);
  }
}

TEST(TeeOutline, WayIsStraightWhereNothingIsInBetween) {
  const TeeOutline outline{Physics()};
  const Vector2d from(-0.1, 0.05);
  const Vector2d to(0.1, 0.05);
  const std::vector<Vector2d> way = outline.wayAround(from, to, kRoom, everywhere);
  EXPECT_EQ(way, (std::vector<Vector2d>{from, from, to}));
}

TEST(TeeOutline, WayLeadsAroundTheTee) {
  const TeeOutline outline{Physics()};
  const std::vector<Vector2d> way = outline.wayAround({-0.05, -0.07}, {0.05, -0.07}, kRoom, everywhere);
  ASSERT_GT(way.size(), 3U);
  double least = 1.0;
  for (std::size_t i = 1; i < way.size(); ++i) {
    for (int part = 0; part <= 100; ++part) {
      least = std::min(least, outline.gap(way[i - 1] + part / 100.0 * (way[i] - way[i - 1])));
    }
  }
  EXPECT_GT(least, 0.8 * kRoom);
  EXPECT_LT(std::min_element(way.begin(), way.end(), [](auto& a, auto& b) { return a.y() < b.y(); })->y(), -0.12)
      << "below the stem, the shorter way";
}

TEST(TeeOutline, WayMayBeClosed) {
  const TeeOutline outline{Physics()};
  const auto above_the_bar = [](const Vector2d& point) { return point.y() > 0.0; };
  const std::vector<Vector2d> way = outline.wayAround({-0.05, -0.07}, {0.05, -0.07}, kRoom, above_the_bar);
  EXPECT_TRUE(way.empty()) << "the lower corners of bar and stem are not allowed";
}

TEST(TeeOutline, PusherThatTouchesBacksOffFirst) {
  const TeeOutline outline{Physics()};
  const std::vector<Vector2d> way = outline.wayAround({0.0, 0.03}, {0.1, 0.1}, kRoom, everywhere);
  ASSERT_EQ(way.size(), 3U);
  EXPECT_NEAR(way[1].x(), 0.0, 1e-9);
  EXPECT_GE(outline.gap(way[1]), kRoom);
}

}  // namespace
}  // namespace pusht
