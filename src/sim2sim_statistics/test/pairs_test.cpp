// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/pairs.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <vector>

namespace sim2sim {
namespace {

const double kZ = boost::math::quantile(boost::math::normal(), 0.975);

PairTable swapped(const PairTable& table) { return {table.both, table.second_only, table.first_only, table.neither}; }

/// All tables of `pairs` pairs.
void forEachTable(int pairs, const std::function<void(const PairTable&)>& visit) {
  for (int both = 0; both <= pairs; ++both) {
    for (int first_only = 0; both + first_only <= pairs; ++first_only) {
      for (int second_only = 0; both + first_only + second_only <= pairs; ++second_only) {
        visit({both, first_only, second_only, pairs - both - first_only - second_only});
      }
    }
  }
}

void expectEnds(const std::optional<Interval>& interval, double low, double high, double tolerance) {
  ASSERT_TRUE(interval);
  EXPECT_NEAR(interval->low, low, tolerance);
  EXPECT_NEAR(interval->high, high, tolerance);
}

/// Airway reactivity in 21 children before and after a stem cell transplantation (Bentur et al., 2009). Its intervals
/// and p-values are the worked example of M. W. Fagerland, S. Lydersen and P. Laake, "Recommended tests and confidence
/// intervals for paired binomial proportions" (Statistics in Medicine, 2014): first is after, second before.
TEST(Pairs, MatchTheWorkedExampleOfFagerland) {
  const PairTable airways = {1, 7, 1, 12};
  expectEnds(tangoInterval(airways), -0.517, -0.026, 0.0005);
  expectEnds(tangInterval(airways), 0.065, 0.907, 0.0005);
  EXPECT_NEAR(mcnemarExact(airways), 0.0703, 0.00005);
  EXPECT_NEAR(mcnemarMidP(airways), 0.0391, 0.00005);
}

/// What an independent program found: it searches for the most likely table that has the difference or the ratio
/// numerically (scipy 1.10, optimize.minimize_scalar), where we use the closed forms of the papers.
TEST(Pairs, MatchANumericalSearchForTheMostLikelyTable) {
  expectEnds(tangoInterval({59, 16, 6, 80}), -0.12402343245834008, -0.005433394817170249, 1e-7);
  expectEnds(tangInterval({59, 16, 6, 80}), 0.7475790588858745, 0.9876149301461644, 1e-7);
  expectEnds(tangoInterval({6, 24, 3, 17}), -0.5747650977335065, -0.23777366352953214, 1e-7);
  expectEnds(tangInterval({6, 24, 3, 17}), 0.15850320837126844, 0.5403980326149325, 1e-7);
  expectEnds(tangoInterval({3, 2, 12, 33}), 0.06111240683061966, 0.34470874847776345, 1e-7);
  expectEnds(tangInterval({3, 2, 12, 33}), 1.3376195704136244, 7.135462688895675, 1e-6);
  expectEnds(tangoInterval({0, 30, 0, 20}), -0.7239161026974344, -0.4618143774758937, 1e-7);
  expectEnds(tangInterval({0, 30, 0, 20}), 0.0, 0.1280486274402845, 1e-7);
}

/// Where both always agree, the equations can be solved by hand.
TEST(Pairs, WithoutDiscordantPairsHaveAClosedForm) {
  const double z2 = kZ * kZ;
  expectEnds(tangoInterval({10, 0, 0, 40}), -z2 / (50.0 + z2), z2 / (50.0 + z2), 1e-12);
  expectEnds(tangInterval({10, 0, 0, 40}), 10.0 / (10.0 + z2), (10.0 + z2) / 10.0, 1e-12);
}

/// With every pair discordant the difference is 2 p - 1, p being the rate of the second; and the score is Wilson's.
TEST(TangoInterval, IsWilsonsIfAllPairsAreDiscordant) {
  for (const int successes : {0, 3, 10, 19, 20}) {
    const Interval wilson = wilsonInterval(successes, 20);
    expectEnds(tangoInterval({0, 20 - successes, successes, 0}), 2.0 * wilson.low - 1.0, 2.0 * wilson.high - 1.0,
               1e-12);
  }
}

TEST(TangoInterval, StaysWithinItsRangeAndHoldsWhatWasSeen) {
  forEachTable(11, [](const PairTable& table) {
    const Interval interval = *tangoInterval(table);
    const double seen = (table.second_only - table.first_only) / 11.0;
    EXPECT_GE(interval.low, -1.0);
    EXPECT_LE(interval.high, 1.0);
    EXPECT_LE(interval.low, seen);
    EXPECT_GE(interval.high, seen);
  });
}

TEST(Pairs, MirrorTheirIntervalsWhenTheRolesSwap) {
  forEachTable(10, [](const PairTable& table) {
    const Interval difference = *tangoInterval(table);
    expectEnds(tangoInterval(swapped(table)), -difference.high, -difference.low, 1e-9);
    const std::optional<Interval> ratio = tangInterval(table);
    const std::optional<Interval> inverse = tangInterval(swapped(table));
    if (ratio && inverse && ratio->low > 0.0) {
      EXPECT_NEAR(inverse->high * ratio->low, 1.0, 1e-8);
      EXPECT_NEAR(ratio->high * inverse->low, 1.0, 1e-8);
    }
    EXPECT_EQ(mcnemarExact(table), mcnemarExact(swapped(table)));
    EXPECT_EQ(mcnemarMidP(table), mcnemarMidP(swapped(table)));
  });
}

TEST(TangInterval, StaysWithinItsRangeAndHoldsWhatWasSeen) {
  forEachTable(11, [](const PairTable& table) {
    const double first = table.both + table.first_only;
    const std::optional<Interval> interval = tangInterval(table);
    ASSERT_EQ(interval.has_value(), first > 0.0);
    if (interval) {
      const double seen = (table.both + table.second_only) / first;
      EXPECT_GE(interval->low, 0.0);
      EXPECT_TRUE(std::isfinite(interval->high));
      EXPECT_LE(interval->low, seen);
      EXPECT_GE(interval->high, seen);
      EXPECT_LT(interval->low, interval->high);
    }
  });
}

TEST(TangInterval, OfAnEngineThatNeverSucceedsBeginsAtZero) {
  const std::optional<Interval> interval = tangInterval({0, 6, 0, 4});
  EXPECT_EQ(interval->low, 0.0);
  EXPECT_GT(interval->high, 0.1);
  EXPECT_LT(interval->high, 1.0);
}

TEST(Pairs, BecomeSurerWithMorePairs) {
  double difference = 2.0;
  double ratio = std::numeric_limits<double>::infinity();
  for (const int times : {1, 2, 10, 100, 10000}) {
    const PairTable table = {2 * times, 6 * times, times, 3 * times};
    const Interval tango = *tangoInterval(table);
    const Interval tang = *tangInterval(table);
    EXPECT_LT(tango.high - tango.low, difference);
    EXPECT_LT(tang.high / tang.low, ratio);
    difference = tango.high - tango.low;
    ratio = tang.high / tang.low;
  }
  EXPECT_LT(difference, 0.01);
}

TEST(Pairs, HaveNoIntervalOfTooFew) {
  EXPECT_FALSE(tangoInterval({1, 4, 2, 2}));
  EXPECT_FALSE(tangInterval({1, 4, 2, 2}));
  EXPECT_TRUE(tangoInterval({1, 4, 2, 3}));
  EXPECT_FALSE(tangInterval({0, 0, 5, 20}));
  EXPECT_FALSE(tangoInterval({}));
}

TEST(Pairs, RefuseNegativeCounts) {
  EXPECT_THROW(tangoInterval({-1, 10, 10, 10}), std::domain_error);
  EXPECT_THROW(tangInterval({10, -1, 10, 10}), std::domain_error);
  EXPECT_THROW(mcnemarExact({10, 10, -1, 10}), std::domain_error);
  EXPECT_THROW(mcnemarMidP({10, 10, 10, -1}), std::domain_error);
}

TEST(PairTable, CountsEachKind) {
  PairTable table;
  table.add(true, true);
  table.add(true, false);
  table.add(true, false);
  for (int i = 0; i < 3; ++i) {
    table.add(false, true);
  }
  for (int i = 0; i < 4; ++i) {
    table.add(false, false);
  }
  EXPECT_EQ(table.both, 1);
  EXPECT_EQ(table.first_only, 2);
  EXPECT_EQ(table.second_only, 3);
  EXPECT_EQ(table.neither, 4);
  EXPECT_EQ(table.pairs(), 10);
}

/// Computed with scipy 1.10 (stats.binomtest, stats.binom.pmf).
TEST(McNemar, IsABinomialTestOfTheDiscordantPairs) {
  EXPECT_NEAR(mcnemarExact({59, 16, 6, 80}), 0.052478790283203125, 1e-14);
  EXPECT_NEAR(mcnemarMidP({59, 16, 6, 80}), 0.03468966484069824, 1e-14);
  EXPECT_NEAR(mcnemarExact({0, 2, 12, 0}), 0.012939453125, 1e-14);
  EXPECT_NEAR(mcnemarMidP({0, 2, 12, 0}), 0.007385253906249991, 1e-14);
}

TEST(McNemar, HasClosedForms) {
  EXPECT_NEAR(mcnemarExact({5, 0, 6, 5}), std::pow(2.0, -5), 1e-15);
  EXPECT_NEAR(mcnemarMidP({5, 0, 6, 5}), std::pow(2.0, -6), 1e-15);
  EXPECT_EQ(mcnemarExact({5, 3, 3, 5}), 1.0);
  EXPECT_NEAR(mcnemarMidP({5, 1, 1, 5}), 0.75, 1e-15);  // half of the two even outcomes of four taken away
  EXPECT_EQ(mcnemarExact({5, 0, 0, 5}), 1.0);
  EXPECT_EQ(mcnemarMidP({5, 0, 0, 5}), 1.0);
  EXPECT_EQ(mcnemarMidP({}), 1.0);
}

TEST(McNemar, MidPIsTheSmallerOneAndBothFallWithTheDifference) {
  double exact = 1.1;
  double mid_p = 1.1;
  for (int second_only = 10; second_only <= 20; ++second_only) {
    const PairTable table = {0, 20 - second_only, second_only, 0};
    EXPECT_LT(mcnemarMidP(table), mcnemarExact(table));
    EXPECT_LT(mcnemarExact(table), exact);
    EXPECT_LT(mcnemarMidP(table), mid_p);
    EXPECT_GT(mcnemarMidP(table), 0.0);
    exact = mcnemarExact(table);
    mid_p = mcnemarMidP(table);
  }
}

/// Among all outcomes of fair coins the exact test calls at most 5 % a difference.
TEST(McNemar, ExactNeverErrsMoreOftenThanItSays) {
  for (int discordant = 1; discordant <= 40; ++discordant) {
    double errors = 0.0;
    double probability = std::pow(0.5, discordant);  // of this number of one kind
    for (int second_only = 0; second_only <= discordant; ++second_only) {
      errors += mcnemarExact({0, discordant - second_only, second_only, 0}) <= 0.05 ? probability : 0.0;
      probability *= static_cast<double>(discordant - second_only) / (second_only + 1.0);
    }
    EXPECT_LE(errors, 0.05) << discordant;
  }
}

/// By hand: 4 x 0.005, then 3 x 0.01, then 2 x 0.03, then 0.04, which must not be below the one before.
TEST(Holm, StepsDown) {
  const std::vector<double> adjusted = holm({0.01, 0.04, 0.03, 0.005});
  ASSERT_EQ(adjusted.size(), 4U);
  EXPECT_DOUBLE_EQ(adjusted[0], 0.03);
  EXPECT_DOUBLE_EQ(adjusted[1], 0.06);
  EXPECT_DOUBLE_EQ(adjusted[2], 0.06);
  EXPECT_DOUBLE_EQ(adjusted[3], 0.02);
}

TEST(Holm, KeepsOneAndNeverExceedsOne) {
  EXPECT_TRUE(holm({}).empty());
  EXPECT_EQ(holm({0.04}), std::vector<double>{0.04});
  EXPECT_EQ(holm({0.9, 0.8, 0.6}), (std::vector<double>{1.0, 1.0, 1.0}));
  EXPECT_EQ(holm({0.0, 1.0}), (std::vector<double>{0.0, 1.0}));
  EXPECT_EQ(holm({0.02, 0.02}), (std::vector<double>{0.04, 0.04}));
  EXPECT_THROW(holm({0.5, 1.5}), std::domain_error);
  EXPECT_THROW(holm({-0.1}), std::domain_error);
  EXPECT_THROW(holm({std::numeric_limits<double>::quiet_NaN()}), std::domain_error);
}

}  // namespace
}  // namespace sim2sim
