// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_mujoco/mujoco_world.hpp"

#include <gnu/libc-version.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "pusht_mujoco/mujoco_kind.hpp"
#include "pusht_task/testing/golden.hpp"
#include "pusht_task/testing/kind_suites.hpp"

namespace pusht {
namespace {

std::shared_ptr<const MujocoScene> scene() {
  static const auto shared = std::make_shared<const MujocoScene>(PUSHT_SCENE);
  return shared;
}

}  // namespace

namespace testing {
namespace {

std::vector<Subject> subjects() {
  PhysicsOfKind physics;
  physics.soft_friction = true;
  physics.contact_position = 1.5e-3;  // a contact gives way by 1.1 mm under 12 N
  physics.slip_speed = 0.05;          // a normal is some degrees off; a touch that sticks creeps
  physics.replay_error = 1e-12;
  return {{mujocoKind(), {}, physics}};
}

}  // namespace
}  // namespace testing
}  // namespace pusht

PUSHT_TEST_SIMULATOR_KIND(Mujoco, subjects());

namespace pusht {
namespace {

double distance(const WorldState& a, const WorldState& b) {
  return std::max({(a.pusher_position - b.pusher_position).norm(), (a.tee_position - b.tee_position).norm(),
                   std::abs(wrapAngle(a.tee_yaw - b.tee_yaw))});
}

constexpr const char* kStack = "MuJoCo 2.2.2, glibc 2.36 (Debian 12) or 2.41 (Debian 13), and FMA";

/// Whether the stack is one that gives the golden trajectories' bits.
bool stackOfTheGoldenVectors() {
  const std::string libc = gnu_get_libc_version();
  return mj_version() == 222 && (libc == "2.36" || libc == "2.41") && __builtin_cpu_supports("fma") != 0;
}

TEST(MujocoWorld, MatchesTheGoldenTrajectoriesBitForBit) {
  if (!stackOfTheGoldenVectors()) {
    GTEST_SKIP() << "needs " << kStack << "; OneStepFromEachGoldenRow holds elsewhere";
  }
  for (const auto& golden : testing::loadGolden("pusht_golden.json", "cases")) {
    const auto& rows = golden.at("mujoco").at("qpos_qvel");
    MujocoWorld world(scene());
    Rollout rollout = begin(world, testing::worldState(rows.at(0)));
    for (std::size_t step = 0; step < golden.at("actions").size(); ++step) {
      advance(rollout, world, testing::action(golden.at("actions").at(step)));
      WorldState expected = testing::worldState(rows.at(step + 1));
      expected.tee_yaw = wrapAngle(expected.tee_yaw);
      ASSERT_EQ(world.state(), expected) << "seed " << golden.at("seed") << " step " << step;
      ASSERT_EQ(rollout.success(), golden.at("mujoco").at("success").at(step).get<bool>());
    }
  }
}

/// The 50 expert episodes. Their yaw was wrapped with a formula that rounds.
TEST(MujocoWorld, MatchesTheExpertEpisodes) {
  if (!stackOfTheGoldenVectors()) {
    GTEST_SKIP() << "needs " << kStack;
  }
  MujocoWorld world(scene());
  for (const auto& golden : testing::loadGolden("expert_actions.json", "cases")) {
    Rollout rollout = begin(world, testing::worldPose(golden.at("start_tee_xyyaw_pusher_xy")));
    for (std::size_t step = 0; step < golden.at("actions").size(); ++step) {
      advance(rollout, world, testing::action(golden.at("actions").at(step)));
      ASSERT_LE(distance(world.state(), testing::worldPose(golden.at("tee_xyyaw_pusher_xy").at(step))), 1e-15)
          << "seed " << golden.at("seed") << " step " << step;
    }
  }
}

TEST(MujocoWorld, OneStepFromEachGoldenRow) {
  constexpr double kWorst = 5e-4;      // the warm start is cleared, so contact forces start elsewhere
  constexpr double kExactShare = 0.5;  // two thirds where the vectors were made
  int steps = 0;
  int exact = 0;
  for (const auto& golden : testing::loadGolden("pusht_golden.json", "cases")) {
    const auto& rows = golden.at("mujoco").at("qpos_qvel");
    MujocoWorld world(scene());
    for (std::size_t step = 0; step < golden.at("actions").size(); ++step) {
      world.reset(testing::worldState(rows.at(step)));
      world.step(testing::action(golden.at("actions").at(step)));
      const double error = distance(world.state(), testing::worldState(rows.at(step + 1)));
      EXPECT_LE(error, kWorst) << "seed " << golden.at("seed") << " step " << step;
      ++steps;
      exact += error < 1e-12 ? 1 : 0;
    }
  }
  EXPECT_GT(exact, kExactShare * steps);
}

}  // namespace
}  // namespace pusht
