// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/batch_simulator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/rollout.hpp"
#include "pusht_task/spawn.hpp"

namespace pusht {
namespace {

/// Its pusher goes where it is told; it fails beyond x = 0.35 m.
class Glider : public Simulator {
  void doReset(const WorldState& state) override { state_ = state; }
  void doStep(const Action& action) override {
    state_.pusher_position += kControlStep * Eigen::Vector2d(action[0], action[1]);
    if (state_.pusher_position.x() > 0.35) {
      throw RuntimeFault("off the table");
    }
  }
  WorldState doState() const override { return state_; }

  WorldState state_;
};

SimulatorLanes gliders(int count) {
  std::vector<std::unique_ptr<Simulator>> worlds(count);
  std::generate(worlds.begin(), worlds.end(), [] { return std::make_unique<Glider>(); });
  return SimulatorLanes(std::move(worlds));
}

TEST(SimulatorLanes, StepsEachLaneThatHasAnAction) {
  SimulatorLanes lanes = gliders(3);
  ASSERT_EQ(lanes.lanes(), 3);
  for (int lane = 0; lane < 3; ++lane) {
    lanes.reset(lane, WorldState());
  }
  const std::vector<std::optional<Action>> actions = {Action{1.0F, 0.0F}, std::nullopt, Action{0.0F, -5.0F}};
  lanes.step(actions);
  EXPECT_EQ(lanes.state(0).pusher_position, Eigen::Vector2d(0.1, 0.0));
  EXPECT_EQ(lanes.state(1).pusher_position, Eigen::Vector2d(0.0, 0.0));
  EXPECT_EQ(lanes.state(2).pusher_position, Eigen::Vector2d(0.0, -0.1)) << "clipped";
}

TEST(SimulatorLanes, ALaneHasNoStateBeforeItsReset) {
  SimulatorLanes lanes = gliders(2);
  lanes.reset(0, WorldState());
  EXPECT_NO_THROW(lanes.state(0));
  EXPECT_THROW(lanes.state(1), InvalidInput);
}

TEST(SimulatorLanes, TheErrorOfALaneIsItsOwnUntilItIsReset) {
  SimulatorLanes lanes = gliders(2);
  WorldState near_the_edge;
  near_the_edge.pusher_position.x() = 0.3;
  lanes.reset(0, near_the_edge);
  lanes.reset(1, WorldState());
  const std::vector<std::optional<Action>> actions(2, Action{1.0F, 0.0F});
  lanes.step(actions);
  EXPECT_THROW(lanes.state(0), RuntimeFault);
  EXPECT_EQ(lanes.state(1).pusher_position.x(), 0.1);
  lanes.step(actions);
  EXPECT_THROW(lanes.state(0), RuntimeFault) << "still the first error";
  lanes.reset(0, WorldState());
  lanes.step(actions);
  EXPECT_EQ(lanes.state(0).pusher_position.x(), 0.1);
}

/// A rollout that is read back is the one that took place, its latch included.
TEST(Rollout, IsWholeInItsTrace) {
  Glider world;
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

}  // namespace
}  // namespace pusht
