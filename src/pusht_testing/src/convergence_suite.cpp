// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_testing/convergence_suite.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <ostream>

#include "exact_motions.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/numbers.hpp"

namespace pusht::testing {
namespace {

/// [m] Distance of a world from the end of a motion; yaw counts at a lever of PhysicsOfKind::kLever.
double errorOf(const ConvergenceSubject& convergence, const ExactMotion& motion, double substep) {
  Subject subject = convergence.subject;
  if (!convergence.substep.empty()) {
    subject.settings[convergence.substep] = shortestText(substep);
  }
  const std::unique_ptr<Simulator> world = subject.load().make_world();
  world->reset(motion.start);
  for (int step = 0; step < motion.control_steps; ++step) {
    world->step(motion.action);
  }
  const WorldState state = world->state();
  return std::max({(state.pusher_position - motion.end.pusher_position).norm(),
                   (state.tee_position - motion.end.tee_position).norm(),
                   PhysicsOfKind::kLever * std::abs(wrapAngle(state.tee_yaw - motion.end.tee_yaw))});
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming)
void PrintTo(const ConvergenceSubject& convergence, std::ostream* out) { PrintTo(convergence.subject, out); }

void ConvergenceSuite::SetUpTestSuite() {}

TEST_P(ConvergenceSuite, ErrorsOfExactMotionsAreAsTheKindClaims) {
  constexpr double kTolerance = 0.02;
  const auto& [subject, parameter, claims] = GetParam();
  for (const NamedExactMotion& named : exactMotions()) {
    const auto motion = named.make(subject.physics);
    const auto claim = std::find_if(claims.begin(), claims.end(),
                                    [&](const ConvergenceClaim& each) { return each.motion == named.name; });
    if (!motion) {
      EXPECT_TRUE(claim == claims.end()) << named.name << ": a claim of a motion that it does not have";
      continue;
    }
    std::vector<double> errors;  // [m] by growing divisor
    std::string found = std::string(named.name) + ": error [m] at the default substep";
    for (const int divisor : {1, 2, 5, 10, 20}) {
      if (divisor == 1 || !parameter.empty()) {
        errors.push_back(errorOf(GetParam(), *motion, kSubstep / divisor));
        found += (divisor == 1 ? " " : ", a " + std::to_string(divisor) + "th ") + significantText(errors.back(), 4);
      }
    }
    if (claim == claims.end()) {
      ADD_FAILURE() << found << ": needs a claim";
      continue;
    }
    EXPECT_NEAR(errors.front(), claim->error, kTolerance * claim->error) << found;
    if (errors.size() > 1) {
      const double order = std::log10(errors[1] / errors.back());
      EXPECT_GE(order, claim->least_order) << found;
      EXPECT_LE(order, claim->greatest_order) << found;
    }
  }
}

}  // namespace pusht::testing
