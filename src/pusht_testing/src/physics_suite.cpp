// SPDX-License-Identifier: BSD-3-Clause
// Physics of a kind: its worlds do what its Subject::physics claims.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "pusht_testing/golden.hpp"
#include "pusht_testing/kind_suites.hpp"
#include "pusht_testing/physics_checks.hpp"

namespace pusht::testing {
namespace {

/// [-] Median distance of the tee from where the reference had it in the golden expert episodes, divided by that of a
/// tee that never moves.
double replayError(Simulator& world) {
  const auto median = [](std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  };
  std::vector<double> errors;
  std::vector<double> of_null;
  for (const auto& golden : loadGolden("expert_actions.json", "cases")) {
    const WorldState start = worldPose(golden.at("start_tee_xyyaw_pusher_xy"));
    world.reset(start);
    double error = 0.0;
    double null_error = 0.0;
    const auto steps = golden.at("actions").size();
    for (std::size_t step = 0; step < steps; ++step) {
      world.step(action(golden.at("actions").at(step)));
      const WorldState reference = worldPose(golden.at("tee_xyyaw_pusher_xy").at(step));
      error += (world.state().tee_position - reference.tee_position).norm() / static_cast<double>(steps);
      null_error += (start.tee_position - reference.tee_position).norm() / static_cast<double>(steps);
    }
    errors.push_back(error);
    of_null.push_back(null_error);
  }
  return median(errors) / median(of_null);
}

}  // namespace

void PhysicsSuite::SetUpTestSuite() {}

TEST_P(PhysicsSuite, WorldsMoveAsTheKindClaims) {
  const auto world = makeWorld();
  for (const NamedPhysicsCheck& named : kPhysicsChecks) {
    const Deviations deviations = named.check(*world, GetParam().physics);
    if (deviations.any()) {
      ADD_FAILURE() << named.name << ": " << deviations.summary();
    }
  }
  if (HasFailure()) {
    ADD_FAILURE() << "the cause, where it can be told: audit --engine " << GetParam().kind.name << " --against task";
  }
}

TEST_P(PhysicsSuite, FollowsTheReferenceAsFarAsTheKindClaims) {
  if (const auto& claimed = GetParam().physics.replay_error) {
    EXPECT_LE(replayError(*makeWorld()), *claimed);
  }
}

}  // namespace pusht::testing
