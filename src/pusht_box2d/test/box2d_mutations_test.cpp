// SPDX-License-Identifier: BSD-3-Clause
// Errors that are easily made in an engine, planted in the scene, and each switch that is off: the physics suite finds
// them.
#include <gmock/gmock.h>

#include <cstddef>
#include <memory>
#include <vector>

#include "../src/box2d_scene.hpp"
#include "box2d_world.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/mapping.hpp"
#include "pusht_testing/physics_checks.hpp"
#include "pusht_testing/planted_errors.hpp"

namespace pusht {
namespace {

using box2d::Scene;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

struct FrictionOfADisc : Scene {
  using Scene::Scene;
  void addTableFriction() override { addFrictionOfDisc({0.0, 0.0}); }
};

struct FrictionAtTheCenterOfMass : Scene {
  using Scene::Scene;
  void addTableFriction() override { addFrictionPerAxis({0.0, -physics().centerOfMass()}); }
};

/// Damping as a force on the body, as engines have it, at its center.
struct DampingAtTheCenterOfMass : Scene {
  using Scene::Scene;
  void applyForces(const Eigen::Vector2d& command) override {
    applyServo(command);
    applyDrag({0.0, -physics().centerOfMass()});
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

/// A tee whose joint with the table switches its collisions with the walls off, as joints of Box2D do by default.
struct JointWithoutCollisions : Scene {
  using Scene::Scene;
  void addTableFriction() override {
    Scene::addTableFriction();
    b2FrictionJointDef joint;
    joint.bodyA = table();
    joint.bodyB = tee();
    world().CreateJoint(&joint);
  }
};

/// A force that no servo has, along the line of centers, so that it does not turn the tee.
struct Rocket : Scene {
  using Scene::Scene;
  void applyForces(const Eigen::Vector2d& /*command*/) override { tee()->ApplyForceToCenter({0.0F, 1e9F}, true); }
};

using Planted = testing::PlantedIn<Box2dWorld, Scene, Box2dParameters>;

std::vector<testing::PlantedError> errors() {
  return Planted::withNumbers(
      {}, {Planted::withLaw<ThreeWalls>("three walls", {}), Planted::withLaw<FrictionOfADisc>("friction of a disc", {}),
           Planted::withLaw<FrictionAtTheCenterOfMass>("friction at the center of mass", {}),
           Planted::withLaw<DampingAtTheCenterOfMass>("damping at the center of mass", {}),
           Planted::withLaw<JointWithoutCollisions>("a joint without collisions", {})});
}

TEST(PhysicsSuiteOverAScene, FindsNothingWhereNothingIsPlanted) {
  EXPECT_THAT(testing::findingsIn(*Planted::sound(), {}), ::testing::IsEmpty());
}

TEST(Box2dWorld, ReportsABodyThatBox2dSlowsDown) {
  Box2dWorld world([] { return std::make_unique<Rocket>(Box2dParameters()); });
  world.reset({});
  EXPECT_THAT(
      [&] {
        world.step({0.0F, 0.0F});
      },
      ThrowsMessage<SimulationFault>(AllOf(HasSubstr("Box2D: step: tee at 6"), HasSubstr("cuts speeds off"))));
  EXPECT_THROW(world.step({0.0F, 0.0F}), InvalidInput) << "it must be reset";
}

TEST(PhysicsSuiteOverAnIdiom, FindsEach) {
  const auto found_without = [](bool Box2dSwitches::*choice) {
    Box2dParameters parameters;
    parameters.switches.*choice = false;
    Box2dWorld world(parameters);
    return testing::findingsIn(world, {});
  };
  EXPECT_THAT(found_without(&Box2dSwitches::servo), Contains("servo"));
  EXPECT_THAT(found_without(&Box2dSwitches::table_friction), Contains("slide"));
  EXPECT_THAT(found_without(&Box2dSwitches::drag), Contains("spin"));
  EXPECT_THAT(found_without(&Box2dSwitches::scale), Contains("sizes"));
}

}  // namespace

namespace testing {
INSTANTIATE_TEST_SUITE_P(Box2d, PlantedErrorSuite, ::testing::ValuesIn(errors()));
}  // namespace testing

}  // namespace pusht
