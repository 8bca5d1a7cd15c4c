// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_audit/property.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "experiments.hpp"
#include "pusht_task/constants.hpp"
#include "sim2sim_audit/audit.hpp"
#include "sim2sim_audit/bench.hpp"

namespace sim2sim {
namespace {

TEST(Properties, AreDescribedInTheOrderOfTheEnumeration) {
  ASSERT_EQ(allProperties().size(), kPropertyCount);
  for (std::size_t i = 0; i < kPropertyCount; ++i) {
    EXPECT_EQ(allProperties()[i].property, static_cast<Property>(i)) << allProperties()[i].key;
  }
}

TEST(Properties, HaveKeysOfTheirOwn) {
  std::set<std::string> keys;
  for (const PropertyDescription& description : allProperties()) {
    EXPECT_TRUE(keys.insert(description.key).second) << description.key;
  }
}

/// The contract is what comes first, and the areas agree.
TEST(Properties, AreOfTheContractByTheirArea) {
  for (const PropertyDescription& description : allProperties()) {
    EXPECT_EQ(isContract(description.property), description.area <= Area::kTimeAndAction) << description.key;
  }
}

/// Else two differences would take each other back.
TEST(Properties, FollowFromEachOtherInOneDirection) {
  for (const PropertyDescription& description : allProperties()) {
    for (const Property cause : description.follows_from) {
      EXPECT_NE(cause, description.property) << description.key;
      EXPECT_THAT(describe(cause).follows_from, ::testing::Not(::testing::Contains(description.property)))
          << description.key << " and " << describe(cause).key;
    }
  }
}

TEST(Properties, AreAllEstimated) {
  std::set<Property> estimated;
  for (const Experiment& experiment : allExperiments()) {
    estimated.insert(experiment.estimates.begin(), experiment.estimates.end());
  }
  EXPECT_EQ(estimated.size(), kPropertyCount);
}

TEST(Causes, SayWhichOfTheTwoWorldsHasTheError) {
  const Comparison in_engine = {Property::kDelay, PropertyVerdict::kDiffers, 0.0, 0.1};
  const Comparison in_reference = {Property::kDelay, PropertyVerdict::kDiffers, 0.1, 0.0};
  EXPECT_THAT(causeOf(in_engine), ::testing::StartsWith("acts 1 control step late"));
  EXPECT_THAT(causeOf(in_reference), ::testing::StartsWith("in the reference: acts 1 control step late"));
}

TEST(DistanceBetween, IsNoneAcrossTheWrapOfTheAngle) {
  pusht::WorldState one;
  pusht::WorldState other;
  one.tee_yaw = pusht::kPi - 1e-6;
  other.tee_yaw = -pusht::kPi + 1e-6;
  EXPECT_NEAR(distanceBetween(one, other), 2e-6 * pusht::kStemOffset, 1e-12);
  other.tee_yaw = 0.0;
  EXPECT_NEAR(distanceBetween(one, other), (pusht::kPi - 1e-6) * pusht::kStemOffset, 1e-12);
}

}  // namespace
}  // namespace sim2sim
