// SPDX-License-Identifier: BSD-3-Clause
// The suites over a world without physics, in double and in single precision.
#include <gmock/gmock.h>

#include <limits>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_testing/kind_suites.hpp"
#include "pusht_testing/physics_checks.hpp"
#include "pusht_testing/refusal.hpp"
#include "pusht_testing/toy_world.hpp"

namespace pusht::testing {
namespace {

using ::testing::HasSubstr;

/// What is right for a kind in single precision is refused of one that says more of itself.
TEST(Simulators, InSinglePrecisionMustSaySo) {
  const SimulatorModel toy = Subject{toyKind(ToyWorld::Precision::kSingle, 1e-12)}.load();
  EXPECT_THAT(refusalOf<SimulationFault>([&] { toy.make_world()->reset(spawn(3)); }),
              HasSubstr("must be within 1e-12 of"));
  const auto lanes = toy.make_lanes(2);
  lanes->reset(0, {});
  EXPECT_THROW(lanes->reset(1, spawn(3)), SimulationFault);
  EXPECT_THAT(refusalOf<SimulationFault>([&] { lanes->state(1); }), HasSubstr("must be within 1e-12 of"))
      << "the lane keeps the error";
  EXPECT_EQ(lanes->state(0), WorldState());
  lanes->reset(1, {});
  EXPECT_EQ(lanes->state(1), WorldState());
}

TEST(PhysicsChecks, SayOnceWhatDeviatesMost) {
  const auto world = Subject{toyKind()}.load().make_world();
  const Deviations deviations = physics::servo(*world, {});
  EXPECT_TRUE(deviations.any());
  EXPECT_THAT(deviations.summary(),
              ::testing::MatchesRegex("[0-9]+ of 24 figures deviate; most: servo from .*, must be .*"));
  Deviations some;
  EXPECT_FALSE(some.any());
  EXPECT_EQ(some.summary(), "");
  some.expectNear("near", 1.0, 1.0, 0.1);
  some.expectNear("far [m]", 2.0, 1.0, 0.1);
  some.expectNear("farther [m]", 4.0, 1.0, 0.1);
  some.expectNear("loose [m]", 9.0, 1.0, 5.0);
  EXPECT_EQ(some.summary(), "3 of 4 figures deviate; most: farther [m]: 4, must be 1 +- 0.1");
  some.expect(false, "the tee is not pushed");
  some.expectNear("none [m]", std::numeric_limits<double>::quiet_NaN(), 1.0, 0.1);
  EXPECT_EQ(some.summary(), "5 of 6 figures deviate; most: the tee is not pushed");
}

std::vector<Subject> toys() { return {{toyKind()}, {toyKind(ToyWorld::Precision::kSingle, 1e-6)}}; }

}  // namespace

INSTANTIATE_TEST_SUITE_P(Toys, SimulatorSuite, ::testing::ValuesIn(toys()));
INSTANTIATE_TEST_SUITE_P(Toys, BatchSimulatorSuite, ::testing::ValuesIn(toys()));

}  // namespace pusht::testing
