// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <array>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "box2d_kind.hpp"
#include "box2d_scene.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_testing/kind_suites.hpp"
#include "pusht_testing/planted_errors.hpp"

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

INSTANTIATE_TEST_SUITE_P(Box2dShortSubstep, SimulatorSuite,
                         ::testing::Values(Subject{box2dKind(), {{"substep", "0.0005"}}}));
INSTANTIATE_TEST_SUITE_P(Box2dIdioms, SimulatorSuite, ::testing::ValuesIn(idiomsOf(box2dKind())));
INSTANTIATE_TEST_SUITE_P(Box2dIdioms, BatchSimulatorSuite, ::testing::ValuesIn(idiomsOf(box2dKind())));

struct FrictionOfADisc : Box2dScene {
  using Box2dScene::Box2dScene;
  void addTableFriction() override { addFrictionOfDisc({0.0, 0.0}); }
};

/// A tee whose joint with the table switches its collisions with the walls off, as joints of Box2D do by default.
struct JointWithoutCollisions : Box2dScene {
  using Box2dScene::Box2dScene;
  void addTableFriction() override {
    Box2dScene::addTableFriction();
    b2FrictionJointDef joint;
    joint.bodyA = table();
    joint.bodyB = tee();
    world().CreateJoint(&joint);
  }
};

std::vector<PlantedError> errors() {
  using Planted = PlantedIn<Box2dScene>;
  return Planted::errors(
      {}, {Planted::law<FrictionOfADisc>("friction of a disc", {}),
           Planted::law<JointWithoutCollisions>("a joint without collisions", {}),
           Planted::idiom(&Box2dParameters::servo, {}, "servo"),
           Planted::idiom(&Box2dParameters::table_friction, {}, "slide"),
           Planted::idiom(&Box2dParameters::drag, {}, "spin"), Planted::idiom(&Box2dParameters::scale, {}, "sizes")});
}

INSTANTIATE_TEST_SUITE_P(Box2d, PlantedErrorSuite, ::testing::ValuesIn(errors()));

}  // namespace
}  // namespace pusht::testing

PUSHT_TEST_SIMULATOR_KIND(Box2d, subjects());

namespace pusht {
namespace {

using ::testing::AllOf;
using testing::chaseFrom;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr int kSteps = 60;

std::unique_ptr<Simulator> worldWith(const std::map<std::string, std::string>& settings) {
  return testing::Subject{box2dKind(), settings}.load().make_world();
}

/// A force that no servo has, along the line of centers, so that it does not turn the tee.
struct Rocket : Box2dScene {
  using Box2dScene::Box2dScene;
  void applyDrag() override { tee()->ApplyForceToCenter({0.0F, 1e9F}, true); }
};

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

TEST(Box2dWorld, ReportsABodyThatBox2dSlowsDown) {
  const auto world = worldOf<Rocket>();
  world->reset({});
  EXPECT_THAT(
      [&] {
        world->step({0.0F, 0.0F});
      },
      ThrowsMessage<SimulationFault>(AllOf(HasSubstr("Box2D: step: tee at 6"), HasSubstr("cuts speeds off"))));
  EXPECT_THROW(world->step({0.0F, 0.0F}), InvalidInput) << "it must be reset";
}

TEST(Box2dKind, HasTheVersionOfItsFile) { EXPECT_THAT(box2dKind().version, ::testing::MatchesRegex("2\\.4\\.[0-9]+")); }

/// Leaves bytes on the stack, where the calls that follow have their variables.
[[gnu::noinline]] void leaveOnTheStack(unsigned char byte) {
  std::array<volatile unsigned char, 16384> bytes;  // NOLINT(cppcoreguidelines-pro-type-member-init): set below
  for (volatile unsigned char& each : bytes) {
    each = byte;
  }
}

/// Vectors of Box2D have no value until they are set.
TEST(Box2dWorld, HasTheSameBytesWhateverTheStackHolds) {
  for (const char* preset : {"mapped", "idiomatic"}) {
    const auto world = worldWith({{"preset", preset}});
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
