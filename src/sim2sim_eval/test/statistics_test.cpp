// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/results/statistics.hpp"

#include <gtest/gtest.h>

#include <boost/math/distributions/normal.hpp>
#include <cmath>

#include "pusht_task/spawn.hpp"

namespace sim2sim {
namespace {

/// Wilson's interval is where |p - p0| = z sqrt(p0 (1 - p0) / n): its ends solve that equation.
TEST(WilsonInterval, EndsSolveTheScoreEquation) {
  const double z = boost::math::quantile(boost::math::normal(), 0.975);
  for (const int n : {1, 2, 10, 50, 1000}) {
    for (int successes = 0; successes <= n; successes += 1 + n / 10) {
      const double p = static_cast<double>(successes) / n;
      const Interval interval = wilsonInterval(successes, n);
      for (const double end : {interval.low, interval.high}) {
        EXPECT_NEAR(std::abs(p - end), z * std::sqrt(end * (1.0 - end) / n), 1e-7) << successes << "/" << n;
      }
      EXPECT_LE(interval.low, p);
      EXPECT_GE(interval.high, p);
    }
  }
}

/// The course's own figures for 31 and 10 of 50.
TEST(WilsonInterval, MatchesTheCourse) {
  EXPECT_NEAR(wilsonInterval(31, 50).low, 0.48, 0.005);
  EXPECT_NEAR(wilsonInterval(31, 50).high, 0.74, 0.005);
  EXPECT_NEAR(wilsonInterval(10, 50).low, 0.11, 0.005);
  EXPECT_NEAR(wilsonInterval(10, 50).high, 0.33, 0.005);
}

TEST(WilsonInterval, NeverLeavesZeroToOne) {
  EXPECT_NEAR(wilsonInterval(0, 50).low, 0.0, 1e-15);
  EXPECT_GE(wilsonInterval(0, 50).low, 0.0);
  EXPECT_GT(wilsonInterval(0, 50).high, 0.05);
  EXPECT_LE(wilsonInterval(50, 50).high, 1.0);
  EXPECT_LT(wilsonInterval(50, 50).low, 0.95);
}

/// For two samples t has one degree of freedom, whose quantile is tan(pi (p - 1/2)).
TEST(MeanOf, TwoSamplesHaveAClosedForm) {
  const Mean mean = meanOf({1.0, 3.0});
  const double half_width = std::tan(std::acos(-1.0) * (0.975 - 0.5)) * 1.0;
  EXPECT_EQ(mean.value, 2.0);
  ASSERT_TRUE(mean.interval);
  EXPECT_NEAR(mean.interval->low, 2.0 - half_width, 1e-9);
  EXPECT_NEAR(mean.interval->high, 2.0 + half_width, 1e-9);
}

TEST(MeanOf, OfDistancesIsShownAsFarAsItCanBe) {
  const std::optional<Interval> interval = meanOf({0.0, 1.0}).interval;
  EXPECT_LT(interval->low, 0.0);
  EXPECT_EQ(aboveZero(interval)->low, 0.0);
  EXPECT_EQ(aboveZero(interval)->high, interval->high);
  EXPECT_EQ(aboveZero(meanOf({2.0, 2.1}).interval)->low, meanOf({2.0, 2.1}).interval->low);
  EXPECT_FALSE(aboveZero(std::nullopt));
}

TEST(MeanOf, OneSampleHasNoInterval) {
  EXPECT_EQ(meanOf({0.5}).value, 0.5);
  EXPECT_FALSE(meanOf({0.5}).interval);
}

/// An interval must hold the truth as often as it says: here the sum of twelve uniforms, nearly normal.
TEST(MeanOf, IntervalCoversTheTruth) {
  pusht::NumpyGenerator random(1);
  constexpr int kTrials = 4000;
  int covered = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<double> samples(10);
    for (double& sample : samples) {
      for (int i = 0; i < 12; ++i) {
        sample += random.random();
      }
    }
    const Mean mean = meanOf(samples);
    covered += mean.interval->low <= 6.0 && 6.0 <= mean.interval->high ? 1 : 0;
  }
  EXPECT_NEAR(static_cast<double>(covered) / kTrials, kConfidence, 4.0 * std::sqrt(0.95 * 0.05 / kTrials));
}

}  // namespace
}  // namespace sim2sim
