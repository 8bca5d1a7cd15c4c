// SPDX-License-Identifier: BSD-3-Clause
/// Convergence of a kind as a test suite: how far its worlds are from exact motions (exact_motions.hpp) at the default
/// substep, and with which order of the substep that error falls. A motion without a claim fails with its errors.
/// Beside PUSHT_TEST_SIMULATOR_KIND:
///
///   std::vector<pusht::testing::ConvergenceSubject> convergence() {
///     return {{{mineKind(), {}, physics}, "substep", {{"servo", 1.2e-5, 0.9, 1.1}}}};
///   }
///   PUSHT_TEST_CONVERGENCE(Mine, convergence());
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "pusht_task/constants.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/testing/exact_motions.hpp"
#include "pusht_task/testing/subject.hpp"

namespace pusht::testing {

/// What a kind claims of one exact motion.
struct ConvergenceClaim {
  std::string motion;           ///< a name of kExactMotions
  double error;                 ///< [m] distance from the exact end at the default substep; held to 2 %
  double least_order = 0.0;     ///< [-] of the error, from a half to a twentieth of the default substep
  double greatest_order = 0.0;  ///< [-]
};

/// Subject with the parameter that sets its substep (empty: it is fixed), and a claim for each exact motion that it
/// has.
struct ConvergenceSubject {
  Subject subject;
  std::string substep;
  std::vector<ConvergenceClaim> claims;
};

/// Names the subject in the output of a test.
// NOLINTNEXTLINE(readability-identifier-naming)
inline void PrintTo(const ConvergenceSubject& convergence, std::ostream* out) { PrintTo(convergence.subject, out); }

/// Suite that holds the errors of exact motions against what a kind claims.
class ConvergenceSuite : public ::testing::TestWithParam<ConvergenceSubject> {
 protected:
  /// [m] Distance of a world from the end of a motion; yaw counts at a lever of PhysicsOfKind::kLever.
  static double errorOf(const ExactMotion& motion, double substep) {
    Subject subject = GetParam().subject;
    if (!GetParam().substep.empty()) {
      subject.settings[GetParam().substep] = shortestText(substep);
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
};

TEST_P(ConvergenceSuite, ErrorsOfExactMotionsAreAsTheKindClaims) {
  constexpr double kTolerance = 0.02;
  const auto& [subject, parameter, claims] = GetParam();
  for (const NamedExactMotion& named : kExactMotions) {
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
        errors.push_back(errorOf(*motion, kSubstep / divisor));
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

// NOLINTNEXTLINE(cppcoreguidelines-macro-usage): gtest's is one
#define PUSHT_TEST_CONVERGENCE(name, subjects)                                     \
  namespace pusht::testing {                                                       \
  INSTANTIATE_TEST_SUITE_P(name, ConvergenceSuite, ::testing::ValuesIn(subjects)); \
  }                                                                                \
  static_assert(true, "so that a semicolon follows")
