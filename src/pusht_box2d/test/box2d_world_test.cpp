// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_box2d/box2d_world.hpp"

#include <gmock/gmock.h>

#include <array>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "pusht_box2d/box2d_kind.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/testing/kind_suites.hpp"
#include "pusht_task/testing/scenarios.hpp"

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

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

std::unique_ptr<Simulator> worldWith(const std::vector<std::pair<std::string, std::string>>& settings) {
  ParameterSet parameters = box2dKind().defaults();
  for (const auto& [name, text] : settings) {
    parameters.set(name, text);
  }
  return box2dKind().load(parameters).make_world();
}

std::vector<WorldState> chaseOf(std::uint64_t seed, Simulator& world) {
  std::vector<WorldState> states;
  world.reset(spawn(seed));
  for (int step = 0; step < 60; ++step) {
    world.step(testing::chase(world.state()));
    states.push_back(world.state());
  }
  return states;
}

/// Starts that no table has, in all switches: each is refused or run, and leaves a world that can be reset.
TEST(Box2dWorld, AbsurdStartsAndActionsAbortNothing) {
  for (const char* preset : {"mapped", "idiomatic"}) {
    const auto world = worldWith({{"preset", preset}});
    const std::vector<WorldState> expected = chaseOf(3, *world);
    int refused = 0;
    for (const double magnitude : {1e-30, 1e-3, 0.4, 1.0, 6.0, 7.9, 8.1, 100.0, 999.0}) {
      for (const double speed : {0.0, 1e-30, 1.0, 30.0, 63.0, 65.0, 199.0, 201.0, 99999.0}) {
        WorldState start;
        start.pusher_position = {magnitude, -magnitude};
        start.tee_position = {-magnitude, 0.5 * magnitude};
        start.pusher_velocity = {-speed, 0.0};
        start.tee_velocity = {0.0, speed};
        start.tee_yaw = magnitude;
        start.tee_yaw_rate = 10.0 * speed;
        try {
          world->reset(start);
          for (int step = 0; step < 20; ++step) {
            const float sign = step % 2 == 0 ? 1.0F : -1.0F;
            world->step({sign * 3e38F, -sign});
          }
        } catch (const SimulationFault&) {
          ++refused;
        }
      }
    }
    EXPECT_GT(refused, 0);
    EXPECT_EQ(chaseOf(3, *world), expected) << preset;
  }
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

TEST(Box2dWorld, HasTheSameBytesAfterAThousandResets) {
  const auto world = worldWith({});
  const std::vector<WorldState> expected = chaseOf(3, *world);
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    world->reset(testing::movingState(seed));
    world->step(testing::chase(world->state()));
  }
  EXPECT_EQ(chaseOf(3, *world), expected);
}

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
    const std::vector<WorldState> expected = chaseOf(3, *world);
    leaveOnTheStack(0x3f);  // floats of 0.75
    EXPECT_EQ(chaseOf(3, *world), expected);
  }
}

TEST(Box2dWorld, HasTheSameBytesInTwoThreads) {
  constexpr std::uint64_t kSeeds = 20;
  std::vector<std::vector<WorldState>> alone;
  const auto world = worldWith({});
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    alone.push_back(chaseOf(seed, *world));
  }
  std::vector<std::vector<WorldState>> threaded(kSeeds);
  const auto work = [&](std::uint64_t first) {
    const auto own = worldWith({});
    for (std::uint64_t seed = first; seed < kSeeds; seed += 2) {
      threaded[seed] = chaseOf(seed, *own);
    }
  };
  std::thread other(work, 1);
  work(0);
  other.join();
  EXPECT_EQ(threaded, alone);
}

TEST(Box2dWorld, SaysNothingOnStdout) {
  ::testing::internal::CaptureStdout();
  chaseOf(3, *worldWith({}));
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
}

}  // namespace
}  // namespace pusht
