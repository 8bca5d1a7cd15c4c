// SPDX-License-Identifier: BSD-3-Clause
// Contract of every BatchSimulator. What a world does is the business of the suite of worlds: here each lane is held
// against a world, bit for bit.
#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pusht_task/batch_simulator.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/simulator.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_testing/bits.hpp"
#include "pusht_testing/kind_suites.hpp"
#include "pusht_testing/long_tests.hpp"
#include "pusht_testing/refusal.hpp"
#include "pusht_testing/scenarios.hpp"

namespace pusht::testing {
namespace {

/// SIMD lanes come in groups of 4, 8 or 16: less than a group, one or two that are full, some that are not.
constexpr std::array<int, 4> kLaneCounts = {1, 3, 8, 19};

constexpr int kNone = -1;  // lane
constexpr int kFewSteps = 20;
int manySteps() { return longTests() ? 2 * kHorizon : kHorizon / 2; }

/// Lanes, each in a moving state of its own, and the worlds that they must be.
struct Lockstep {
  std::unique_ptr<BatchSimulator> lanes;
  std::vector<std::unique_ptr<Simulator>> worlds;
  std::vector<std::optional<Action>> actions;  // of the next step

  int size() const { return static_cast<int>(worlds.size()); }

  void reset(int lane, const WorldState& start) {
    lanes->reset(lane, start);
    worlds[lane]->reset(start);
  }

  /// Steps lanes and worlds with `actions`; the world of lane `but` is left out.
  void step(int but = kNone) {
    lanes->step(actions);
    for (int lane = 0; lane < size(); ++lane) {
      if (actions[lane] && lane != but) {
        worlds[lane]->step(*actions[lane]);
      }
    }
  }

  void stepAll(const Action& action) {
    actions.assign(actions.size(), action);
    step();
  }

  /// The first lane that is not as its world, if one is not; `but` is left out.
  int different(int but = kNone) const {
    for (int lane = 0; lane < size(); ++lane) {
      if (lane != but && !sameBits(lanes->state(lane), worlds[lane]->state())) {
        return lane;
      }
    }
    return kNone;
  }
};

Lockstep inLockstep(const SimulatorModel& model, int lanes) {
  Lockstep both;
  both.lanes = model.make_lanes(lanes);
  both.actions.resize(lanes);
  for (int lane = 0; lane < lanes; ++lane) {
    both.worlds.push_back(model.make_world());
    both.reset(lane, movingState(lane));
  }
  return both;
}

/// Every lane but one does as its world for some steps, whatever becomes of that one.
void expectTheOthersGoOn(Lockstep& both, int but, const std::optional<Action>& action_of_that_one) {
  for (int step = 0; step < kFewSteps; ++step) {
    for (int lane = 0; lane < both.size(); ++lane) {
      both.actions[lane] = lane == but ? action_of_that_one : mixedAction(both.worlds[lane]->state(), lane, step);
    }
    both.step(but);
    ASSERT_EQ(both.different(but), kNone);
  }
}

}  // namespace

void BatchSimulatorSuite::SetUpTestSuite() {}

TEST_P(BatchSimulatorSuite, HasTheLanesThatWereAskedFor) {
  for (const int lanes : kLaneCounts) {
    EXPECT_EQ(makeLanes(lanes)->lanes(), lanes);
  }
}

/// In many states and contacts; lanes pause and begin again, each in its own time.
TEST_P(BatchSimulatorSuite, EveryLaneIsAWorldBitForBit) {
  for (const int lanes : kLaneCounts) {
    Lockstep both = inLockstep(model(), lanes);
    ASSERT_EQ(both.different(), kNone) << "after the reset";
    for (int step = 0; step < manySteps(); ++step) {
      for (int lane = 0; lane < lanes; ++lane) {
        if ((step + lane) % 101 == 100) {
          both.reset(lane, spawn(1000 * step + lane));
        }
        both.actions[lane].reset();
        if ((step + 3 * lane) % 23 != 0) {
          both.actions[lane] = mixedAction(both.worlds[lane]->state(), lane, step);
        }
      }
      both.step();
      ASSERT_EQ(both.different(), kNone) << lanes << " lanes, step " << step;
    }
  }
}

TEST_P(BatchSimulatorSuite, ALaneThatWasResetIsAsFresh) {
  Lockstep used = inLockstep(model(), 3);
  for (int step = 0; step < 40; ++step) {
    for (int lane = 0; lane < used.size(); ++lane) {
      used.actions[lane] = chase(used.worlds[lane]->state());
    }
    used.step();
  }
  const auto fresh = makeLanes(1);
  fresh->reset(0, spawn(3));
  used.lanes->reset(1, spawn(3));
  for (int step = 0; step < 40; ++step) {
    const Action action = chase(fresh->state(0));
    fresh->step(std::vector<std::optional<Action>>{action});
    used.lanes->step(std::vector<std::optional<Action>>{action, action, action});
    ASSERT_TRUE(sameBits(used.lanes->state(1), fresh->state(0))) << "step " << step;
  }
}

TEST_P(BatchSimulatorSuite, ALaneWithoutAnActionStaysAsItIs) {
  Lockstep both = inLockstep(model(), 5);
  const WorldState paused = both.lanes->state(2);
  expectTheOthersGoOn(both, 2, std::nullopt);
  EXPECT_TRUE(sameBits(both.lanes->state(2), paused));
  both.lanes->step(std::vector<std::optional<Action>>(5));
  both.stepAll({0.5F, -0.5F});
  EXPECT_EQ(both.different(), kNone) << "after a step of no lane, and one of all";
}

TEST_P(BatchSimulatorSuite, ALaneHasNoStateBeforeItsReset) {
  const auto lanes = makeLanes(2);
  lanes->reset(0, spawn(3));
  EXPECT_NO_THROW(lanes->state(0));
  EXPECT_THROW(lanes->state(1), InvalidInput);
  lanes->step(std::vector<std::optional<Action>>(2, Action{1.0F, 0.0F}));
  EXPECT_NO_THROW(lanes->state(0));
  EXPECT_THROW(lanes->state(1), InvalidInput) << "a step is no reset";
  lanes->reset(1, spawn(4));
  EXPECT_NO_THROW(lanes->state(1));
}

TEST_P(BatchSimulatorSuite, ActionsAreClipped) {
  if (!task().action_limit) {
    GTEST_SKIP() << "the task " << task().name << " has no limit";
  }
  const auto lanes = makeLanes(2);
  lanes->reset(0, spawn(3));
  lanes->reset(1, spawn(3));
  const std::vector<std::optional<Action>> actions = {Action{1.0F, -1.0F}, Action{17.0F, -1.5F}};
  for (int step = 0; step < 5; ++step) {
    lanes->step(actions);
    EXPECT_TRUE(sameBits(lanes->state(0), lanes->state(1))) << "step " << step;
  }
}

TEST_P(BatchSimulatorSuite, AnActionThatIsNotFiniteStopsItsLaneAlone) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), -std::numeric_limits<float>::infinity()}) {
    Lockstep both = inLockstep(model(), 5);
    expectTheOthersGoOn(both, 1, Action{0.0F, bad});
    EXPECT_THROW(both.lanes->state(1), InvalidInput);
    expectTheOthersGoOn(both, 1, Action{0.0F, 0.0F});
    EXPECT_THROW(both.lanes->state(1), InvalidInput) << "until it is reset";
    both.reset(1, spawn(3));
    both.stepAll({0.5F, 0.5F});
    EXPECT_EQ(both.different(), kNone);
  }
}

