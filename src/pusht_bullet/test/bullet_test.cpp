// SPDX-License-Identifier: BSD-3-Clause
#include <dlfcn.h>
#include <gmock/gmock.h>

#include <cstdint>
#include <string>
#include <vector>

#include "bullet_kind.hpp"
#include "bullet_library.hpp"
#include "bullet_scene.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_testing/convergence_suite.hpp"
#include "pusht_testing/kind_suites.hpp"
#include "pusht_testing/physics_checks.hpp"
#include "pusht_testing/planted_errors.hpp"
#include "pusht_testing/refusal.hpp"
#include "pusht_testing/scenarios.hpp"

namespace pusht::testing {
namespace {

/// Claims of the kind with all its switches on. Gentle touches overlap by less than `overlap` [m].
PhysicsOfKind bulletPhysics(double overlap = 5e-4) {
  PhysicsOfKind physics;
  physics.replay_error = 0.15;
  physics.contact_position = overlap;
  return physics;
}

std::vector<Subject> subjects() {
  return {{bulletKind(), {}, bulletPhysics()},
          {bulletKind(), {{"iterations", "100"}, {"overlap_rate", "20"}}, bulletPhysics(1e-3)}};
}

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

std::vector<PlantedError> errors() {
  using Planted = PlantedIn<BulletScene>;
  const PhysicsOfKind claims = bulletPhysics();
  return Planted::errors(claims, {Planted::idiom(&BulletParameters::servo, claims, "servo"),
                                  Planted::idiom(&BulletParameters::table_friction, claims, "slide across"),
                                  Planted::idiom(&BulletParameters::drag, claims, "slide"),
                                  Planted::idiom(&BulletParameters::margin, claims, "sizes")});
}

INSTANTIATE_TEST_SUITE_P(BulletIdioms, SimulatorSuite, ::testing::ValuesIn(idiomsOf(bulletKind())));
INSTANTIATE_TEST_SUITE_P(BulletIdioms, BatchSimulatorSuite, ::testing::ValuesIn(idiomsOf(bulletKind())));
INSTANTIATE_TEST_SUITE_P(Bullet, PlantedErrorSuite, ::testing::ValuesIn(errors()));

/// A motor that takes the whole error of the velocity away in a substep, as far as its force goes: m / h is its gain.
TEST(BulletIdioms, TheMotorIsAsStiffAsASubstepAllows) {
  PhysicsOfKind motor = bulletPhysics();
  motor.implicit_servo = false;
  motor.numbers.servo_gain = motor.numbers.pusher_mass / kSubstep;
  motor.numbers.pusher_damping = 0.0;
  BulletParameters parameters;
  parameters.servo = false;
  const auto world = worldOf<BulletScene>(parameters);
  EXPECT_EQ(physics::servo(*world, motor).summary(), "");
  EXPECT_EQ(physics::servoLimit(*world, motor).summary(), "");
}

}  // namespace
}  // namespace pusht::testing

PUSHT_TEST_SIMULATOR_KIND(Bullet, subjects());
PUSHT_TEST_CONVERGENCE(Bullet, convergence());

namespace pusht {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

BulletParameters idiomatic() {
  BulletParameters parameters;
  for (const auto& each : BulletScene::kSwitches) {
    parameters.*each.value = false;
  }
  return parameters;
}

TEST(BulletWorld, HoldsItsStartItself) {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const WorldState start = testing::movingState(seed);
    for (const BulletParameters& parameters : {BulletParameters(), idiomatic()}) {
      BulletScene scene(parameters);
      scene.start(start);
      testing::expectNear(scene.state(), start, BulletScene::kStartTolerance);
    }
  }
}

TEST(BulletWorld, RefusesATeeThatTurnsTooFast) {
  const auto world = worldOf<BulletScene>();
  WorldState fast = spawn(3);
  fast.tee_yaw_rate = -79.0;
  EXPECT_EQ(
      testing::refusalOf<SimulationFault>([&] { world->reset(fast); }),
      "Bullet: reset: tee_yaw_rate -79.0 rad/s: must be within 78.54 rad/s: Bullet turns a body by at most pi/4 in "
      "a substep");
  EXPECT_THROW(world->step({0.0F, 0.0F}), InvalidInput);
  fast.tee_yaw_rate = 78.0;
  world->reset(fast);
  world->step({0.0F, 0.0F});
}

/// A moment that turns the tee faster than Bullet can.
struct Top : BulletScene {
  using BulletScene::BulletScene;
  void applyDrag() override { tee().applyTorque({0.0, 0.0, 100.0}); }
};

TEST(BulletWorld, ReportsATeeThatBulletSlowsDown) {
  const auto world = worldOf<Top>();
  world->reset({});
  EXPECT_THAT(
      [&] {
        world->step({0.0F, 0.0F});
      },
      ThrowsMessage<SimulationFault>(
          AllOf(HasSubstr("Bullet: step: tee_yaw_rate "), HasSubstr("must be within 78.5"))));
  EXPECT_THROW(world->step({0.0F, 0.0F}), InvalidInput) << "it must be reset";
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

}  // namespace
}  // namespace pusht
