// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_engine/rigid_body_engine.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "pusht_engine/rigid_body_kind.hpp"
#include "pusht_testing/convergence_suite.hpp"
#include "pusht_testing/kind_suites.hpp"
#include "pusht_testing/refusal.hpp"

namespace pusht::testing {
namespace {

/// Physics with these switches: rigid_body::kSwitches, and the numbers of rigid_body::simple.
PhysicsOfKind physicsOf(const RigidBodyParameters& switches) {
  using namespace rigid_body::simple;
  PhysicsOfKind physics;
  Physics& numbers = physics.numbers;
  if (!switches.pusher_inertia) {  // the pusher moves in the same way, but no contact stops it
    const double scale = kPusherMass / numbers.pusher_mass;
    for (double Physics::*number :
         {&Physics::pusher_mass, &Physics::servo_gain, &Physics::servo_limit, &Physics::pusher_damping}) {
      numbers.*number *= scale;
    }
  }
  if (!switches.servo) {
    numbers.servo_gain = kServoRate * numbers.pusher_mass;
    numbers.servo_limit = std::numeric_limits<double>::infinity();
    numbers.pusher_damping = 0.0;
    physics.implicit_servo = false;
  }
  if (!switches.tee_inertia) {
    numbers.tee_second_moment = kStemMass * kStemOffset * kStemOffset;
  }
  if (!switches.shape) {
    physics.discs = true;
    numbers.bar_half_length = numbers.bar_half_width = kBarRadius;
    numbers.stem_half_length = numbers.stem_half_width = kStemRadius;
  }
  if (!switches.drag) {
    numbers.tee_damping = numbers.tee_yaw_damping = 0.0;
    physics.drag_rate = kDragRate;
  }
  if (!switches.coulomb) {
    numbers.tee_friction = {0.0, 0.0};
    numbers.tee_yaw_friction = 0.0;
  }
  if (!switches.friction) {
    numbers.contact_friction = 0.0;
  }
  physics.walls = switches.walls;

  physics.soft_friction = switches.coulomb;
  physics.soft_contacts = switches.softness;
  physics.contact_position = 2e-3;  // as MuJoCo, whose contacts give way by 1.1 mm under 12 N
  physics.slip_speed = 0.05;        // as MuJoCo: a normal is some degrees off, a touch that sticks creeps
  if (!switches.pusher_inertia) {   // the servo presses twenty times as hard
    physics.contact_position = 0.02;
    physics.slip_speed = 0.15;
  }
  if (!switches.drag || !switches.coulomb) {  // it turns for long, and the integrator is of first order
    physics.free_position = 5e-4;
    physics.free_yaw = 6e-3;
    physics.free_speed = 5e-3;
  }
  return physics;
}

Subject subjectWith(const RigidBodyParameters& switches, std::map<std::string, std::string> settings) {
  return {rigidBodyKind(), std::move(settings), physicsOf(switches)};
}

RigidBodyParameters simpleSwitches() {
  RigidBodyParameters simple;
  for (const rigid_body::Switch& each : rigid_body::kSwitches) {
    simple.*each.value = false;
  }
  return simple;
}

std::vector<Subject> presets() {
  const RigidBodyParameters faithful;
  const RigidBodyParameters simple = simpleSwitches();
  RigidBodyParameters shaped = simple;
  shaped.shape = shaped.tee_inertia = true;
  Subject default_preset = subjectWith(faithful, {});
  default_preset.physics.replay_error = 1e-3;
  return {default_preset, subjectWith(simple, {{"preset", "simple"}}), subjectWith(shaped, {{"preset", "shaped"}}),
          subjectWith(faithful, {{"continuous", "true"}})};
}

/// Each switch alone is the two-mass engine's.
std::vector<Subject> singleSwitches() {
  std::vector<Subject> subjects;
  for (const rigid_body::Switch& each : rigid_body::kSwitches) {
    RigidBodyParameters switches;
    switches.*each.value = false;
    subjects.push_back(subjectWith(switches, {{each.name, "false"}}));
  }
  return subjects;
}

/// First order: Euler's integrator. That of the default preset is MuJoCo's `implicit`, so its errors are MuJoCo's too
/// (mujoco_world_test.cpp says why that of the servo is small, and that at its limit large).
std::vector<ConvergenceSubject> convergence() {
  return {{subjectWith({}, {}),
           "substep",
           {{"servo", 4.724e-6, 1.2, 1.4},
            {"servo at its limit", 0.1045, 0.95, 1.05},
            {"slide", 0.01116, 0.95, 1.05},
            {"slide to rest", 2.533e-3, 0.95, 1.05},
            {"spin", 9.127e-4, 0.95, 1.05},
            {"hit", 2.036e-4, 0.95, 1.05}}},
          {subjectWith(simpleSwitches(), {{"preset", "simple"}}),
           "substep",
           {{"servo", 4.517e-3, 0.95, 1.05},
            {"slide", 0.06995, 0.95, 1.05},
            {"slide to rest", 2.914e-3, 0.95, 1.05},
            {"spin", 6.995e-4, 0.95, 1.05},
            {"hit", 7.267e-4, 0.95, 1.05}}}};
}

}  // namespace

INSTANTIATE_TEST_SUITE_P(SingleSwitches, PhysicsSuite, ::testing::ValuesIn(singleSwitches()));

}  // namespace pusht::testing

PUSHT_TEST_SIMULATOR_KIND(RigidBody, presets());
PUSHT_TEST_CONVERGENCE(RigidBody, convergence());

namespace pusht {

namespace {

using testing::refusalOf;

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
