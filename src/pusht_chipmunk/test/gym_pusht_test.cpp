// SPDX-License-Identifier: BSD-3-Clause
// gym-pusht against what gym-pusht itself does (pusht_testing/data).
#include "pusht_task/gym_pusht.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "gym_pusht_world.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/numpy_random_state.hpp"
#include "pusht_testing/golden.hpp"

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

/// The draws of numpy 1.24, and of its `RandomState(5)`: random_sample(), randint(-3, 3), randn() twice.
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

TEST(GymPusht, CoverageAndRewardAreGymPushts) {
  constexpr double kTolerance = 1e-9;
  double most = 0.0;
  for (const auto& golden : loadGolden("gym_pusht.json", "episodes")) {
    for (const auto& row : golden.at("rows")) {
      const double coverage = gym_pusht::coverage(gym_pusht::toTable(stateOf(row, 2)));
      EXPECT_NEAR(coverage, row.at(12).get<double>(), kTolerance);
      EXPECT_NEAR(gym_pusht::reward(coverage), row.at(13).get<double>(), kTolerance);
      most = std::max(most, coverage);
    }
  }
  EXPECT_GT(most, 0.3);
}

/// GYM.md's figures: 0.95 is left after 2.6 px along an axis of the tee or 0.042 rad.
TEST(GymPusht, CoverageAtTheTarget) {
  const Pose target = gym_pusht::target();
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

}  // namespace
}  // namespace pusht::testing
