// SPDX-License-Identifier: BSD-3-Clause
#include "bullet_world.hpp"

#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "../src/bullet_library.hpp"
#include "../src/bullet_scene.hpp"
#include "bullet_checks.hpp"
#include "bullet_kind.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_testing/convergence_suite.hpp"
#include "pusht_testing/kind_suites.hpp"
#include "pusht_testing/physics_checks.hpp"
#include "pusht_testing/refusal.hpp"
#include "pusht_testing/scenarios.hpp"

namespace pusht::testing {
namespace {

std::vector<Subject> subjects() {
  return {{bulletKind(), {}, bulletPhysics()},
          {bulletKind(), {{"iterations", "100"}, {"overlap_rate", "20"}}, bulletPhysics(1e-3)}};
}

/// Worlds of idioms keep the contract of every simulator, too. They have other physics.
std::vector<Subject> idioms() { return {{bulletKind(), {{"preset", "idiomatic"}}, {}}}; }

/// First order: Euler's integrator, implicit by the added mass.
std::vector<ConvergenceSubject> convergence() {
  return {{{bulletKind(), {}, bulletPhysics()},
           "substep",
           {{"servo", 4.724e-6, 1.2, 1.4},
            {"servo at its limit", 0.1045, 0.95, 1.05},
            {"slide", 0.01116, 0.95, 1.05},
            {"slide to rest", 1.961e-3, 0.95, 1.05},
            {"spin", 2.106e-4, 0.9, 1.05},
            {"hit", 3.443e-6, 1.0, 1.2}}}};
}

}  // namespace

INSTANTIATE_TEST_SUITE_P(BulletIdioms, SimulatorSuite, ::testing::ValuesIn(idioms()));
INSTANTIATE_TEST_SUITE_P(BulletIdioms, BatchSimulatorSuite, ::testing::ValuesIn(idioms()));

}  // namespace pusht::testing

PUSHT_TEST_SIMULATOR_KIND(Bullet, subjects());
PUSHT_TEST_CONVERGENCE(Bullet, convergence());

namespace pusht {
namespace {

BulletParameters idiomatic() {
  BulletParameters parameters;
  for (const bullet::BulletSwitch& each : bullet::kSwitches) {
    parameters.*each.value = false;
  }
  return parameters;
}

TEST(BulletWorld, HoldsItsStartItself) {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const WorldState start = testing::movingState(seed);
    for (const BulletParameters& parameters : {BulletParameters(), idiomatic()}) {
      bullet::Scene scene(parameters);
      scene.start(start);
      testing::expectNear(scene.state(), start, BulletWorld::kStartTolerance);
    }
  }
}

TEST(BulletWorld, RefusesATeeThatTurnsTooFast) {
  BulletWorld world;
  WorldState fast = spawn(3);
  fast.tee_yaw_rate = -79.0;
  EXPECT_EQ(
      testing::refusalOf<SimulationFault>([&] { world.reset(fast); }),
      "Bullet: reset: tee_yaw_rate -79.0 rad/s: must be within 78.54 rad/s: Bullet turns a body by at most pi/4 in "
      "a substep");
  EXPECT_THROW(world.step({0.0F, 0.0F}), InvalidInput);
  fast.tee_yaw_rate = 78.0;
  world.reset(fast);
  world.step({0.0F, 0.0F});
}

TEST(BulletKind, RefusesAProcessWithBulletInSinglePrecision) {
  const std::string file = "libLinearMath.so." + bullet::libraryVersion();
  bulletKind().load(bulletKind().defaults());
  void* const single = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  ASSERT_NE(single, nullptr) << dlerror();
  const std::string message = testing::refusalOf<BadDependency>([] { bulletKind().load(bulletKind().defaults()); });
  dlclose(single);
  EXPECT_NE(message.find(file + ": must not be in a process with Bullet in double precision"), std::string::npos)
      << message;
  bulletKind().load(bulletKind().defaults());
}

/// Worlds with one switch off.
BulletParameters without(bool BulletParameters::*choice) {
  BulletParameters parameters;
  parameters.*choice = false;
  return parameters;
}

TEST(BulletIdioms, AreFoundByThePhysicsSuite) {
  const std::vector<std::pair<bool BulletParameters::*, const char*>> found_by = {
      {&BulletParameters::servo, "servo"},
      {&BulletParameters::table_friction, "slide across"},
      {&BulletParameters::drag, "slide"},
      {&BulletParameters::margin, "sizes"}};
  ASSERT_EQ(found_by.size(), bullet::kSwitches.size());
  for (const auto& [choice, check] : found_by) {
    BulletWorld world(without(choice));
    EXPECT_THAT(testing::findingsIn(world, testing::bulletPhysics()), ::testing::Contains(check));
  }
}

/// A motor that takes the whole error of the velocity away in a substep, as far as its force goes: m / h is its gain.
TEST(BulletIdioms, TheMotorIsAsStiffAsASubstepAllows) {
  testing::PhysicsOfKind motor = testing::bulletPhysics();
  motor.implicit_servo = false;
  motor.numbers.servo_gain = motor.numbers.pusher_mass / kSubstep;
  motor.numbers.pusher_damping = 0.0;
  BulletWorld world(without(&BulletParameters::servo));
  EXPECT_EQ(testing::physics::servo(world, motor).list(), std::vector<std::string>());
  EXPECT_EQ(testing::physics::servoLimit(world, motor).list(), std::vector<std::string>());
}

}  // namespace
}  // namespace pusht
