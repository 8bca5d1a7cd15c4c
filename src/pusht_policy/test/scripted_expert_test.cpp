// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_policy/scripted_expert.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/task.hpp"
#include "pusht_testing/golden.hpp"

namespace pusht {
namespace {

Action commandAt(ScriptedExpert& expert, const WorldState& state, Policy::Memory* memory) {
  const Policy::Query query{observe(state), memory};
  Action action{};
  expert.act({&query, 1}, {&action, 1});
  return action;
}

/// The golden episodes were driven by an independent implementation with normal noise of 0.08 m/s added to its
/// commands. What is left after ours is taken off must be that noise: stroke starts and ends, phases and plans
/// agree at every step, or single residuals would be as large as a command.
TEST(ScriptedExpert, AgreesWithTheRecordedExpertUpToItsNoise) {
  constexpr double kNoise = 0.08;
  constexpr double kLargest = 5.5 * kNoise;  // of some 7000 draws
  ScriptedExpert expert;
  double squares = 0.0;
  int count = 0;
  for (const auto& golden : testing::loadGolden("expert_actions.json", "cases")) {
    const auto memory = expert.begin({});
    WorldState state = testing::worldPose(golden.at("start_tee_xyyaw_pusher_xy"));
    for (std::size_t step = 0; step < golden.at("actions").size(); ++step) {
      const Action recorded = testing::action(golden.at("actions").at(step));
      const Action command = commandAt(expert, state, memory.get());
      for (std::size_t axis = 0; axis < command.size(); ++axis) {
        const double residual = static_cast<double>(recorded[axis]) - static_cast<double>(command[axis]);
        EXPECT_LT(std::abs(residual), kLargest) << "seed " << golden.at("seed") << " step " << step;
        squares += residual * residual;
        ++count;
      }
      state = testing::worldPose(golden.at("tee_xyyaw_pusher_xy").at(step));
    }
  }
  EXPECT_GT(count, 5000);
  EXPECT_NEAR(std::sqrt(squares / count), kNoise, 0.1 * kNoise);
}

TEST(ScriptedExpert, RestsWhenTheTeeIsThere) {
  ScriptedExpert expert;
  const auto memory = expert.begin({});
  WorldState state;
  state.tee_position = {0.01, -0.02};
  state.tee_yaw = 0.15;
  state.pusher_position = {0.2, 0.2};
  EXPECT_EQ(commandAt(expert, state, memory.get()), (Action{0.0F, 0.0F}));
}

TEST(ScriptedExpert, RowsAreIndependent) {
  ScriptedExpert expert;
  std::vector<std::unique_ptr<Policy::Memory>> memories;
  std::vector<Policy::Query> queries;
  std::vector<Action> alone;
  for (const auto& golden : testing::loadGolden("expert_actions.json", "cases")) {
    const WorldState state = testing::worldPose(golden.at("tee_xyyaw_pusher_xy").at(10));
    alone.push_back(commandAt(expert, state, expert.begin({}).get()));
    memories.push_back(expert.begin({}));
    queries.push_back({observe(state), memories.back().get()});
  }
  std::vector<Action> together(queries.size());
  expert.act(queries, together);
  EXPECT_EQ(together, alone);
}

TEST(ScriptedExpert, NeedsItsMemory) {
  ScriptedExpert expert;
  EXPECT_THROW(commandAt(expert, WorldState(), nullptr), InternalError);
}

}  // namespace
}  // namespace pusht
