// SPDX-License-Identifier: BSD-3-Clause
// The engine, one world or many, against the plain loop: the same bits.
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "naive_two_mass.hpp"
#include "pusht_engine/two_mass_engine.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/task.hpp"
#include "pusht_task/testing/scenarios.hpp"

namespace pusht {
namespace {

/// Bitwise, so that -0.0 is not 0.0.
template <class T>
bool sameBits(const T& a, const T& b) {
  // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison,cert-exp42-c,cert-flp37-c)
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

/// Chases the tee, so that contacts come and go; every fourth world pushes into it straight, and now and then the
/// pusher is told to stand still.
Action actionFor(const WorldState& state, std::size_t world, int step) {
  if (step % 17 == 16) {
    return {0.0F, 0.0F};
  }
  return world % 4 == 3 ? Action{-1.0F, 0.25F} : testing::chase(state);
}

std::vector<TwoMassParameters> knobSettings() {
  std::vector<TwoMassParameters> settings(4);
  settings[1].block_damp = 1.0;
  settings[2].pusher_mass = 0.5;
  settings[3].baumgarte = 20.0;
  return settings;
}

TEST(TwoMassEngine, IsThePlainLoopBitForBit) {
  int in_contact = 0;
  for (const TwoMassParameters& knobs : knobSettings()) {
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
      TwoMassEngine engine(knobs);
      engine.reset(seed % 2 == 0 ? spawn(seed) : testing::movingState(seed));
      two_mass::Bodies<double> expected = engine.bodies();
      for (int step = 0; step < kHorizon; ++step) {
        const Action action = actionFor(engine.state(), seed, step);
        engine.step(action);
        naive::step(knobs, clip(action), expected);
        ASSERT_TRUE(sameBits(engine.bodies(), expected)) << "seed " << seed << " step " << step;
        in_contact += naive::findContacts(expected.positions).size() == 2 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(in_contact, 500) << "both masses must be touched at once often enough";
}

/// As many lanes as there are in a group, fewer, and more.
TEST(TwoMassLanes, EveryLaneIsAnEngineBitForBit) {
  for (const TwoMassParameters& knobs : knobSettings()) {
    for (const int lanes : {1, two_mass::kLaneCount, 2 * two_mass::kLaneCount + 3}) {
      TwoMassLanes batch(lanes, knobs);
      ASSERT_EQ(batch.lanes(), lanes);
      std::vector<std::unique_ptr<TwoMassEngine>> engines;
      for (int lane = 0; lane < lanes; ++lane) {
        const WorldState start = lane % 2 == 0 ? spawn(lane) : testing::movingState(lane);
        engines.push_back(std::make_unique<TwoMassEngine>(knobs));
        engines.back()->reset(start);
        batch.reset(lane, start);
      }
      std::vector<std::optional<Action>> actions(lanes);
      for (int step = 0; step < 2 * kHorizon; ++step) {
        for (int lane = 0; lane < lanes; ++lane) {
          TwoMassEngine& engine = *engines[lane];
          // Lanes pause and begin again, each in its own time.
          if ((step + lane) % 101 == 100) {
            engine.reset(spawn(1000 * step + lane));
            batch.reset(lane, spawn(1000 * step + lane));
          }
          actions[lane].reset();
          if ((step + 3 * lane) % 23 != 0) {
            actions[lane] = actionFor(engine.state(), lane, step);
            engine.step(*actions[lane]);
          }
        }
        batch.step(actions);
        for (int lane = 0; lane < lanes; ++lane) {
          ASSERT_TRUE(sameBits(batch.state(lane), engines[lane]->state())) << "lane " << lane << " step " << step;
        }
      }
    }
  }
}

TEST(TwoMassLanes, ALaneThatFailsLeavesTheOthersAlone) {
  TwoMassLanes batch(4);
  TwoMassEngine engine;
  engine.reset(spawn(7));
  for (const int lane : {0, 1, 3}) {
    batch.reset(lane, spawn(7));
  }
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<std::optional<Action>> actions = {Action{1.0F, 0.0F}, Action{kNan, 0.0F}, Action{1.0F, 0.0F},
                                                      Action{1.0F, 0.0F}};
  for (int step = 0; step < 10; ++step) {
    batch.step(actions);
    engine.step(*actions[0]);
  }
  EXPECT_TRUE(sameBits(batch.state(0), engine.state()));
  EXPECT_THROW(batch.state(1), InvalidInput) << "an action that is not finite";
  EXPECT_THROW(batch.state(2), InvalidInput) << "never reset";
  EXPECT_TRUE(sameBits(batch.state(3), engine.state()));
  batch.reset(1, spawn(7));
  engine.reset(spawn(7));
  EXPECT_TRUE(sameBits(batch.state(1), engine.state()));
}

TEST(TwoMassLanes, AWorldThatFliesApartIsASimulationFault) {
  TwoMassParameters soft;
  soft.baumgarte = two_mass::kKnobs[2].least;
  WorldState start;
  start.tee_yaw = kPi / 2.0;  // the stem is on +x, and is pushed until the link closes
  start.pusher_position = {-0.05, 0.0};
  start.pusher_velocity = {1.0, 0.0};
  TwoMassLanes batch(2, soft);
  batch.reset(0, start);
  const std::vector<std::optional<Action>> actions = {Action{1.0F, 0.0F}, std::nullopt};
  const auto push = [&] {
    for (int step = 0; step < kHorizon; ++step) {
      batch.step(actions);
      batch.state(0);
    }
  };
  EXPECT_THROW(push(), SimulationFault);
  batch.step(actions);
  EXPECT_THROW(batch.state(0), SimulationFault) << "still the first error";
}

TEST(TwoMassLanes, RefusesKnobsOutOfRange) {
  TwoMassParameters knobs;
  knobs.block_damp = -1.0;
  EXPECT_THROW(TwoMassLanes(8, knobs), InvalidInput);
}

}  // namespace
}  // namespace pusht
