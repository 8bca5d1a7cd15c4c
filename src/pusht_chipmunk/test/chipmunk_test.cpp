// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <vector>

#include "chipmunk_kind.hpp"
#include "chipmunk_scene.hpp"
#include "pusht_testing/convergence_suite.hpp"
#include "pusht_testing/kind_suites.hpp"
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

INSTANTIATE_TEST_SUITE_P(ChipmunkIdioms, SimulatorSuite, ::testing::ValuesIn(idiomsOf(chipmunkKind())));
INSTANTIATE_TEST_SUITE_P(ChipmunkIdioms, BatchSimulatorSuite, ::testing::ValuesIn(idiomsOf(chipmunkKind())));

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

/// Friction of the table as engines offer it ready-made: a disc, not a box.
struct FrictionOfADisc : ChipmunkScene {
  using ChipmunkScene::ChipmunkScene;
  void addTableFriction() override {
    addFriction(cpPivotJointNew2(table(), tee(), cpvzero, cpvzero), physics().tee_friction[0]);
    addFriction(cpSimpleMotorNew(table(), tee(), 0.0), physics().tee_yaw_friction);
  }
};

/// Slop and order show in contacts alone, less than a check resolves: an idiom that is off changes a chase, at least.
std::vector<PlantedError> errors() {
  using Planted = PlantedIn<ChipmunkScene>;
  const PhysicsOfKind claims = chipmunkPhysics();
  return Planted::errors(claims, {Planted::law<FrictionOfADisc>("friction of a disc", claims),
                                  Planted::idiom(&ChipmunkParameters::servo, claims, "servo"),
                                  Planted::idiom(&ChipmunkParameters::table_friction, claims, "slide"),
                                  Planted::idiom(&ChipmunkParameters::drag, claims, "spin")});
}

INSTANTIATE_TEST_SUITE_P(Chipmunk, PlantedErrorSuite, ::testing::ValuesIn(errors()));

// A kind's suites may stand in any namespace.
PUSHT_TEST_SIMULATOR_KIND(Chipmunk, subjects());
PUSHT_TEST_CONVERGENCE(Chipmunk, convergence());

}  // namespace
}  // namespace pusht::testing
