// SPDX-License-Identifier: BSD-3-Clause
#include "box2d_world.hpp"

#include <gmock/gmock.h>

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "box2d_kind.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_testing/kind_suites.hpp"
#include "pusht_testing/scenarios.hpp"

namespace pusht::testing {
namespace {

PhysicsOfKind box2dPhysics() {
  PhysicsOfKind physics;
  physics.replay_error = 0.1;
  return physics;
}

/// Boxes with a skin, which keeps other bodies away from them.
PhysicsOfKind withSkin() {
  constexpr double kSkin = 0.01;  // [m]
  PhysicsOfKind physics;
  Physics& numbers = physics.numbers;
  for (double* half :
       {&numbers.bar_half_length, &numbers.bar_half_width, &numbers.stem_half_length, &numbers.stem_half_width}) {
    *half += kSkin;
  }
  numbers.wall_inner_face -= kSkin;
  physics.contact_position = physics.push_position = 0.02;  // the slop is 5 mm, and walls have a skin as well
  physics.slip_speed = 0.1;                                 // the skin makes the bar's end round, where the slip begins
  return physics;
}

std::vector<Subject> subjects() {
  return {{box2dKind(), {}, box2dPhysics()},
          {box2dKind(), {{"velocity_iterations", "60"}, {"position_iterations", "20"}}, box2dPhysics()},
          {box2dKind(), {{"scale", "false"}}, withSkin()}};
}

/// Idioms, whose physics the task's formulas do not describe.
std::vector<Subject> idioms() {
  std::vector<Subject> all = {{box2dKind(), {{"preset", "idiomatic"}}}};
  for (const auto& each : box2d::kSwitches) {
    all.push_back({box2dKind(), {{each.name, "false"}}});
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(Box2dShortSubstep, SimulatorSuite,
                         ::testing::Values(Subject{box2dKind(), {{"substep", "0.0005"}}}));
INSTANTIATE_TEST_SUITE_P(Box2dIdioms, SimulatorSuite, ::testing::ValuesIn(idioms()));
INSTANTIATE_TEST_SUITE_P(Box2dIdioms, BatchSimulatorSuite, ::testing::ValuesIn(idioms()));

}  // namespace
}  // namespace pusht::testing

PUSHT_TEST_SIMULATOR_KIND(Box2d, subjects());

namespace pusht {
namespace {

using testing::chaseFrom;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr int kSteps = 60;

std::unique_ptr<Simulator> worldWith(const std::vector<std::pair<std::string, std::string>>& settings) {
  ParameterSet parameters = box2dKind().defaults();
  for (const auto& [name, text] : settings) {
    parameters.set(name, text);
  }
  return box2dKind().load(parameters).make_world();
}

TEST(Box2dWorld, SaysWhichStartItCannotHold) {
  const auto world = worldWith({});
  WorldState start;
  start.tee_position.y() = -8.5;
  EXPECT_THAT([&] { world->reset(start); },
              ThrowsMessage<SimulationFault>("Box2D: reset: tee_y -8.5 m: must be within 8.0 m, as Box2D computes in "
                                             "single precision"));
  start = WorldState();
  start.pusher_position = {0.2, 0.2};
  start.pusher_velocity.x() = 64.5;
  EXPECT_THAT([&] { world->reset(start); },
              ThrowsMessage<SimulationFault>(
                  "Box2D: reset: pusher at 64.5 m/s: must be below 64.0 m/s, where Box2D cuts speeds off"));
  EXPECT_NO_THROW(worldWith({{"scale", "false"}})->reset(start));
  EXPECT_NO_THROW(worldWith({{"substep", "0.005"}})->reset(start));
  start.pusher_velocity.x() = 0.0;
  start.tee_yaw_rate = 5100.0;
  EXPECT_THAT([&] { world->reset(start); }, ThrowsMessage<SimulationFault>(HasSubstr("tee at 5100.0 rad/s: must be")));
}

TEST(Box2dWorld, ReportsABodyThatLeavesItsReach) {
  const auto world = worldWith({});
  WorldState start;
  start.pusher_position = {7.9, 0.0};
  start.pusher_velocity.x() = 10.0;
  world->reset(start);
  EXPECT_THAT(
      [&] {
        world->step({1.0F, 0.0F});
      },
      ThrowsMessage<SimulationFault>(HasSubstr("Box2D: step: pusher_x 8.")));
  EXPECT_THROW(world->step({0.0F, 0.0F}), InvalidInput) << "it must be reset";
}

TEST(Box2dKind, HasTheVersionOfItsFile) { EXPECT_THAT(box2dVersion(), ::testing::MatchesRegex("2\\.4\\.[0-9]+")); }

/// Leaves bytes on the stack, where the calls that follow have their variables.
[[gnu::noinline]] void leaveOnTheStack(unsigned char byte) {
  std::array<volatile unsigned char, 16384> bytes;  // NOLINT(cppcoreguidelines-pro-type-member-init): set below
  for (volatile unsigned char& each : bytes) {
    each = byte;
  }
}

/// Vectors of Box2D have no value until they are set.
TEST(Box2dWorld, HasTheSameBytesWhateverTheStackHolds) {
  for (const auto& settings : {std::vector<std::pair<std::string, std::string>>(), {{"preset", "idiomatic"}}}) {
    const auto world = worldWith(settings);
    leaveOnTheStack(0x00);
    const std::vector<WorldState> expected = chaseFrom(*world, spawn(3), kSteps);
    leaveOnTheStack(0x3f);  // floats of 0.75
    EXPECT_EQ(chaseFrom(*world, spawn(3), kSteps), expected);
  }
}

TEST(Box2dWorld, SaysNothingOnStdout) {
  ::testing::internal::CaptureStdout();
  chaseFrom(*worldWith({}), spawn(3), kSteps);
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
}

}  // namespace
}  // namespace pusht
