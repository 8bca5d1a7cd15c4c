// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/policy_interface.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

#include "pusht_task/constants.hpp"

namespace pusht {
namespace {

using Name = PolicyInterface::Name;
using ::testing::ElementsAre;
using ::testing::FloatNear;
using ::testing::Pointwise;

/// A tee at (200, 100) px that is turned by a quarter, the pusher at (10, 20) px.
constexpr Observation kObservation = {10.0F, 20.0F, 200.0F, 100.0F, 1.0F, 0.0F, 256.0F, 256.0F, 0.7F, 0.7F};

std::vector<float> seenBy(const PolicyInterface& interface, const Observation& observation = kObservation) {
  std::vector<float> seen(static_cast<std::size_t>(interface.numbers()));
  interface.look(observation, seen);
  return seen;
}

TEST(PolicyInterfaces, OfTheCourseIsTheObservation) {
  EXPECT_THAT(seenBy({}), ::testing::ElementsAreArray(kObservation));
}

TEST(PolicyInterfaces, OfStatesHasAnAngleWithinATurn) {
  EXPECT_THAT(seenBy({Name::kGymState}), ElementsAre(10.0F, 20.0F, 200.0F, 100.0F, FloatNear(kPi / 2.0, 1e-6)));
  Observation other_way = kObservation;
  other_way[4] = -1.0F;
  EXPECT_NEAR(seenBy({Name::kGymState}, other_way).back(), 1.5 * kPi, 1e-6);
}

/// A quarter turn takes a corner (x, y) of the tee to (-y, x).
TEST(PolicyInterfaces, OfKeypointsHasTheCornersInGymPushtsOrder) {
  const std::vector<float> corners = {200, 40, 200, 160, 170, 160, 170, 40, 170, 85, 170, 115, 80, 115, 80, 85};
  std::vector<float> agent_last = corners;
  agent_last.insert(agent_last.end(), {10, 20});
  std::vector<float> agent_first = {10, 20};
  agent_first.insert(agent_first.end(), corners.begin(), corners.end());
  EXPECT_THAT(seenBy({Name::kGymKeypoints, 8, false}), Pointwise(FloatNear(1e-4), agent_last));
  EXPECT_THAT(seenBy({Name::kGymKeypoints, 8, true}), Pointwise(FloatNear(1e-4), agent_first));
}

/// The first is (9.27, 90.04) from the tee's origin.
TEST(PolicyInterfaces, OfDiffusionPolicyHasItsNinePoints) {
  const std::vector<float> seen = seenBy({Name::kGymKeypoints, 9, false});
  ASSERT_EQ(seen.size(), 20U);
  EXPECT_NEAR(seen[0], 200.0 - 90.04, 0.01);
  EXPECT_NEAR(seen[1], 100.0 + 9.27, 0.01);
  EXPECT_EQ(seen[18], 10.0F);
}

TEST(PolicyInterfaces, FitTheTasksThatHaveTheirNumbers) {
  EXPECT_THAT(policyInterfacesOf(fullCircle()), ElementsAre("full_circle"));
  EXPECT_THAT(policyInterfacesOf(gymPusht()), ElementsAre("gym_state", "gym_keypoints"));
  Task other = gymPusht();
  other.frame.per_meter = 500.0;
  EXPECT_THAT(policyInterfacesOf(other), ElementsAre()) << "pixels of another size";
  other = gymPusht();
  other.physics.bar_half_length *= 1.5;
  EXPECT_THAT(policyInterfacesOf(other), ElementsAre("gym_state")) << "other corners";
  other = fullCircle();
  other.physics.drive = Drive::kPosition;
  EXPECT_THAT(policyInterfacesOf(other), ElementsAre()) << "positions, not velocities";
}

}  // namespace
}  // namespace pusht
