// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/simulators.hpp"

#include <gmock/gmock.h>

#include <functional>

#include "pusht_task/error.hpp"
#include "pusht_task/rollout.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/testing/refusal.hpp"

namespace sim2sim {
namespace {

using pusht::testing::refusalOf;

TEST(SimulatorKinds, AreFoundByTheirNames) {
  for (const pusht::SimulatorKind& kind : simulatorKinds()) {
    EXPECT_EQ(&simulatorKind(kind.name), &kind);
  }
  EXPECT_EQ(refusalOf([] { simulatorKind("bullet"); }),
            "simulator 'bullet': there is none of that name; there are: mujoco, two_mass, chipmunk");
}

TEST(SimulatorKinds, AreDescribedInFull) {
  for (const pusht::SimulatorKind& kind : simulatorKinds()) {
    EXPECT_FALSE(kind.title.empty() || kind.version.empty() || kind.libraries.empty()) << kind.name;
    EXPECT_GT(kind.start_tolerance, 0.0) << kind.name;
    for (const pusht::ParameterDescriptor& parameter : kind.parameters) {
      EXPECT_FALSE(parameter.meaning.empty()) << kind.name << " " << parameter.name;
      EXPECT_EQ(parameter.read(pusht::textOf(parameter.default_value)), parameter.default_value) << parameter.name;
    }
  }
}

/// Rollouts of a world and of a lane among others, from some starts.
TEST(SimulatorKinds, DoInLanesWhatTheyDoInSingleWorlds) {
  constexpr int kLanes = 3;
  constexpr int kSteps = 50;
  for (const pusht::SimulatorKind& kind : simulatorKinds()) {
    const pusht::SimulatorModel model = kind.load(kind.defaults());
    const auto lanes = model.make_lanes(kLanes);
    ASSERT_EQ(lanes->lanes(), kLanes);
    std::vector<std::unique_ptr<pusht::Simulator>> worlds;
    for (int lane = 0; lane < kLanes; ++lane) {
      const pusht::WorldState start = pusht::spawn(static_cast<std::uint64_t>(lane));
      worlds.push_back(model.make_world());
      worlds.back()->reset(start);
      lanes->reset(lane, start);
    }
    for (int step = 0; step < kSteps; ++step) {
      std::vector<std::optional<pusht::Action>> actions;
      for (const auto& world : worlds) {  // towards the tee
        const pusht::WorldState state = world->state();
        const Eigen::Vector2f way = (state.tee_position - state.pusher_position).cast<float>().normalized();
        actions.push_back(pusht::Action{way.x(), way.y()});
        world->step(*actions.back());
      }
      lanes->step(actions);
    }
    for (int lane = 0; lane < kLanes; ++lane) {
      EXPECT_EQ(lanes->state(lane), worlds[static_cast<std::size_t>(lane)]->state()) << kind.name << " " << lane;
    }
  }
}

TEST(ChooseSimulator, SetsWhatIsNamed) {
  const SimulatorChoice choice = chooseSimulator("two_mass", {"block_damp=20", "pusher_mass=1e-3"});
  EXPECT_EQ(choice.parameters.get<double>("block_damp"), 20.0);
  EXPECT_EQ(choice.parameters.get<double>("pusher_mass"), 1e-3);
  EXPECT_TRUE(choice.parameters.at("baumgarte").isDefault());
}

TEST(ChooseSimulator, SaysWhatCannotBeSet) {
  const auto refusal = [](const std::vector<std::string>& settings) {
    return refusalOf([&] { chooseSimulator("two_mass", settings); });
  };
  EXPECT_EQ(refusal({"block_damp"}), "setting 'block_damp': must be NAME=VALUE");
  EXPECT_EQ(refusal({"block_damp=1", "block_damp=2"}), "setting 'block_damp=2': block_damp must be set once");
  EXPECT_EQ(refusal({"scene=a"}),
            "parameter 'scene': there is none of that name; there are: pusher_mass, block_damp, baumgarte");
  EXPECT_EQ(refusal({"block_damp=much"}), "block_damp 'much': must be a decimal number");
}

}  // namespace
}  // namespace sim2sim
