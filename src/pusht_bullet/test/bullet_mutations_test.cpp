// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <cstddef>
#include <memory>
#include <vector>

#include "../src/bullet_scene.hpp"
#include "bullet_checks.hpp"
#include "bullet_world.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/mapping.hpp"
#include "pusht_testing/physics_checks.hpp"
#include "pusht_testing/planted_errors.hpp"

namespace pusht {
namespace {

using bullet::Scene;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

struct FrictionAtTheCenterOfMass : Scene {
  using Scene::Scene;
  void addTableFriction() override {
    addFrictionMotors({0.0, -physics().centerOfMass(), 0.0}, physics().tee_friction, physics().tee_yaw_friction);
  }
};

/// Damping as a force on the body, as engines have it, at its center.
struct DampingAtTheCenterOfMass : Scene {
  using Scene::Scene;
  void applyForces(const btVector3& command) override {
    applyServo(command);
    tee().applyCentralForce(-physics().tee_damping * tee().getLinearVelocity());
    tee().applyTorque({0.0, 0.0, -physics().tee_yaw_damping * tee().getAngularVelocity().z()});
  }
};

struct ThreeWalls : Scene {
  using Scene::Scene;
  void addWalls() override {
    const auto walls = wallBoxes(physics());
    for (std::size_t wall = 0; wall < 3; ++wall) {
      addWall(walls[wall]);
    }
  }
};

/// A moment that turns the tee faster than Bullet can.
struct Top : Scene {
  using Scene::Scene;
  void applyForces(const btVector3& /*command*/) override { tee().applyTorque({0.0, 0.0, 100.0}); }
};

using Planted = testing::PlantedIn<BulletWorld, Scene, BulletParameters>;

std::vector<testing::PlantedError> errors() {
  const testing::PhysicsOfKind claims = testing::bulletPhysics();
  return Planted::withNumbers(claims,
                              {Planted::withLaw<ThreeWalls>("three walls", claims),
                               Planted::withLaw<FrictionAtTheCenterOfMass>("friction at the center of mass", claims),
                               Planted::withLaw<DampingAtTheCenterOfMass>("damping at the center of mass", claims)});
}

TEST(PhysicsSuiteOverAScene, FindsNothingWhereNothingIsPlanted) {
  EXPECT_THAT(testing::findingsIn(*Planted::sound(), testing::bulletPhysics()), ::testing::IsEmpty());
}

TEST(BulletWorld, ReportsATeeThatBulletSlowsDown) {
  BulletWorld world([] { return std::make_unique<Top>(BulletParameters()); });
  world.reset({});
  EXPECT_THAT(
      [&] {
        world.step({0.0F, 0.0F});
      },
      ThrowsMessage<SimulationFault>(
          AllOf(HasSubstr("Bullet: step: tee_yaw_rate "), HasSubstr("must be within 78.5"))));
  EXPECT_THROW(world.step({0.0F, 0.0F}), InvalidInput) << "it must be reset";
}

}  // namespace

namespace testing {
INSTANTIATE_TEST_SUITE_P(Bullet, PlantedErrorSuite, ::testing::ValuesIn(errors()));
}  // namespace testing

}  // namespace pusht
