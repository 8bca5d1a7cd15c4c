// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/task.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace pusht {
namespace {

TEST(WrapAngle, KeepsTheBitsOfWhatLiesInside) {
  for (const double angle : {0.0, 1e-17, -1e-300, 3.0, -kPi, std::nextafter(kPi, 0.0)}) {
    EXPECT_EQ(wrapAngle(angle), angle);
  }
}

TEST(WrapAngle, IsHalfOpen) {
  EXPECT_EQ(wrapAngle(kPi), -kPi);
  EXPECT_NEAR(wrapAngle(3.0 * kPi), -kPi, 1e-15);
  EXPECT_NEAR(wrapAngle(2.0 * kPi + 0.5), 0.5, 1e-15);
  EXPECT_NEAR(wrapAngle(-2.0 * kPi - 0.5), -0.5, 1e-15);
}

TEST(WrapAngle, StaysInsideForAnyAngle) {
  for (int i = -3000; i < 3000; ++i) {
    const double angle = 0.37 * i;
    const double wrapped = wrapAngle(angle);
    EXPECT_GE(wrapped, -kPi);
    EXPECT_LT(wrapped, kPi);
    EXPECT_EQ(wrapAngle(wrapped), wrapped);
    EXPECT_NEAR(std::cos(wrapped), std::cos(angle), 1e-12);
    EXPECT_NEAR(std::sin(wrapped), std::sin(angle), 1e-12);
  }
}

TEST(Observe, FollowsTheContract) {
  WorldState state;
  state.pusher_position = {0.1, -0.2};
  state.tee_position = {0.3, 0.05};
  state.tee_yaw = 0.7;
  const Observation expected = {
      0.1F, -0.2F, 0.3F, 0.05F, static_cast<float>(std::sin(0.7)), static_cast<float>(std::cos(0.7)),
      0.0F, 0.0F,  0.0F, 1.0F};
  EXPECT_EQ(observe(state), expected);
}

TEST(Clip, LimitsEachAxis) {
  EXPECT_EQ(clip({1.5F, -3.0F}), (Action{1.0F, -1.0F}));
  EXPECT_EQ(clip({0.25F, -1.0F}), (Action{0.25F, -1.0F}));
}

WorldState teeWith(double x, double yaw) {
  WorldState state;
  state.tee_position.x() = x;
  state.tee_yaw = yaw;
  return state;
}

TEST(Success, ToleranceIsStrict) {
  EXPECT_TRUE(isSolved(teeWith(0.0299, 0.1999)));
  EXPECT_FALSE(isSolved(teeWith(kPositionTolerance, 0.0)));
  EXPECT_FALSE(isSolved(teeWith(0.0, kAngleTolerance)));
}

TEST(SuccessLatch, NeedsFiveConsecutiveStepsAndStays) {
  const WorldState inside = teeWith(0.0, 0.0);
  const WorldState outside = teeWith(1.0, 0.0);
  SuccessLatch latch;
  for (int i = 0; i < kSuccessHold - 1; ++i) {
    EXPECT_FALSE(latch.update(inside));
  }
  EXPECT_FALSE(latch.update(outside)) << "the count starts anew";
  for (int i = 0; i < kSuccessHold - 1; ++i) {
    EXPECT_FALSE(latch.update(inside));
  }
  EXPECT_FALSE(latch.latched());
  EXPECT_TRUE(latch.update(inside));
  EXPECT_TRUE(latch.latched());
  EXPECT_FALSE(latch.update(inside)) << "it latches once";
  EXPECT_FALSE(latch.update(outside));
  EXPECT_TRUE(latch.latched());
}

}  // namespace
}  // namespace pusht
