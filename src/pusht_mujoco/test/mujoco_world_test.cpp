// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_mujoco/mujoco_world.hpp"

#include <gnu/libc-version.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "pusht_mujoco/mujoco_kind.hpp"
#include "pusht_task/rollout.hpp"
#include "pusht_testing/convergence_suite.hpp"
#include "pusht_testing/golden.hpp"
#include "pusht_testing/kind_suites.hpp"

namespace pusht {
namespace {

std::shared_ptr<const MujocoScene> scene() {
  static const auto shared = std::make_shared<const MujocoScene>(PUSHT_SCENE);
  return shared;
}

}  // namespace

namespace testing {
namespace {

Subject subjectWith(std::map<std::string, std::string> settings) {
  PhysicsOfKind physics;
  physics.soft_friction = physics.soft_contacts = true;
  physics.contact_position = 1.5e-3;  // a contact gives way by 1.1 mm under 12 N
  physics.slip_speed = 0.05;          // a normal is some degrees off; a touch that sticks creeps
  return {mujocoKind(), std::move(settings), physics};
}

std::vector<Subject> subjects() {
  Subject subject = subjectWith({});
  subject.physics.replay_error = 1e-12;
  return {subject};
}

/// Euler's integrators are of first order. Within a control step the servo settles in ten of its time constants, so
/// `implicit` leaves little error, of which higher orders still show. At the servo's limit `implicit` is off by 0.1 m:
/// it takes the servo's gain into account there too. Runge-Kutta is of fourth order where the motion is smooth; a limit
/// that ends within a step costs some of that, at random.
std::vector<ConvergenceSubject> convergence() {
  return {{subjectWith({}),
           "timestep",
           {{"servo", 4.724e-6, 1.2, 1.4},
            {"servo at its limit", 0.1045, 0.95, 1.05},
            {"slide", 0.01116, 0.95, 1.05},
            {"slide to rest", 2.533e-3, 0.95, 1.05},
            {"spin", 9.127e-4, 0.95, 1.05},
            {"hit", 2.036e-4, 0.95, 1.05}}},
          {subjectWith({{"integrator", "Euler"}}),
           "timestep",
           {{"servo", 5.711e-3, 0.95, 1.05},
            {"servo at its limit", 0.03687, 0.95, 1.05},
            {"slide", 0.01116, 0.95, 1.05},
            {"slide to rest", 2.533e-3, 0.95, 1.05},
            {"spin", 9.12e-4, 0.95, 1.05},
            {"hit", 4.841e-4, 0.95, 1.05}}},
          {subjectWith({{"integrator", "RK4"}}),
           "timestep",
           {{"servo", 5.0e-8, 3.9, 4.3},
            {"servo at its limit", 1.861e-4, 2.5, 5.0},
            {"slide", 1.301e-5, 3.9, 4.3},
            {"slide to rest", 2.436e-5, 2.5, 5.0},
            {"spin", 2.092e-6, 2.5, 5.0},
            {"hit", 7.622e-7, 2.5, 5.0}}}};
}

}  // namespace
}  // namespace testing
}  // namespace pusht

PUSHT_TEST_SIMULATOR_KIND(Mujoco, subjects());
PUSHT_TEST_CONVERGENCE(Mujoco, convergence());

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
