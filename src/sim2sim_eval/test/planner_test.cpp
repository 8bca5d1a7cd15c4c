// SPDX-License-Identifier: BSD-3-Clause
/// The planner, as it is chosen by name, in worlds of other kinds and tasks.
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <optional>

#include "pusht_policy/policy_choice.hpp"
#include "pusht_task/policy.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/task.hpp"
#include "sim2sim_serving/simulator_kinds.hpp"

namespace sim2sim {
namespace {

using pusht::Task;

pusht::ChosenPolicy plannerOf(const Task& task) {
  pusht::PolicyChoice choice;
  choice.policy = pusht::kPlannerPolicy;
  choice.task = task;
  return pusht::choosePolicy(choice, "none");
}

/// Control steps until success from a spawn seed in a world of a kind; none if it does not succeed.
std::optional<int> stepsToSuccess(const std::string& kind_name, const Task& task, std::uint64_t seed) {
  const pusht::SimulatorKind& kind = pusht::SimulatorKinds::installed().named(kind_name);
  const auto world = kind.load(kind.defaults(task), task).make_world();
  const auto policy = plannerOf(task).make();
  const auto memory = policy->begin({seed});
  pusht::SuccessLatch success(task);
  world->reset(pusht::spawn(seed, task));
  for (int step = 1; step <= pusht::kHorizon; ++step) {
    const pusht::Policy::Query query{pusht::observe(world->state(), task), memory.get()};
    pusht::Action action{};
    policy->act({&query, 1}, {&action, 1});
    world->step(action);
    if (success.update(world->state())) {
      return step;
    }
  }
  return std::nullopt;
}

TEST(Planner, CoversTheTargetInGymPushtsWorld) {
  for (std::uint64_t seed = 100'000; seed < 100'005; ++seed) {
    EXPECT_TRUE(stepsToSuccess("gym_pusht", pusht::gymPusht(), seed)) << seed;
  }
}

/// From here no single stroke brings the tee nearer: it lies in a corner, its bar to the walls.
TEST(Planner, LeavesACornerOfTheTable) {
  for (const std::uint64_t seed : {100'038, 100'068}) {
    EXPECT_TRUE(stepsToSuccess("gym_pusht", pusht::gymPusht(), seed)) << seed;
  }
}

TEST(Planner, ActsInWorldsInWhichItDoesNotPlan) {
  for (const char* kind : {"mujoco", "chipmunk"}) {
    EXPECT_TRUE(stepsToSuccess(kind, pusht::gymPusht(), 100'001)) << kind;
  }
}

TEST(Planner, ActsInOtherTasks) { EXPECT_TRUE(stepsToSuccess("mujoco", pusht::fullCircle(), pusht::kFirstSpawnSeed)); }

TEST(Planner, TakesTheSameStepsAgain) {
  EXPECT_EQ(stepsToSuccess("gym_pusht", pusht::gymPusht(), 100'000),
            stepsToSuccess("gym_pusht", pusht::gymPusht(), 100'000));
}

TEST(Planner, NamesTheWorldInWhichItPlans) {
  EXPECT_EQ(plannerOf(pusht::gymPusht()).provenance.at("runs_on"), "planned in gym-pusht");
  EXPECT_EQ(plannerOf(pusht::fullCircle()).identity, (nlohmann::json{{"planner", "rigid_body"}}));
}

}  // namespace
}  // namespace sim2sim
