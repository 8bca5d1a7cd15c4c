// SPDX-License-Identifier: BSD-3-Clause
/// The toy keeps the contract of worlds and of lanes. A kind with physics has PUSHT_TEST_SIMULATOR_KIND(Mine,
/// subjects()) in place of both suites here: closed forms, too, and what it does otherwise in Subject::physics.
#include "pusht_testing/kind_suites.hpp"
#include "toy_kind.hpp"

namespace pusht::testing {
namespace {

std::vector<Subject> subjects() { return {{toyKind()}, {toyKind(), {{"reach", "0.1"}}}}; }

}  // namespace

INSTANTIATE_TEST_SUITE_P(Toy, SimulatorSuite, ::testing::ValuesIn(subjects()));
INSTANTIATE_TEST_SUITE_P(Toy, BatchSimulatorSuite, ::testing::ValuesIn(subjects()));

}  // namespace pusht::testing
