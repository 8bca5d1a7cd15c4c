// SPDX-License-Identifier: BSD-3-Clause
/// The planning expert in a world without physics: what does not depend on the quality of its plans. Its success is
/// tested in sim2sim_eval, where kinds of simulators are at hand.
#include "../src/planning_expert.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/task.hpp"
#include "pusht_testing/toy_world.hpp"

namespace pusht {
namespace {

constexpr int kSteps = 60;  // control steps, enough for two strokes

/// Rollouts of the toy that begin with these seeds, asked for actions in one batch.
std::vector<std::vector<Action>> rollOut(const std::vector<std::uint64_t>& seeds) {
  PlanningExpert expert(std::make_unique<ToyWorld>());
  std::vector<std::unique_ptr<ToyWorld>> worlds;
  std::vector<std::unique_ptr<Policy::Memory>> memories;
  for (const std::uint64_t seed : seeds) {
    worlds.push_back(std::make_unique<ToyWorld>());
    worlds.back()->reset(spawn(kFirstSpawnSeed));
    memories.push_back(expert.begin({seed}));
  }
  std::vector<std::vector<Action>> taken(seeds.size());
  for (int step = 0; step < kSteps; ++step) {
    std::vector<Policy::Query> queries;
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      queries.push_back({observe(worlds[i]->state()), memories[i].get()});
    }
    std::vector<Action> actions(seeds.size());
    expert.act(queries, actions);
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      worlds[i]->step(actions[i]);
      taken[i].push_back(actions[i]);
    }
  }
  return taken;
}

TEST(PlanningExpert, RowsAreIndependent) {
  const auto together = rollOut({1, 2});
  EXPECT_EQ(together[0], rollOut({1})[0]);
  EXPECT_EQ(together[1], rollOut({2})[0]);
}

TEST(PlanningExpert, RandomNumbersAreThoseOfTheSeed) {
  EXPECT_EQ(rollOut({1}), rollOut({1}));
  EXPECT_NE(rollOut({1}), rollOut({2}));
}

TEST(PlanningExpert, RestsWhenTheTeeIsThere) {
  PlanningExpert expert(std::make_unique<ToyWorld>());
  const auto memory = expert.begin({});
  WorldState state;
  state.tee_position = {0.01, -0.02};
  state.tee_yaw = 0.15;
  state.pusher_position = {0.2, 0.2};
  const Policy::Query query{observe(state), memory.get()};
  Action action{1.0F, 1.0F};
  expert.act({&query, 1}, {&action, 1});
  EXPECT_NEAR(action[0], 0.0F, 1e-6F);
  EXPECT_NEAR(action[1], 0.0F, 1e-6F);
}

TEST(PlanningExpert, WandersWhereNoStrokeIsInReach) {
  PlanningExpert expert(std::make_unique<ToyWorld>());
  const auto memory = expert.begin({});
  WorldState state;
  state.tee_position = {3.0, 3.0};  // far behind the walls
  const Policy::Query query{observe(state), memory.get()};
  Action action{};
  expert.act({&query, 1}, {&action, 1});
  EXPECT_NE(action, Action{});
}

TEST(PlanningExpert, NeedsItsMemory) {
  PlanningExpert expert(std::make_unique<ToyWorld>());
  const Policy::Query query{observe(WorldState()), nullptr};
  Action action{};
  EXPECT_THROW(expert.act({&query, 1}, {&action, 1}), InternalError);
  EXPECT_THROW(expert.begin({0, 2}), InvalidInput);
}

}  // namespace
}  // namespace pusht