/// F21: what becomes of an absurd state is what becomes of it in a world, the error included.
TEST_P(BatchSimulatorSuite, AFaultIsThatOfAWorldAndStopsItsLaneAlone) {
  for (const WorldState& start : absurdStates()) {
    Lockstep both = inLockstep(model(), 5);
    const auto world = makeWorld();
    std::string fault = refusalOf<Error>([&] { world->reset(start); });
    refusalOf<Error>([&] { both.lanes->reset(1, start); });
    for (const Action& action : {Action{0.0F, 0.0F}, Action{1.0F, 0.0F}}) {
      if (fault == kNotRefused) {
        fault = refusalOf<Error>([&] {
          for (int step = 0; step < kFewSteps; ++step) {
            world->step(action);
          }
        });
      }
      expectTheOthersGoOn(both, 1, action);
      EXPECT_EQ(refusalOf<Error>([&] { both.lanes->state(1); }), fault) << "the first one, for good";
    }
    if (fault == kNotRefused) {
      EXPECT_TRUE(sameBits(both.lanes->state(1), world->state()));
    }
    both.reset(1, spawn(3));
    both.stepAll({0.5F, 0.5F});
    EXPECT_EQ(both.different(), kNone) << "after a reset it goes on with the others";
  }
}

TEST_P(BatchSimulatorSuite, RefusedStartsLeaveALaneAsItWas) {
  std::vector<WorldState> bad(2, spawn(3));
  bad[0].tee_yaw_rate = std::numeric_limits<double>::quiet_NaN();
  bad[1].pusher_position.x() = std::numeric_limits<double>::infinity();
  for (const WorldState& start : statesBeyondWhatIsPlausible()) {
    bad.push_back(start);
  }
  Lockstep both = inLockstep(model(), 3);
  const auto untouched = makeLanes(2);
  for (const WorldState& start : bad) {
    EXPECT_THROW(both.lanes->reset(1, start), InvalidInput);
    EXPECT_EQ(both.different(), kNone);
    EXPECT_THROW(untouched->reset(1, start), InvalidInput);
    EXPECT_THROW(untouched->state(1), InvalidInput) << "not reset yet";
  }
  both.stepAll({0.5F, 0.5F});
  EXPECT_EQ(both.different(), kNone);
}

}  // namespace pusht::testing
