// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_chipmunk/chipmunk_world.hpp"

#include <gmock/gmock.h>

#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "../src/chipmunk_scene.hpp"
#include "pusht_chipmunk/chipmunk_kind.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/testing/convergence_suite.hpp"
#include "pusht_task/testing/kind_suites.hpp"

namespace pusht::testing {
namespace {

PhysicsOfKind chipmunkPhysics() {
  PhysicsOfKind physics;
  physics.replay_error = 0.1;
  return physics;
}

std::vector<Subject> subjects() {
  PhysicsOfKind coarse;
  coarse.contact_position = coarse.push_position = 4e-3;  // half of an overlap is left after a second
  return {{chipmunkKind(), {}, chipmunkPhysics()},
          {chipmunkKind(), {{"iterations", "10"}, {"collision_slop", "0.001"}, {"overlap_left", "0.5"}}, coarse}};
}

/// Idioms, whose physics the task's formulas do not describe.
std::vector<Subject> idioms() {
  std::vector<Subject> all = {{chipmunkKind(), {{"preset", "idiomatic"}}}};
  for (const auto& each : chipmunk::kSwitches) {
    all.push_back({chipmunkKind(), {{each.name, "false"}}});
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(ChipmunkIdioms, SimulatorSuite, ::testing::ValuesIn(idioms()));
INSTANTIATE_TEST_SUITE_P(ChipmunkIdioms, BatchSimulatorSuite, ::testing::ValuesIn(idioms()));

/// First order: Euler's integrator, implicit by the added mass. Servo and hit settle in eight to ten of their time
/// constants within a control step, so that higher orders still show in the little error that is left.
std::vector<ConvergenceSubject> convergence() {
  return {{{chipmunkKind(), {}, chipmunkPhysics()},
           "substep",
           {{"servo", 4.724e-6, 1.2, 1.4},
            {"servo at its limit", 0.1045, 0.95, 1.05},
            {"slide", 0.01116, 0.95, 1.05},
            {"slide to rest", 1.961e-3, 0.95, 1.05},
            {"spin", 2.106e-4, 0.9, 1.05},
            {"hit", 3.411e-6, 1.1, 1.3}}}};
}

}  // namespace
}  // namespace pusht::testing

PUSHT_TEST_SIMULATOR_KIND(Chipmunk, subjects());
PUSHT_TEST_CONVERGENCE(Chipmunk, convergence());

namespace pusht {
namespace {

using chipmunk::Scene;
using ::testing::Contains;

// Errors that are easily made in an engine, planted in the scene: the physics suite finds each.

/// Friction of the table as engines offer it ready-made: a disc, not a box.
struct FrictionOfADisc : Scene {
  using Scene::Scene;
  void addDryFriction() override {
    addFriction(cpPivotJointNew2(table(), tee(), cpvzero, cpvzero), physics().tee_friction[0]);
    addFriction(cpSimpleMotorNew(table(), tee(), 0.0), physics().tee_yaw_friction);
  }
};

struct FrictionAtTheCenterOfMass : Scene {
  using Scene::Scene;
  void addDryFriction() override {
    const cpVect center = cpv(0.0, -physics().centerOfMass());
    const double far = 1000.0;  // [m]
    addFriction(cpGrooveJointNew(table(), tee(), cpv(0.0, -far), cpv(0.0, far), center), physics().tee_friction[0]);
    addFriction(cpGrooveJointNew(table(), tee(), cpv(-far, 0.0), cpv(far, 0.0), center), physics().tee_friction[1]);
    addFriction(cpSimpleMotorNew(table(), tee(), 0.0), physics().tee_yaw_friction);
  }
};

/// Damping as a force on the body, as engines have it, at its center.
struct DampingAtTheCenterOfMass : Scene {
  using Scene::Scene;
  void applyForces(const cpVect& command) override {
    applyServo(command);
    cpBodySetForce(tee(), cpvmult(cpBodyGetVelocity(tee()), -physics().tee_damping));
    cpBodySetTorque(tee(), -physics().tee_yaw_damping * cpBodyGetAngularVelocity(tee()));
  }
};

struct ThreeWalls : Scene {
  using Scene::Scene;
  void addWalls() override {
    const double half = 0.02;
    const double middle = physics().wall_inner_face + half;
    addBox(table(), cpv(0.0, middle), middle, half);
    addBox(table(), cpv(0.0, -middle), middle, half);
    addBox(table(), cpv(middle, 0.0), half, middle);
  }
};

using MakeScene = std::function<std::unique_ptr<Scene>()>;

struct Mutation {
  const char* name;
  MakeScene make_scene;
};

void PrintTo(const Mutation& mutation, std::ostream* out) {  // NOLINT(readability-identifier-naming)
  *out << mutation.name;
}

MakeScene withNumbers(const std::function<void(Physics&)>& change) {
  Physics physics;
  change(physics);
  return [physics] { return std::make_unique<Scene>(ChipmunkParameters(), physics); };
}

template <class SceneWithAnError>
MakeScene withLaws() {
  return [] { return std::make_unique<SceneWithAnError>(ChipmunkParameters()); };
}

/// A number that is so many times what it should be.
MakeScene scaled(double Physics::*number, double factor) {
  return withNumbers([=](Physics& physics) { physics.*number *= factor; });
}

std::vector<Mutation> mutations() {
  return {
      {"tee mass", scaled(&Physics::tee_mass, 1.1)},
      {"center of mass too near", scaled(&Physics::tee_first_moment, 0.9)},
      {"center of mass at the origin", scaled(&Physics::tee_first_moment, 0.0)},
      {"center of mass on the wrong side", scaled(&Physics::tee_first_moment, -1.0)},
      {"moment of inertia", scaled(&Physics::tee_second_moment, 1.1)},
      {"moment of inertia without the stem's offset",
       withNumbers([](Physics& physics) { physics.tee_second_moment -= kStemMass * kStemOffset * kStemOffset; })},
      {"moment of inertia of points",
       withNumbers([](Physics& physics) { physics.tee_second_moment = kStemMass * kStemOffset * kStemOffset; })},
      {"damping", scaled(&Physics::tee_damping, 1.1)},
      {"no damping", scaled(&Physics::tee_damping, 0.0)},
      {"yaw damping", scaled(&Physics::tee_yaw_damping, 1.1)},
      {"no yaw damping", scaled(&Physics::tee_yaw_damping, 0.0)},
      {"friction along x", withNumbers([](Physics& physics) { physics.tee_friction[0] *= 1.1; })},
      {"friction along y", withNumbers([](Physics& physics) { physics.tee_friction[1] *= 0.9; })},
      {"no friction", withNumbers([](Physics& physics) {
         physics.tee_friction = {0.0, 0.0};
       })},
      {"yaw friction", scaled(&Physics::tee_yaw_friction, 1.1)},
      {"yaw friction 100 times too small", scaled(&Physics::tee_yaw_friction, 0.01)},
      {"pusher mass", scaled(&Physics::pusher_mass, 1.1)},
      {"servo gain", scaled(&Physics::servo_gain, 1.1)},
      {"servo limit", scaled(&Physics::servo_limit, 1.1)},
      {"no servo limit", scaled(&Physics::servo_limit, 1000.0)},
      {"pusher damping", scaled(&Physics::pusher_damping, 1.5)},
      {"pusher's numbers all too large", withNumbers([](Physics& physics) {
         for (double Physics::*number :
              {&Physics::pusher_mass, &Physics::servo_gain, &Physics::servo_limit, &Physics::pusher_damping}) {
           physics.*number *= 1.1;
         }
       })},
      {"friction in contacts", scaled(&Physics::contact_friction, 0.9)},
      {"no friction in contacts", scaled(&Physics::contact_friction, 0.0)},
      {"pusher's size", scaled(&Physics::pusher_radius, 1.1)},
      {"bar's length", scaled(&Physics::bar_half_length, 1.05)},
      {"bar's width", scaled(&Physics::bar_half_width, 1.1)},
      {"stem's length", scaled(&Physics::stem_half_length, 1.05)},
      {"stem's width", scaled(&Physics::stem_half_width, 1.1)},
      {"stem's place", scaled(&Physics::stem_offset, 0.95)},
      {"stem on the wrong side", scaled(&Physics::stem_offset, -1.0)},
      {"walls too far", withNumbers([](Physics& physics) { physics.wall_inner_face += 0.002; })},
      {"three walls", withLaws<ThreeWalls>()},
      {"friction of a disc", withLaws<FrictionOfADisc>()},
      {"friction at the center of mass", withLaws<FrictionAtTheCenterOfMass>()},
      {"damping at the center of mass", withLaws<DampingAtTheCenterOfMass>()},
  };
}

/// The checks that find an error.
std::vector<std::string> findingsIn(const MakeScene& make_scene) {
  ChipmunkWorld world(make_scene);
  std::vector<std::string> names;
  for (const testing::NamedPhysicsCheck& named : testing::kPhysicsChecks) {
    if (!named.check(world, testing::chipmunkPhysics()).list().empty()) {
      names.emplace_back(named.name);
    }
  }
  return names;
}

TEST(PhysicsSuiteOverAMutation, FindsNothingWhereNothingIsPlanted) {
  EXPECT_EQ(findingsIn(withNumbers([](Physics&) {})), std::vector<std::string>());
  EXPECT_EQ(findingsIn(withLaws<Scene>()), std::vector<std::string>());
}

class PhysicsSuiteOverMutation : public ::testing::TestWithParam<Mutation> {};

TEST_P(PhysicsSuiteOverMutation, FindsTheError) {
  const std::vector<std::string> findings = findingsIn(GetParam().make_scene);
  EXPECT_FALSE(findings.empty());
  RecordProperty("found_by", joined(findings));
}

INSTANTIATE_TEST_SUITE_P(Chipmunk, PhysicsSuiteOverMutation, ::testing::ValuesIn(mutations()));

/// Slop and order show in contacts alone, less than a check resolves: an idiom that is off changes a chase, at least.
TEST(PhysicsSuiteOverAnIdiom, FindsServoFrictionAndDrag) {
  const auto found_without = [](bool ChipmunkSwitches::*choice) {
    ChipmunkParameters parameters;
    parameters.switches.*choice = false;
    return findingsIn([parameters] { return std::make_unique<Scene>(parameters); });
  };
  EXPECT_THAT(found_without(&ChipmunkSwitches::servo), Contains("servo"));
  EXPECT_THAT(found_without(&ChipmunkSwitches::table_friction), Contains("slide"));
  EXPECT_THAT(found_without(&ChipmunkSwitches::drag), Contains("spin"));
}

}  // namespace
}  // namespace pusht
