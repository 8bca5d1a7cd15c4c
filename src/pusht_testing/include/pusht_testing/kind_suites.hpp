// SPDX-License-Identifier: BSD-3-Clause
/// All suites that every kind of simulator must pass, over your kind with some settings of its parameters. In one
/// source of its test, in any namespace:
///
///   std::vector<pusht::testing::Subject> subjects() { return {{mineKind()}, {mineKind(), {{"friction", "0.3"}}}}; }
///   PUSHT_TEST_SIMULATOR_KIND(Mine, subjects());
///
/// A subject claims to have the task's physics, as MuJoCo has it. What yours does otherwise, state as data: numbers,
/// what it does not have, and how near it comes (Subject::physics).
#pragma once

#include <vector>

#include "pusht_task/simulator.hpp"
#include "pusht_task/types.hpp"
#include "pusht_testing/subject.hpp"

namespace pusht::testing {

// A program that instantiates a suite is linked with its tests, as SetUpTestSuite() is defined beside them.

/// Contract of every Simulator.
class SimulatorSuite : public SubjectSuite {
 public:
  static void SetUpTestSuite();
};

/// Contract of every BatchSimulator: each lane is a world, bit for bit, its faults included.
class BatchSimulatorSuite : public SubjectSuite {
 public:
  static void SetUpTestSuite();
};

/// Physics that a kind claims to have: closed forms and replays.
class PhysicsSuite : public SubjectSuite {
 public:
  static void SetUpTestSuite();
};

/// The states after the reset and after each of `steps` chasing control steps.
std::vector<WorldState> chaseFrom(Simulator& world, const WorldState& start, int steps);

/// Expects that all components of two states agree to `tolerance` [m, rad, m/s, rad/s].
void expectNear(const WorldState& a, const WorldState& b, double tolerance);

}  // namespace pusht::testing

// NOLINTNEXTLINE(cppcoreguidelines-macro-usage): gtest's is one
#define PUSHT_TEST_SIMULATOR_KIND(name, subjects)                                       \
  namespace name##_kind_suites {                                                        \
    using namespace ::pusht::testing;                                                   \
    INSTANTIATE_TEST_SUITE_P(name, SimulatorSuite, ::testing::ValuesIn(subjects));      \
    INSTANTIATE_TEST_SUITE_P(name, BatchSimulatorSuite, ::testing::ValuesIn(subjects)); \
    INSTANTIATE_TEST_SUITE_P(name, PhysicsSuite, ::testing::ValuesIn(subjects));        \
  }                                                                                     \
  static_assert(true, "so that a semicolon follows")
