// SPDX-License-Identifier: BSD-3-Clause
// Contract of every Simulator: what a world does.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <future>
#include <limits>
#include <memory>
#include <vector>

#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/rollout.hpp"
#include "pusht_task/simulator.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_testing/kind_suites.hpp"
#include "pusht_testing/scenarios.hpp"

namespace pusht::testing {

std::vector<WorldState> chaseFrom(Simulator& world, const WorldState& start, int steps) {
  world.reset(start);
  std::vector<WorldState> states = {world.state()};
  for (int i = 0; i < steps; ++i) {
    world.step(chase(states.back(), world.task()));
    states.push_back(world.state());
  }
  return states;
}

void expectNear(const WorldState& a, const WorldState& b, double tolerance) {
  EXPECT_LE((a.pusher_position - b.pusher_position).norm(), tolerance);
  EXPECT_LE((a.pusher_velocity - b.pusher_velocity).norm(), tolerance);
  EXPECT_LE((a.tee_position - b.tee_position).norm(), tolerance);
  EXPECT_LE((a.tee_velocity - b.tee_velocity).norm(), tolerance);
  EXPECT_LE(std::abs(wrapAngle(a.tee_yaw - b.tee_yaw)), tolerance);
  EXPECT_LE(std::abs(a.tee_yaw_rate - b.tee_yaw_rate), tolerance);
}

void SimulatorSuite::SetUpTestSuite() {}

TEST_P(SimulatorSuite, IsAsNearToItsStartAsItsKindSays) { EXPECT_EQ(makeWorld()->startTolerance(), startTolerance()); }

TEST_P(SimulatorSuite, ResetSetsTheStateWithVelocities) {
  const auto world = makeWorld();
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const WorldState wanted = movingState(seed);
    world->reset(wanted);
    expectNear(world->state(), wanted, startTolerance());
  }
}

TEST_P(SimulatorSuite, ResetToItsOwnStateIsAFixedPointBitForBit) {
  const auto world = makeWorld();
  for (std::uint64_t seed = 0; seed < 20000; ++seed) {
    WorldState start = movingState(seed);
    if (seed % 10 == 0) {  // where the yaw wraps
      start.tee_yaw = wrapAngle(kPi + static_cast<double>(seed) * 1e-17);
    }
    world->reset(start);
    const WorldState once = world->state();
    world->reset(once);
    ASSERT_EQ(world->state(), once) << "seed " << seed;
  }
}

TEST_P(SimulatorSuite, AThousandResetsClearAllHiddenState) {
  const auto used = makeWorld();
  chaseFrom(*used, spawn(7), 40);
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    used->reset(movingState(seed));
    used->step({1.0F, -1.0F});
  }
  const auto fresh = makeWorld();
  EXPECT_EQ(chaseFrom(*used, spawn(3), 40), chaseFrom(*fresh, spawn(3), 40));
}

TEST_P(SimulatorSuite, TwoWorldsDoNotShareState) {
  const auto a = makeWorld();
  const auto b = makeWorld();
  const auto alone = chaseFrom(*a, spawn(3), 40);
  a->reset(spawn(3));
  b->reset(spawn(4));
  for (std::size_t i = 0; i + 1 < alone.size(); ++i) {
    a->step(chase(a->state(), task()));
    b->step(chase(b->state(), task()));
    ASSERT_EQ(a->state(), alone[i + 1]);
  }
}

/// Worlds that are made and moved at the same time.
TEST_P(SimulatorSuite, TwoThreadsDoNotShareState) {
  const auto chase_some = [this] {
    const auto world = makeWorld();
    std::vector<std::vector<WorldState>> episodes;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      episodes.push_back(chaseFrom(*world, spawn(seed), 40));
    }
    return episodes;
  };
  const auto alone = chase_some();
  auto other = std::async(std::launch::async, chase_some);
  EXPECT_EQ(chase_some(), alone);
  EXPECT_EQ(other.get(), alone);
}

TEST_P(SimulatorSuite, ChasingMovesTheTee) {
  const auto world = makeWorld();
  const auto states = chaseFrom(*world, spawn(3), 40);
  EXPECT_GT((states.back().tee_position - states.front().tee_position).norm(), 0.02);
}

