// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/summary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "run_episodes.hpp"
#include "sim2sim_protocol/results/metrics.hpp"
#include "sim2sim_protocol/results/table.hpp"

namespace sim2sim {
namespace {

using ::testing::HasSubstr;

TEST(Summarize, CountsTheClosedLoopsAndAveragesTheReplay) {
  const Summary summary = summarize(bare(), episodesWith(50, 31, 10));
  EXPECT_EQ(summary.reference.successes, 31);
  EXPECT_EQ(summary.engine.successes, 10);
  EXPECT_NEAR(summary.outcomes.transfer.value(), 10.0 / 31.0, 1e-15);
  EXPECT_NEAR(summary.mean(kEngineReplay, "mean_position_divergence").value, 0.01 * 24.5, 1e-15);
  EXPECT_NEAR(summary.mean(kEngineReplay, "mean_angle_divergence").value, 0.05 * 24.5, 1e-14);
}

TEST(Summarize, TransferIsUndefinedWithoutReferenceSuccess) {
  const Summary summary = summarize(bare(), episodesWith(5, 0, 1));
  EXPECT_FALSE(summary.outcomes.transfer);
  const RunConfiguration configuration = bareConfiguration();
  EXPECT_TRUE(metrics(configuration, summary).at("transfer").is_null());
  EXPECT_THAT(table(configuration, summary), HasSubstr("undefined"));
}

/// Student's t alone would say that the feedback removes up to 3.4 rad, of pi.
TEST(Summarize, IntervalsOfSignedQuantitiesStayInTheirRange) {
  constexpr int kEpisodes = 30;
  std::vector<double> samples(kEpisodes, pusht::kPi);
  samples.front() = -pusht::kPi;
  const Quantity& quantity = kQuantities[quantityIndex("absorbed_angle_divergence")];
  EXPECT_GT(meanDifference(samples).interval.value().high, pusht::kPi);
  const Interval interval = meanOf(samples, quantity).interval.value();
  EXPECT_EQ(interval.high, pusht::kPi);
  EXPECT_EQ(interval.low, meanDifference(samples).interval.value().low);
  for (double& sample : samples) {
    sample = -sample;
  }
  EXPECT_EQ(meanOf(samples, quantity).interval.value().low, -pusht::kPi);
}

/// Paired outcomes: reference 31, engine 10, both 10.
TEST(Summarize, PairsTheOutcomes) {
  const Outcomes outcomes = summarize(bare(), episodesWith(50, 31, 10)).outcomes;
  EXPECT_EQ(outcomes.table.both, 10);
  EXPECT_EQ(outcomes.table.first_only, 21);
  EXPECT_EQ(outcomes.table.second_only, 0);
  EXPECT_EQ(outcomes.table.neither, 19);
  EXPECT_NEAR(outcomes.table.difference(), -21.0 / 50.0, 1e-15);
  EXPECT_NEAR(outcomes.p_exact, std::pow(0.5, 20), 1e-18) << "21 of 21 discordant pairs on one side";
  ASSERT_TRUE(outcomes.difference_interval && outcomes.transfer_interval);
  EXPECT_LT(outcomes.difference_interval->high, 0.0);
  EXPECT_LT(outcomes.transfer_interval->high, 1.0);
}

}  // namespace
}  // namespace sim2sim
