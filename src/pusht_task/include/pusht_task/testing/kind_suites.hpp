// SPDX-License-Identifier: BSD-3-Clause
/// All suites that every kind of simulator must pass, over your kind with some settings of its parameters. At the top
/// level of one source of its test:
///
///   std::vector<pusht::testing::Subject> subjects() { return {{mineKind()}, {mineKind(), {{"friction", "0.3"}}}}; }
///   PUSHT_TEST_SIMULATOR_KIND(Mine, subjects());
///
/// A subject claims to have the task's physics, as MuJoCo has it. What yours does otherwise, state as data: numbers,
/// what it does not have, and how near it comes (Subject::physics).
#pragma once

#include "pusht_task/testing/batch_simulator_suite.hpp"
#include "pusht_task/testing/physics_suite.hpp"
#include "pusht_task/testing/simulator_suite.hpp"

// NOLINTNEXTLINE(cppcoreguidelines-macro-usage): gtest's is one
#define PUSHT_TEST_SIMULATOR_KIND(name, subjects)                                     \
  namespace pusht::testing {                                                          \
  INSTANTIATE_TEST_SUITE_P(name, SimulatorSuite, ::testing::ValuesIn(subjects));      \
  INSTANTIATE_TEST_SUITE_P(name, BatchSimulatorSuite, ::testing::ValuesIn(subjects)); \
  INSTANTIATE_TEST_SUITE_P(name, PhysicsSuite, ::testing::ValuesIn(subjects));        \
  }                                                                                   \
  static_assert(true, "so that a semicolon follows")
