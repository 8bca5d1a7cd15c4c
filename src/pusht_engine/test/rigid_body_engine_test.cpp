// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_engine/rigid_body_engine.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pusht_engine/rigid_body_kind.hpp"
#include "pusht_task/testing/batch_simulator_suite.hpp"
#include "pusht_task/testing/bits.hpp"
#include "pusht_task/testing/refusal.hpp"
#include "pusht_task/testing/simulator_suite.hpp"
#include "rigid_body_testing.hpp"

namespace pusht {

namespace testing {
namespace {

std::vector<Subject> subjects() {
  return {{rigidBodyKind()}, {rigidBodyKind(), {{"preset", "simple"}}}, {rigidBodyKind(), {{"preset", "shaped"}}}};
}

/// With RigidBodyLanes, which the kind itself does not use: its own lanes are single worlds, one stepped after the
/// other. One preset, for under sanitizers lanes are slow;
/// AreWorldsWithAnySwitches has the rest.
Subject inSimdLanes() {
  Subject subject = {rigidBodyKind(), {{"preset", "shaped"}}};
  subject.kind.load = [](const ParameterSet& parameters) {
    SimulatorModel model = rigidBodyKind().load(parameters);
    RigidBodyParameters switches;
    for (const rigid_body::Switch& each : rigid_body::kSwitches) {
      switches.*each.value = parameters.get<bool>(each.name);
    }
    model.make_lanes = [switches](int lanes) { return std::make_unique<RigidBodyLanes>(lanes, switches); };
    return model;
  };
  return subject;
}

}  // namespace

INSTANTIATE_TEST_SUITE_P(RigidBody, SimulatorSuite, ::testing::ValuesIn(subjects()));
INSTANTIATE_TEST_SUITE_P(RigidBody, BatchSimulatorSuite, ::testing::Values(Subject{rigidBodyKind()}, inSimdLanes()));

}  // namespace testing

namespace {

using testing::refusalOf;

/// Any switches: lanes do what single worlds do, bit for bit. (The suite asks more, but of one setting.)
TEST(RigidBodyLanes, AreWorldsWithAnySwitches) {
  constexpr int kSettings = 40;
  constexpr int kSteps = 12;
  rigid_body::Random random(1);
  for (int setting = 0; setting < kSettings; ++setting) {
    const RigidBodyParameters parameters = rigid_body::anySwitches(random);
    RigidBodyLanes lanes(simd::kLaneCount, parameters);
    std::vector<std::unique_ptr<RigidBodyEngine>> worlds;
    for (int lane = 0; lane < simd::kLaneCount; ++lane) {
      const WorldState start = RigidBodyPhysics::stateOf(rigid_body::anyBodies(random, 0.3));
      worlds.push_back(std::make_unique<RigidBodyEngine>(parameters));
      worlds.back()->reset(start);
      lanes.reset(lane, start);
    }
    for (int step = 0; step < kSteps; ++step) {
      std::vector<std::optional<Action>> actions;
      for (const auto& world : worlds) {
        actions.emplace_back(testing::chase(world->state()));
        world->step(*actions.back());
      }
      lanes.step(actions);
      for (int lane = 0; lane < simd::kLaneCount; ++lane) {
        ASSERT_TRUE(testing::sameBits(lanes.state(lane), worlds[lane]->state()))
            << "setting " << setting << " lane " << lane << " step " << step;
      }
    }
  }
}

std::string switchesOf(const ParameterSet& parameters) {
  std::string result;
  for (const rigid_body::Switch& each : rigid_body::kSwitches) {
    result += parameters.get<bool>(each.name) ? '1' : '0';
  }
  return result;
}

TEST(RigidBodyKind, PresetsSetWhatIsNotSetByName) {
  ParameterSet parameters = rigidBodyKind().defaults();
  EXPECT_EQ(switchesOf(parameters), "1111111111");
  parameters.set("preset", "simple");
  EXPECT_EQ(switchesOf(parameters), "0000000000");
  parameters.set("drag", "true");
  EXPECT_EQ(switchesOf(parameters), "0000100000");
  parameters.set("preset", "shaped");
  EXPECT_EQ(switchesOf(parameters), "0011100000") << "drag stays";

  ParameterSet other = rigidBodyKind().defaults();
  other.set("drag", "true");
  other.set("preset", "shaped");
  EXPECT_EQ(other, parameters) << "in either order";
}

TEST(RigidBodyKind, RefusesWhatItDoesNotKnow) {
  ParameterSet parameters = rigidBodyKind().defaults();
  EXPECT_EQ(refusalOf([&] { parameters.set("preset", "best"); }),
            "preset 'best': must be one of: faithful, shaped, simple");
  EXPECT_THAT(refusalOf([&] { parameters.set("gravity", "true"); }), ::testing::HasSubstr("gravity"));
  EXPECT_THAT(refusalOf([&] { parameters.set("servo", "yes"); }), ::testing::HasSubstr("servo 'yes'"));
}

TEST(RigidBodyKind, DefaultsAreThoseOfItsDefaultPreset) {
  ParameterSet set = rigidBodyKind().defaults();
  set.set("preset", textOf(rigidBodyKind().defaults().at("preset").value));
  EXPECT_EQ(set, rigidBodyKind().defaults());
}

}  // namespace
}  // namespace pusht
