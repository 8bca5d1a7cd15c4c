// SPDX-License-Identifier: BSD-3-Clause
/// Errors that are easily made in an engine, planted in the scene: the physics suite finds each.
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "../src/bullet_scene.hpp"
#include "bullet_checks.hpp"
#include "pusht_bullet/bullet_world.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/joined.hpp"

namespace pusht {
namespace {

using bullet::Scene;

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
    const double half = 0.02;
    const double middle = physics().wall_inner_face + half;
    addWall({middle, half, half}, {0.0, middle, 0.0});
    addWall({middle, half, half}, {0.0, -middle, 0.0});
    addWall({half, middle, half}, {middle, 0.0, 0.0});
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
  return [physics] { return std::make_unique<Scene>(BulletParameters(), physics); };
}

template <class SceneWithAnError>
MakeScene withLaws() {
  return [] { return std::make_unique<SceneWithAnError>(BulletParameters()); };
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
      {"friction at the center of mass", withLaws<FrictionAtTheCenterOfMass>()},
      {"damping at the center of mass", withLaws<DampingAtTheCenterOfMass>()},
  };
}

TEST(PhysicsSuiteOverAMutation, FindsNothingWhereNothingIsPlanted) {
  for (const MakeScene& sound : {withNumbers([](Physics&) {}), withLaws<Scene>()}) {
    BulletWorld world(sound);
    EXPECT_EQ(testing::findingsIn(world), std::vector<std::string>());
  }
}

class PhysicsSuiteOverMutation : public ::testing::TestWithParam<Mutation> {};

TEST_P(PhysicsSuiteOverMutation, FindsTheError) {
  BulletWorld world(GetParam().make_scene);
  const std::vector<std::string> findings = testing::findingsIn(world);
  EXPECT_FALSE(findings.empty());
  RecordProperty("found_by", joined(findings));
}

INSTANTIATE_TEST_SUITE_P(Bullet, PhysicsSuiteOverMutation, ::testing::ValuesIn(mutations()));

}  // namespace
}  // namespace pusht
