// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/planning.hpp"

#include <gtest/gtest.h>

#include <boost/math/distributions/non_central_t.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <stdexcept>

#include "sim2sim_statistics/intervals.hpp"
#include "sim2sim_statistics/pairs.hpp"

namespace sim2sim {
namespace {

std::mt19937_64 randomPlan(std::uint64_t seed) { return std::mt19937_64(seed); }

/// How often Student's t finds a mean difference, in units of the standard deviation, if the differences are normal.
double powerOfT(double difference, int pairs) {
  const double critical = quantile(boost::math::students_t(pairs - 1.0), 0.975);
  const boost::math::non_central_t t(pairs - 1.0, difference * std::sqrt(pairs));
  return 1.0 - cdf(t, critical) + cdf(t, -critical);
}

/// The deviations are those of the shipped policy's differences: angle (20 against 6), angle (6 against a tee that
/// never moves), position (20 against 6). The study of 10 000 episodes found what each number of pairs can show.
TEST(Planning, MatchesTheStudyOfDivergences) {
  struct Row {
    double deviation;
    double at_50;
    double at_200;
    double at_1000;
    double rounding;
  };
  for (const Row& row : {Row{0.464, 0.184, 0.092, 0.041, 0.0005}, Row{0.808, 0.320, 0.160, 0.072, 0.0005},
                         Row{0.0315, 0.0125, 0.0062, 0.0028, 0.00005}}) {
    EXPECT_NEAR(smallestDifference(row.deviation, 50), row.at_50, row.rounding);
    EXPECT_NEAR(smallestDifference(row.deviation, 200), row.at_200, row.rounding);
    EXPECT_NEAR(smallestDifference(row.deviation, 1000), row.at_1000, row.rounding);
  }
}

/// Study of success: between engine settings 27 % of pairs are discordant, against the reference 55 %.
TEST(Planning, MatchesTheStudyOfSuccess) {
  constexpr double kRounding = 0.0005;
  EXPECT_NEAR(*smallestRateDifference(0.27, 50), 0.194, kRounding);
  EXPECT_NEAR(*smallestRateDifference(0.27, 200), 0.101, kRounding);
  EXPECT_NEAR(*smallestRateDifference(0.27, 1000), 0.046, kRounding);
  EXPECT_NEAR(*smallestRateDifference(0.55, 50), 0.287, kRounding);
  EXPECT_NEAR(*smallestRateDifference(0.55, 200), 0.146, kRounding);
  EXPECT_NEAR(*smallestRateDifference(0.55, 1000), 0.066, kRounding);
}

/// What the header says of the normal approximation (scipy 1.10 says the same: stats.nct).
TEST(SmallestDifference, IsFoundNearlyAsOftenAsPlanned) {
  EXPECT_NEAR(powerOfT(smallestDifference(1.0, 20), 20), 0.757, 0.0005);
  EXPECT_NEAR(powerOfT(smallestDifference(1.0, 50), 50), 0.784, 0.0005);
  EXPECT_NEAR(powerOfT(smallestDifference(1.0, 200), 200), 0.796, 0.0005);
  EXPECT_NEAR(powerOfT(smallestDifference(1.0, 10000), 10000), kPower, 0.0005);
}

TEST(EpisodesFor, IsTheInverseOfSmallestDifference) {
  for (const int episodes : {20, 21, 50, 777, 50000}) {
    const double difference = smallestDifference(0.3, episodes);
    EXPECT_EQ(episodesFor(0.3, difference * (1.0 + 1e-9)), episodes);
    EXPECT_EQ(episodesFor(0.3, difference * (1.0 - 1e-9)), episodes + 1);
  }
  EXPECT_EQ(episodesFor(0.001, 10.0), kFewestPairs);
  EXPECT_EQ(episodesFor(0.0, 0.1), kFewestPairs);
  EXPECT_FALSE(episodesFor(1.0, 0.005));
  EXPECT_EQ(smallestDifference(0.0, 50), 0.0);
}

/// Computed with scipy 1.10 (stats.binom.pmf) as a double sum over all outcomes, mid-p values included.
TEST(McNemarPower, MatchesTheSumOverAllOutcomes) {
  EXPECT_NEAR(mcnemarPower(0.27, 0.194, 50), 0.7991639183068626, 1e-8);
  EXPECT_NEAR(mcnemarPower(0.55, 0.146, 200), 0.8002366824222735, 1e-8);
  EXPECT_NEAR(mcnemarPower(0.27, 0.046, 1000), 0.8017987597641556, 1e-8);
  EXPECT_NEAR(mcnemarPower(0.3, 0.0, 100), 0.044993773131418786, 1e-8);
  EXPECT_NEAR(mcnemarPower(0.1, 0.1, 30), 0.1754948787032284, 1e-8);
  EXPECT_NEAR(mcnemarPower(1.0, 0.3, 80), 0.7950554587131489, 1e-8);
  EXPECT_EQ(mcnemarPower(0.5, 0.5, 1), 0.0);
}

/// The test itself, on drawn pairs.
TEST(McNemarPower, IsHowOftenTheTestFindsIt) {
  std::mt19937_64 random = randomPlan(5);
  std::uniform_real_distribution<double> uniform;
  constexpr int kRuns = 2000;
  int found = 0;
  for (int run = 0; run < kRuns; ++run) {
    PairTable table;
    for (int i = 0; i < 60; ++i) {
      const double u = uniform(random);
      table.add(u < 0.15, u >= 0.15 && u < 0.5);
    }
    found += mcnemarMidP(table) <= 0.05 ? 1 : 0;
  }
  const double power = mcnemarPower(0.5, 0.2, 60);
  EXPECT_NEAR(static_cast<double>(found) / kRuns, power, 4.0 * std::sqrt(power * (1.0 - power) / kRuns));
}

TEST(SmallestRateDifference, HasThePlannedPowerAndFallsWithEpisodes) {
  double last = 1.0;
  for (const int episodes : {30, 50, 100, 300, 3000}) {
    const std::optional<double> difference = smallestRateDifference(0.3, episodes);
    ASSERT_TRUE(difference) << episodes;
    EXPECT_LT(*difference, last);
    EXPECT_NEAR(mcnemarPower(0.3, *difference, episodes), kPower, 1e-4);
    last = *difference;
  }
  EXPECT_FALSE(smallestRateDifference(0.1, 20));  // two discordant pairs tell nothing
}

/// Computed with scipy 1.10, trying one number after the other.
TEST(EpisodesForRates, IsWhereThePowerSuffices) {
  EXPECT_EQ(episodesForRates(0.27, 0.194), 51);
  EXPECT_EQ(episodesForRates(0.55, 0.146), 200);
  EXPECT_EQ(episodesForRates(0.2, 0.2), 33);
  EXPECT_EQ(episodesForRates(0.27, 0.1), 206);
  EXPECT_GE(mcnemarPower(0.4, 0.03, *episodesForRates(0.4, 0.03)), kPower);
  EXPECT_LT(mcnemarPower(0.4, 0.03, *episodesForRates(0.4, 0.03) - 1), kPower);
  EXPECT_FALSE(episodesForRates(0.5, 0.001));
}

TEST(Planning, RefusesWhatHasNoMeaning) {
  EXPECT_THROW(smallestDifference(-1.0, 50), std::domain_error);
  EXPECT_THROW(smallestDifference(1.0, 19), std::domain_error);
  EXPECT_THROW(episodesFor(1.0, 0.0), std::domain_error);
  EXPECT_THROW(episodesFor(std::nan(""), 1.0), std::domain_error);
  EXPECT_THROW(mcnemarPower(0.2, 0.3, 50), std::domain_error);
  EXPECT_THROW(mcnemarPower(0.0, 0.0, 50), std::domain_error);
  EXPECT_THROW(mcnemarPower(0.2, 0.1, kMostEpisodes + 1), std::domain_error);
  EXPECT_THROW(mcnemarPower(0.2, 0.1, 0), std::domain_error);
  EXPECT_THROW(smallestRateDifference(1.2, 50), std::domain_error);
  EXPECT_THROW(episodesForRates(0.2, 0.0), std::domain_error);
  EXPECT_THROW(episodesForRates(0.2, 0.21), std::domain_error);
  try {
    smallestDifference(1.0, 5);
  } catch (const std::domain_error& error) {
    EXPECT_STREQ(error.what(), "episodes 5: must be at least 20");
  }
}

}  // namespace
}  // namespace sim2sim
