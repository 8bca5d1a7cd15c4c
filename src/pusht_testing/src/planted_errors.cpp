// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_testing/planted_errors.hpp"

#include <algorithm>
#include <ostream>

#include "pusht_task/constants.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_testing/physics_checks.hpp"

namespace pusht::testing {

void PrintTo(const PlantedError& error, std::ostream* out) {  // NOLINT(readability-identifier-naming)
  *out << error.name;
}

std::vector<WrongNumbers> wrongNumbers() {
  const auto changed = [](const std::function<void(Physics&)>& change) {
    Physics physics;
    change(physics);
    return physics;
  };
  const auto scaled = [&changed](double Physics::*number, double factor) {
    return changed([=](Physics& physics) { physics.*number *= factor; });
  };
  return {
      {"tee mass", scaled(&Physics::tee_mass, 1.1)},
      {"center of mass too near", scaled(&Physics::tee_first_moment, 0.9)},
      {"center of mass at the origin", scaled(&Physics::tee_first_moment, 0.0)},
      {"center of mass on the wrong side", scaled(&Physics::tee_first_moment, -1.0)},
      {"moment of inertia", scaled(&Physics::tee_second_moment, 1.1)},
      {"moment of inertia without the stem's offset",
       changed([](Physics& physics) { physics.tee_second_moment -= kStemMass * kStemOffset * kStemOffset; })},
      {"moment of inertia of points",
       changed([](Physics& physics) { physics.tee_second_moment = kStemMass * kStemOffset * kStemOffset; })},
      {"damping", scaled(&Physics::tee_damping, 1.1)},
      {"no damping", scaled(&Physics::tee_damping, 0.0)},
      {"yaw damping", scaled(&Physics::tee_yaw_damping, 1.1)},
      {"no yaw damping", scaled(&Physics::tee_yaw_damping, 0.0)},
      {"friction along x", changed([](Physics& physics) { physics.tee_friction[0] *= 1.1; })},
      {"friction along y", changed([](Physics& physics) { physics.tee_friction[1] *= 0.9; })},
      {"no friction", changed([](Physics& physics) {
         physics.tee_friction = {0.0, 0.0};
       })},
      {"yaw friction", scaled(&Physics::tee_yaw_friction, 1.1)},
      {"yaw friction 100 times too small", scaled(&Physics::tee_yaw_friction, 0.01)},
      {"pusher mass", scaled(&Physics::pusher_mass, 1.1)},
      {"servo gain", scaled(&Physics::servo_gain, 1.1)},
      {"servo limit", scaled(&Physics::servo_limit, 1.1)},
      {"no servo limit", scaled(&Physics::servo_limit, 1000.0)},
      {"pusher damping", scaled(&Physics::pusher_damping, 1.5)},
      {"pusher's numbers all too large", changed([](Physics& physics) {
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
      {"walls too far", changed([](Physics& physics) { physics.wall_inner_face += 0.002; })},
  };
}

void PlantedErrorSuite::SetUpTestSuite() {}

TEST_P(PlantedErrorSuite, ThePhysicsSuiteFindsIt) {
  const auto world = GetParam().make_world();
  const std::vector<std::string> findings = findingsIn(*world, GetParam().claims);
  EXPECT_FALSE(findings.empty());
  const std::string& check = GetParam().found_by;
  EXPECT_TRUE(check.empty() || std::count(findings.begin(), findings.end(), check) > 0) << joined(findings);
  RecordProperty("found_by", joined(findings));
}

}  // namespace pusht::testing
