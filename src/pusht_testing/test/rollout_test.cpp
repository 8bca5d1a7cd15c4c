// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/rollout.hpp"

#include <gtest/gtest.h>

#include "pusht_task/constants.hpp"
#include "pusht_testing/toy_world.hpp"

namespace pusht {
namespace {

/// A rollout that is read back is the one that took place, its latch included.
TEST(Rollout, IsWholeInItsTrace) {
  ToyWorld world;
  WorldState solved;
  solved.pusher_position = {0.2, 0.2};
  Rollout rollout = begin(world, solved);
  for (int step = 0; step < kSuccessHold + 2; ++step) {
    const Rollout again(rollout.trace());
    EXPECT_EQ(again.steps(), rollout.steps());
    EXPECT_EQ(again.success(), rollout.success());
    EXPECT_EQ(again.trace().states, rollout.trace().states);
    advance(rollout, world, {-0.1F, 0.0F});
  }
  EXPECT_TRUE(rollout.success());
}

TEST(Rollout, HasTheActionsThatItsWorldGot) {
  ToyWorld world;
  Rollout rollout = begin(world, WorldState());
  advance(rollout, world, {10.0F * kActionLimit, -0.5F * kActionLimit});
  EXPECT_EQ(rollout.trace().actions.front(), (Action{kActionLimit, -0.5F * kActionLimit}));
}

}  // namespace
}  // namespace pusht
