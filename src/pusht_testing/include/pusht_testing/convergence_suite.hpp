// SPDX-License-Identifier: BSD-3-Clause
/// Convergence of a kind as a test suite: how far its worlds are from exact motions (src/exact_motions.hpp) at the
/// default substep, and with which order of the substep that error falls. A motion without a claim fails with its
/// errors. Beside PUSHT_TEST_SIMULATOR_KIND:
///
///   std::vector<pusht::testing::ConvergenceSubject> convergence() {
///     return {{{mineKind(), {}, physics}, "substep", {{"servo", 1.2e-5, 0.9, 1.1}}}};
///   }
///   PUSHT_TEST_CONVERGENCE(Mine, convergence());
#pragma once

#include <gtest/gtest.h>

#include <iosfwd>
#include <string>
#include <vector>

#include "pusht_testing/subject.hpp"

namespace pusht::testing {

/// What a kind claims of one exact motion.
struct ConvergenceClaim {
  std::string motion;           ///< a name of exactMotions()
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
void PrintTo(const ConvergenceSubject& convergence, std::ostream* out);

/// Suite that holds the errors of exact motions against what a kind claims.
class ConvergenceSuite : public ::testing::TestWithParam<ConvergenceSubject> {
 public:
  static void SetUpTestSuite();  ///< defined beside the test, so that a program which instantiates the suite has it
};

}  // namespace pusht::testing

// NOLINTNEXTLINE(cppcoreguidelines-macro-usage): gtest's is one
#define PUSHT_TEST_CONVERGENCE(name, subjects)                                       \
  namespace name##_convergence_suite {                                               \
    using namespace ::pusht::testing;                                                \
    INSTANTIATE_TEST_SUITE_P(name, ConvergenceSuite, ::testing::ValuesIn(subjects)); \
  }                                                                                  \
  static_assert(true, "so that a semicolon follows")
