// SPDX-License-Identifier: BSD-3-Clause
// Errors that are easily made in an engine, planted in the scene, and each switch that is off: the physics suite finds
// them.
#include <gmock/gmock.h>

#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "../src/box2d_scene.hpp"
#include "pusht_box2d/box2d_world.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/testing/physics_checks.hpp"

namespace pusht {
namespace {

using box2d::Scene;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
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
    const double half = 0.02;
    const double middle = physics().wall_inner_face + half;
    addBox(table(), {0.0, middle}, middle, half);
    addBox(table(), {0.0, -middle}, middle, half);
    addBox(table(), {middle, 0.0}, half, middle);
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
  return [physics] { return std::make_unique<Scene>(Box2dParameters(), physics); };
}

template <class SceneWithAnError>
MakeScene withLaws() {
  return [] { return std::make_unique<SceneWithAnError>(Box2dParameters()); };
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
      {"a joint without collisions", withLaws<JointWithoutCollisions>()},
  };
}

/// The checks that find a deviation from the task.
std::vector<std::string> findingsIn(const MakeScene& make_scene) {
  Box2dWorld world(make_scene);
  std::vector<std::string> names;
  for (const testing::NamedPhysicsCheck& named : testing::kPhysicsChecks) {
    if (!named.check(world, testing::PhysicsOfKind()).list().empty()) {
      names.emplace_back(named.name);
    }
  }
  return names;
}

TEST(PhysicsSuiteOverAMutation, FindsNothingWhereNothingIsPlanted) {
  EXPECT_THAT(findingsIn(withNumbers([](Physics&) {})), IsEmpty());
  EXPECT_THAT(findingsIn(withLaws<Scene>()), IsEmpty());
}

class PhysicsSuiteOverMutation : public ::testing::TestWithParam<Mutation> {};

TEST_P(PhysicsSuiteOverMutation, FindsTheError) {
  const std::vector<std::string> findings = findingsIn(GetParam().make_scene);
  EXPECT_FALSE(findings.empty());
  RecordProperty("found_by", joined(findings));
}

INSTANTIATE_TEST_SUITE_P(Box2d, PhysicsSuiteOverMutation, ::testing::ValuesIn(mutations()));

TEST(Box2dWorld, ReportsABodyThatBox2dSlowsDown) {
  Box2dWorld world(withLaws<Rocket>());
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
    return findingsIn([parameters] { return std::make_unique<Scene>(parameters); });
  };
  EXPECT_THAT(found_without(&Box2dSwitches::servo), Contains("servo"));
  EXPECT_THAT(found_without(&Box2dSwitches::table_friction), Contains("slide"));
  EXPECT_THAT(found_without(&Box2dSwitches::drag), Contains("spin"));
  EXPECT_THAT(found_without(&Box2dSwitches::scale), Contains("sizes"));
}

}  // namespace
}  // namespace pusht
