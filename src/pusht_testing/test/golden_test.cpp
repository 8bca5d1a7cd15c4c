// SPDX-License-Identifier: BSD-3-Clause
// The task against the golden vectors.
#include "pusht_testing/golden.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "pusht_task/spawn.hpp"
#include "pusht_task/task.hpp"

namespace pusht {
namespace {

TEST(Spawn, GeneratorIsNumpysBitForBit) {
  for (const auto& golden : testing::loadGolden("pusht_golden.json", "spawn")) {
    NumpyGenerator generator(golden.at("seed").get<std::uint64_t>());
    for (const auto& hex : golden.at("uniforms_hex")) {
      EXPECT_EQ(generator.random(), std::stod(hex.get<std::string>())) << "seed " << golden.at("seed");
    }
  }
}

TEST(Spawn, PosesAreNumpys) {
  constexpr double kTolerance = 4e-15;  // numpy's sin and cos are not libm's
  for (const auto& golden : testing::loadGolden("pusht_golden.json", "spawn")) {
    const WorldState state = spawn(golden.at("seed").get<std::uint64_t>());
    EXPECT_LE((state.pusher_position - testing::vector2(golden.at("pusher"))).norm(), kTolerance);
    EXPECT_LE((state.tee_position - testing::vector2(golden.at("tee"))).norm(), kTolerance);
    EXPECT_LE(std::abs(wrapAngle(state.tee_yaw - golden.at("tee_yaw").get<double>())), kTolerance);
    EXPECT_EQ(state.tee_velocity, Eigen::Vector2d::Zero());
  }
}

/// Errors, rewards and success of every recorded step, from the recorded poses.
TEST(Task, JudgesTheGoldenTrajectories) {
  int rewards = 0;
  int successes = 0;
  for (const auto& golden : testing::loadGolden("pusht_golden.json", "cases")) {
    const auto& mujoco = golden.at("mujoco");
    SuccessLatch latch;
    for (std::size_t step = 0; step < mujoco.at("reward").size(); ++step) {
      const WorldState state = testing::worldState(mujoco.at("qpos_qvel").at(step + 1));
      const bool just_latched = latch.update(state);
      EXPECT_NEAR(reward(state, just_latched), mujoco.at("reward").at(step).get<double>(), 1e-12);
      EXPECT_EQ(latch.latched(), mujoco.at("success").at(step).get<bool>());
      ++rewards;
      successes += just_latched ? 1 : 0;
    }
  }
  EXPECT_GT(rewards, 500);
  EXPECT_GT(successes, 0);
}

}  // namespace
}  // namespace pusht
