// SPDX-License-Identifier: BSD-3-Clause
// gym-pusht against what gym-pusht itself does (pusht_testing/data).
#include "pusht_task/gym_pusht.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "chipmunk_kind.hpp"
#include "gym_pusht_kind.hpp"
#include "gym_pusht_world.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/task.hpp"
#include "pusht_testing/golden.hpp"
#include "pusht_testing/kind_suites.hpp"
#include "pusht_testing/scenarios.hpp"

namespace pusht::testing {
namespace {

using gym_pusht::State;

/// State of a row of `agent_x, agent_y, agent_vx, agent_vy, block_x, block_y, block_angle, block_vx, block_vy,
/// block_rate`, from its column `first` on.
State stateOf(const nlohmann::json& row, std::size_t first) {
  State state;
  state.pusher = vector2(row, first);
  state.pusher_velocity = vector2(row, first + 2);
  state.tee = vector2(row, first + 4);
  state.angle = row.at(first + 6).get<double>();
  state.tee_velocity = vector2(row, first + 7);
  state.rate = row.at(first + 9).get<double>();
  return state;
}

/// State of a row of `agent_x, agent_y, block_x, block_y, angle`.
State poseOf(const nlohmann::json& row) {
  State state;
  state.pusher = vector2(row, 0);
  state.tee = vector2(row, 2);
  state.angle = row.at(4).get<double>();
  return state;
}

/// [rad] As gym-pusht observes an angle: modulo 2 pi, as Python has it.
double observed(double angle) {
  const double rest = std::fmod(angle, 2.0 * kPi);
  return rest < 0.0 ? rest + 2.0 * kPi : rest;
}

void expectSamePoses(const State& a, const State& b) {
  EXPECT_EQ(a.pusher, b.pusher);
  EXPECT_EQ(a.tee, b.tee);
  EXPECT_EQ(a.angle, b.angle);
}

void expectSame(const State& a, const State& b) {
  expectSamePoses(a, b);
  EXPECT_EQ(a.pusher_velocity, b.pusher_velocity);
  EXPECT_EQ(a.tee_velocity, b.tee_velocity);
  EXPECT_EQ(a.rate, b.rate);
}

std::unique_ptr<Simulator> worldWith(const SimulatorKind& kind, const char* preset) {
  ParameterSet parameters = kind.defaults();
  parameters.set("preset", preset);
  return kind.load(parameters, gymPusht()).make_world();
}

/// randint() and randn(), as numpy 1.24 drew them.
TEST(NumpyRandomState, IsNumpysBitForBit) {
  for (const auto& golden : loadGolden("gym_pusht_resets.json", "seeds")) {
    expectSamePoses(gym_pusht::drawn(golden.at("seed").get<std::uint32_t>()), poseOf(golden.at("drawn")));
  }
}

TEST(GymPushtWorld, ResetsToGymPushtsBits) {
  GymPushtWorld world;
  for (const auto& golden : loadGolden("gym_pusht_resets.json", "seeds")) {
    world.reset(gym_pusht::drawn(golden.at("seed").get<std::uint32_t>()));
    const State expected = poseOf(golden.at("observed"));
    EXPECT_EQ(world.state().pusher, expected.pusher);
    EXPECT_EQ(world.state().tee, expected.tee) << "seed " << golden.at("seed");
    EXPECT_EQ(world.state().angle, golden.at("block_angle").get<double>()) << "seed " << golden.at("seed");
    EXPECT_EQ(observed(world.state().angle), expected.angle);
  }
  for (const auto& golden : loadGolden("gym_pusht_resets.json", "given")) {
    world.reset(poseOf(golden.at("asked")));
    const State expected = poseOf(golden.at("observed"));
    EXPECT_EQ(world.state().pusher, expected.pusher);
    EXPECT_EQ(world.state().tee, expected.tee);
    EXPECT_EQ(observed(world.state().angle), expected.angle);
  }
}

TEST(GymPushtWorld, StepsToGymPushtsBits) {
  int steps = 0;
  GymPushtWorld world;
  for (const auto& golden : loadGolden("gym_pusht.json", "episodes")) {
    world.restore(stateOf(golden.at("start"), 0));
    for (const auto& row : golden.at("rows")) {
      world.step(vector2(row, 0));
      expectSame(world.state(), stateOf(row, 2));
      ++steps;
    }
  }
  EXPECT_EQ(steps, 960);
}

/// A seed's episode, overlapping bodies or not, from the draw on.
TEST(GymPushtWorld, FollowsASeedFromItsDraw) {
  GymPushtWorld world;
  for (const auto& golden : loadGolden("gym_pusht.json", "episodes")) {
    world.reset(gym_pusht::drawn(golden.at("seed").get<std::uint32_t>()));
    for (const auto& row : golden.at("rows")) {
      world.step(vector2(row, 0));
      expectSame(world.state(), stateOf(row, 2));
    }
  }
}

/// From a seed on, the kind's world has gym-pusht's recorded bits; a state in the table's frame leads there only
/// nearly.
TEST(GymPushtKind, SpawnsToGymPushtsBits) {
  const auto world = gymPushtKind().load(gymPushtKind().defaults(), gymPusht()).make_world();
  const auto given = gymPushtKind().load(gymPushtKind().defaults(), gymPusht()).make_world();
  bool same = true;
  for (const auto& golden : loadGolden("gym_pusht.json", "episodes")) {
    const auto seed = golden.at("seed").get<std::uint64_t>();
    world->spawn(seed);
    EXPECT_EQ(world->state(), spawn(seed, gymPusht()));
    expectSame(*world->stateInPixels(), stateOf(golden.at("start"), 0));
    given->reset(world->state());
    for (const auto& row : golden.at("rows")) {
      const Action action = {row.at(0).get<float>(), row.at(1).get<float>()};
      world->step(action);
      expectSame(*world->stateInPixels(), stateOf(row, 2));
      EXPECT_EQ(world->state(), gym_pusht::toTable(stateOf(row, 2)));
      given->step(action);
      same = same && given->state() == world->state();
    }
  }
  EXPECT_FALSE(same);
}

/// Another center of gravity would lead gym-pusht's resets elsewhere: the start is the task's all the same.
TEST(GymPushtKind, SpawnsASoundTeeWhereTheOthersAre) {
  const auto world = worldWith(gymPushtKind(), "sound");
  world->spawn(100'003);
  const State expected = gym_pusht::turned(gym_pusht::drawn(100'003));
  EXPECT_LE((world->stateInPixels()->tee - expected.tee).norm(), 1e-12);
}

TEST(GymPusht, CoverageAndRewardAreGymPushts) {
  constexpr double kTolerance = 1e-9;
  double most = 0.0;
  for (const auto& golden : loadGolden("gym_pusht.json", "episodes")) {
    for (const auto& row : golden.at("rows")) {
      const double coverage = coverageOf(gym_pusht::toTable(stateOf(row, 2)), gymPusht());
      EXPECT_NEAR(coverage, row.at(12).get<double>(), kTolerance);
      EXPECT_NEAR(reward(gym_pusht::toTable(stateOf(row, 2)), false, gymPusht()), row.at(13).get<double>(), kTolerance);
      most = std::max(most, coverage);
    }
  }
  EXPECT_GT(most, 0.3);
}

/// GYM.md's figures: 0.95 is left after 2.6 px along an axis of the tee or 0.042 rad.
TEST(GymPusht, CoverageAtTheTarget) {
  const Pose& target = gymPusht().target;
  const auto moved = [&](double x, double yaw) {
    return coverageOf({target.position + Eigen::Rotation2Dd(target.yaw) * Eigen::Vector2d(x, 0.0), target.yaw + yaw},
                      target);
  };
  EXPECT_NEAR(moved(0.0, 0.0), 1.0, 1e-12);
  EXPECT_NEAR(moved(1.0, 0.0), 0.0, 0.0);
  // Moved along the bar, the tee loses a strip of the bar's 30 mm and of the stem's 90 mm, of 6300 mm^2.
  EXPECT_NEAR(moved(0.001, 0.0), 1.0 - 120.0 / 6300.0, 1e-12);
}

TEST(GymPusht, TheTablesFrameAndBack) {
  for (const auto& golden : loadGolden("gym_pusht.json", "episodes")) {
    for (const auto& row : golden.at("rows")) {
      const State state = stateOf(row, 2);
      const State back = gym_pusht::fromTable(gym_pusht::toTable(state));
      EXPECT_LE((back.pusher - state.pusher).norm(), 1e-12);
      EXPECT_LE((back.tee - state.tee).norm(), 1e-12);
      EXPECT_LE((back.tee_velocity - state.tee_velocity).norm(), 1e-9);
      EXPECT_LE(std::abs(wrapAngle(back.angle - state.angle)), 1e-14);
      EXPECT_EQ(back.rate, state.rate);
    }
  }
}

/// Overlapping bodies are where they were drawn, too: the substep of a reset pushes them apart from the next one on.
TEST(GymPusht, SpawnIsWhereItsResetsLead) {
  for (const auto& golden : loadGolden("gym_pusht_resets.json", "seeds")) {
    const WorldState start = spawn(golden.at("seed").get<std::uint64_t>(), gymPusht());
    expectNear(start, gym_pusht::toTable(poseOf(golden.at("observed"))), 1e-14);
  }
}

/// Sound resets: the tee's origin is where it was asked to be; the substep shows where bodies overlap.
TEST(GymPushtWorld, ResetsWithoutQuirks) {
  State asked;
  asked.pusher = {200.0, 220.0};
  asked.tee = {200.0, 200.0};
  asked.angle = 0.5;
  GymPushtWorld turned_first({}, {false, true});
  turned_first.reset(asked);
  EXPECT_LE((turned_first.state().tee - asked.tee).norm(), 1e-12);
  const auto after_a_step = [&](bool first_substep) {
    GymPushtWorld world({}, {false, first_substep});
    world.reset(asked);
    world.step(asked.pusher);
    return world.state().tee;
  };
  EXPECT_NE(after_a_step(true), after_a_step(false));
}

/// A critically damped drive, whose poles are -10/s: after a control step, by the step of its discretization.
TEST(GymPushtWorld, PusherFollowsItsController) {
  GymPushtWorld world;
  State start;
  start.pusher = {100.0, 200.0};
  start.tee = {400.0, 400.0};
  world.restore(start);
  world.step({150.0, 200.0});
  double way = 50.0;
  double velocity = 0.0;
  for (int i = 0; i < kSubstepsPerControlStep; ++i) {
    velocity += (100.0 * way - 20.0 * velocity) * kSubstep;
    way -= velocity * kSubstep;
  }
  EXPECT_NEAR(world.state().pusher.x(), 150.0 - way, 1e-12);
  EXPECT_EQ(world.state().pusher.y(), 200.0);
}

/// Each quirk that is off changes a push, and no other number than it may.
TEST(GymPushtWorld, EachQuirkShows) {
  const auto pushed = [](const GymPushtQuirks& quirks) {
    GymPushtWorld world(quirks);
    State start;
    start.pusher = {215.0, 180.0};
    start.tee = {256.0, 256.0};
    start.angle = 0.4;
    world.restore(start);
    for (int i = 0; i < 12; ++i) {
      world.step({240.0, 420.0});
    }
    return world.state();
  };
  const State usual = pushed({});
  for (const auto& quirk : GymPushtWorld::kQuirks) {
    GymPushtQuirks quirks;
    quirks.*quirk.value = false;
    EXPECT_GT((pushed(quirks).tee - usual.tee).norm(), 0.1) << quirk.name;
  }
}

/// A tee that only damping slows down comes to rest after its velocity over the damping's rate, without turning.
TEST(GymPushtTask, ATeeSlidesAsFarAsItsDampingSays) {
  const Physics& physics = gymPusht().physics;
  const auto world = worldWith(chipmunkKind(), "mapped");
  WorldState start;
  start.pusher_position = {0.2, 0.2};
  start.tee_velocity = {0.4, 0.0};
  start.tee_yaw = 0.3;
  world->reset(start);
  for (int i = 0; i < 20; ++i) {
    world->step(actionFor(Eigen::Vector2d::Zero(), start.pusher_position, gymPusht()));
  }
  EXPECT_NEAR(world->state().tee_position.x(), 0.4 * physics.tee_mass / physics.tee_damping, 1e-6);
  EXPECT_NEAR(world->state().tee_position.y(), 0.0, 1e-9);
  EXPECT_NEAR(world->state().tee_yaw, 0.3, 1e-9);
}

/// Pushed slowly, a sound world and Chipmunk's scene of the task's physics agree, which solve the same laws by other
/// numerics (a substep moves bodies before it solves contacts, or after): the tee follows the pusher.
TEST(GymPushtTask, ASoundWorldIsPushedAsTheTaskSays) {
  const auto sound = worldWith(gymPushtKind(), "sound");
  const auto scene = worldWith(chipmunkKind(), "mapped");
  WorldState start;
  start.pusher_position = {-0.03, 0.031};
  for (const auto& world : {std::cref(sound), std::cref(scene)}) {
    world.get()->reset(start);
    for (int i = 0; i < 12; ++i) {
      world.get()->step(actionFor({0.0, -0.05}, world.get()->state().pusher_position, gymPusht()));
    }
    EXPECT_GT((world.get()->state().tee_position - start.tee_position).norm(), 0.02);
  }
  EXPECT_LE((sound->state().tee_position - scene->state().tee_position).norm(), 0.004);
  EXPECT_LE(std::abs(sound->state().tee_yaw - scene->state().tee_yaw), 0.05);
}

std::vector<Subject> gymSubjects() { return {{gymPushtKind()}, {gymPushtKind(), {{"preset", "sound"}}}}; }

INSTANTIATE_TEST_SUITE_P(GymPusht, SimulatorSuite, ::testing::ValuesIn(gymSubjects()));
INSTANTIATE_TEST_SUITE_P(GymPusht, BatchSimulatorSuite, ::testing::ValuesIn(gymSubjects()));

}  // namespace
}  // namespace pusht::testing