TEST_P(SimulatorSuite, ActionsAreClipped) {
  if (!task().action_limit) {
    GTEST_SKIP() << "the task " << task().name << " has no limit";
  }
  const auto inside = makeWorld();
  const auto outside = makeWorld();
  inside->reset(spawn(3));
  outside->reset(spawn(3));
  for (int i = 0; i < 5; ++i) {
    inside->step({1.0F, -1.0F});
    outside->step({17.0F, -1.5F});
    EXPECT_EQ(inside->state(), outside->state());
  }
}

TEST_P(SimulatorSuite, RefusesActionsThatAreNotFiniteAndGoesOn) {
  const auto world = makeWorld();
  world->reset(spawn(3));
  const WorldState before = world->state();
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    EXPECT_THROW(world->step({bad, 0.0F}), InvalidInput);
    EXPECT_THROW(world->step({0.0F, -bad}), InvalidInput);
    EXPECT_EQ(world->state(), before);
  }
  const auto undisturbed = makeWorld();
  undisturbed->reset(spawn(3));
  undisturbed->step({0.5F, 0.5F});
  world->step({0.5F, 0.5F});
  EXPECT_EQ(world->state(), undisturbed->state());
}

TEST_P(SimulatorSuite, RefusesStatesThatAreNotFinite) {
  const auto world = makeWorld();
  world->reset(spawn(3));
  const WorldState before = world->state();
  WorldState bad = spawn(3);
  bad.tee_yaw_rate = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(world->reset(bad), InvalidInput);
  EXPECT_EQ(world->state(), before);
}

TEST_P(SimulatorSuite, RefusesStatesBeyondWhatIsPlausible) {
  const auto world = makeWorld();
  world->reset(spawn(3));
  const WorldState before = world->state();
  for (const WorldState& start : statesBeyondWhatIsPlausible()) {
    EXPECT_THROW(world->reset(start), InvalidInput);
    EXPECT_EQ(world->state(), before);
  }
  world->step({0.0F, 0.0F});
}

TEST_P(SimulatorSuite, RefusesAStepBeforeTheFirstReset) { EXPECT_THROW(makeWorld()->step({0.0F, 0.0F}), InvalidInput); }

TEST_P(SimulatorSuite, YawIsWrapped) {
  const auto world = makeWorld();
  WorldState start = spawn(3);
  start.tee_yaw = 3.0 + 10.0 * kPi;
  world->reset(start);
  EXPECT_NEAR(world->state().tee_yaw, 3.0, startTolerance());
}

/// F21: either an error or finite numbers, and a world that can be reset; never silently other data.
TEST_P(SimulatorSuite, AbsurdStatesAreAnErrorOrStayFinite) {
  const auto expected = chaseFrom(*makeWorld(), spawn(3), 10);
  for (const WorldState& start : absurdStates()) {
    const auto world = makeWorld();
    try {
      world->reset(start);
      for (int i = 0; i < 20; ++i) {
        world->step({i % 3 == 0 ? 3e38F : -3e38F, 1.0F});
        ASSERT_TRUE(isFinite(world->state()));
        ASSERT_NE(world->state(), WorldState()) << "reset to the origin on its own";
      }
    } catch (const SimulationFault&) {
      EXPECT_THROW(world->step({0.0F, 0.0F}), InvalidInput) << "a failed world must be reset first";
    }
    EXPECT_EQ(chaseFrom(*world, spawn(3), 10), expected) << "what the absurd state left behind";
  }
}

/// Success latches after the task's steps, and stepping goes on; the world does not know.
TEST_P(SimulatorSuite, LatchAndHorizon) {
  const auto world = makeWorld();
  WorldState solved;
  solved.pusher_position = {0.2, 0.2};
  solved.tee_position = task().target.position;
  solved.tee_yaw = task().target.yaw;
  const int hold = task().success.hold;
  Rollout rollout = begin(*world, solved);
  for (int step = 1; step <= hold + 2; ++step) {
    advance(rollout, *world, actionFor(Eigen::Vector2d::Zero(), solved.pusher_position, task()));
    EXPECT_EQ(rollout.success(), step >= hold);
    EXPECT_EQ(rollout.finished(kHorizon), step >= hold);
    EXPECT_EQ(rollout.finished(3), step >= std::min(hold, 3));
  }
  EXPECT_EQ(rollout.trace().states.size(), rollout.trace().actions.size() + 1);
}

}  // namespace pusht::testing
