// SPDX-License-Identifier: BSD-3-Clause
#include "chipmunk_world.hpp"

#include <gmock/gmock.h>

#include <cstddef>
#include <vector>

#include "../src/chipmunk_scene.hpp"
#include "chipmunk_kind.hpp"
#include "pusht_task/mapping.hpp"
#include "pusht_testing/convergence_suite.hpp"
#include "pusht_testing/kind_suites.hpp"
#include "pusht_testing/physics_checks.hpp"
#include "pusht_testing/planted_errors.hpp"

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
    const auto walls = wallBoxes(physics());
    for (std::size_t wall = 0; wall < 3; ++wall) {
      addBox(table(), walls[wall]);
    }
  }
};

using Planted = testing::PlantedIn<ChipmunkWorld, Scene, ChipmunkParameters>;

std::vector<testing::PlantedError> errors() {
  const testing::PhysicsOfKind claims = testing::chipmunkPhysics();
  return Planted::withNumbers(claims,
                              {Planted::withLaw<ThreeWalls>("three walls", claims),
                               Planted::withLaw<FrictionOfADisc>("friction of a disc", claims),
                               Planted::withLaw<FrictionAtTheCenterOfMass>("friction at the center of mass", claims),
                               Planted::withLaw<DampingAtTheCenterOfMass>("damping at the center of mass", claims)});
}

TEST(PhysicsSuiteOverAScene, FindsNothingWhereNothingIsPlanted) {
  EXPECT_THAT(testing::findingsIn(*Planted::sound(), testing::chipmunkPhysics()), ::testing::IsEmpty());
}

/// Slop and order show in contacts alone, less than a check resolves: an idiom that is off changes a chase, at least.
TEST(PhysicsSuiteOverAnIdiom, FindsServoFrictionAndDrag) {
  const auto found_without = [](bool ChipmunkSwitches::*choice) {
    ChipmunkParameters parameters;
    parameters.switches.*choice = false;
    ChipmunkWorld world(parameters);
    return testing::findingsIn(world, testing::chipmunkPhysics());
  };
  EXPECT_THAT(found_without(&ChipmunkSwitches::servo), Contains("servo"));
  EXPECT_THAT(found_without(&ChipmunkSwitches::table_friction), Contains("slide"));
  EXPECT_THAT(found_without(&ChipmunkSwitches::drag), Contains("spin"));
}

}  // namespace

namespace testing {
INSTANTIATE_TEST_SUITE_P(Chipmunk, PlantedErrorSuite, ::testing::ValuesIn(errors()));
}  // namespace testing

}  // namespace pusht
