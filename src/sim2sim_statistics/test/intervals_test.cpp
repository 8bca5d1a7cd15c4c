// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/intervals.hpp"

#include <gtest/gtest.h>

#include <boost/math/constants/constants.hpp>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <random>
#include <stdexcept>
#include <vector>

namespace sim2sim {
namespace {

constexpr double kPi = boost::math::constants::pi<double>();
const double kNan = std::numeric_limits<double>::quiet_NaN();

/// Twelve divergences [m], one of them zero.
const std::vector<double> kTwelve = {0.01, 0.02, 0.03, 0.05, 0.06, 0.07, 0.08, 0.10, 0.15, 0.31, 0.0, 0.12};
const std::vector<double> kTen(kTwelve.begin(), kTwelve.begin() + 10);

/// Twenty differences, neither sorted nor symmetric.
std::vector<double> twentyDifferences() {
  std::vector<double> differences(20);
  for (int i = 0; i < 20; ++i) {
    differences[i] = 0.01 * (i * 7 % 20 - 8) + 0.02;
  }
  return differences;
}

std::vector<double> scaled(std::vector<double> samples, double factor) {
  for (double& sample : samples) {
    sample *= factor;
  }
  return samples;
}

void expectNear(const std::optional<Interval>& interval, double low, double high, double tolerance = 1e-10) {
  ASSERT_TRUE(interval);
  EXPECT_NEAR(interval->low, low, tolerance);
  EXPECT_NEAR(interval->high, high, tolerance);
}

std::mt19937_64 seeded(std::uint64_t seed) { return std::mt19937_64(seed); }

/// Share of 4000 intervals of nominally 95 % that hold the truth, within four standard errors.
template <class MakesInterval>
void expectCoverage(double truth, const MakesInterval& make) {
  std::mt19937_64 random = seeded(1);
  constexpr int kRepetitions = 4000;
  int covered = 0;
  for (int i = 0; i < kRepetitions; ++i) {
    const Interval interval = make(random);
    covered += interval.low <= truth && truth <= interval.high ? 1 : 0;
  }
  EXPECT_NEAR(static_cast<double>(covered) / kRepetitions, kConfidence, 4.0 * std::sqrt(0.95 * 0.05 / kRepetitions));
}

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
  EXPECT_EQ(wilsonInterval(0, 50).low, 0.0);
  EXPECT_GT(wilsonInterval(0, 50).high, 0.05);
  EXPECT_EQ(wilsonInterval(50, 50).high, 1.0);
  EXPECT_LT(wilsonInterval(50, 50).low, 0.95);
}

/// Computed with scipy 1.10 (stats.t.ppf) from the formula.
TEST(MeanOf, IsStudentsTOnTheLogarithm) {
  EXPECT_DOUBLE_EQ(meanOf(kTwelve).value, 1.0 / 12.0);
  expectNear(meanOf(kTwelve).interval, 0.04376769058561797, 0.15866600114209325);
  expectNear(meanOf(kTen).interval, 0.04297533500013502, 0.1801963847396575);
}

/// The ends are as far from the mean as each other, as factors; and another unit changes nothing but the unit.
TEST(MeanOf, IsAFactorInAnyUnit) {
  const Estimate meters = meanOf(kTwelve);
  EXPECT_NEAR(meters.interval->low * meters.interval->high, meters.value * meters.value, 1e-15);
  const Estimate millimeters = meanOf(scaled(kTwelve, 1000.0));
  expectNear(millimeters.interval, 1000.0 * meters.interval->low, 1000.0 * meters.interval->high);
}

TEST(MeanOf, StaysWithinItsRange) {
  const std::vector<double> turned = {0.0, 0.0, 0.0, 0.0, kPi, kPi, kPi, kPi, kPi, kPi};
  EXPECT_GT(meanOf(turned).interval->high, kPi);
  EXPECT_EQ(meanOf(turned, kPi).interval->high, kPi);
  EXPECT_EQ(meanOf(turned, kPi).interval->low, meanOf(turned).interval->low);
  EXPECT_GT(meanOf(turned, kPi).interval->low, 0.0);
  const std::vector<double> all_turned(13, kPi);
  EXPECT_LE(meanOf(all_turned, kPi).interval->low, kPi);
  EXPECT_EQ(meanOf(all_turned, kPi).interval->high, kPi);
}

TEST(MeanOf, HasNoIntervalOfTooLittle) {
  std::vector<double> nine = kTen;
  nine.pop_back();
  EXPECT_NEAR(meanOf(nine).value, 0.57 / 9.0, 1e-15);
  EXPECT_FALSE(meanOf(nine).interval);
  EXPECT_EQ(meanOf(std::vector<double>(50, 0.0)).value, 0.0);
  EXPECT_FALSE(meanOf(std::vector<double>(50, 0.0)).interval);
  EXPECT_TRUE(std::isnan(meanOf({}).value));
  EXPECT_FALSE(meanOf({}).interval);
}

TEST(MeanOf, RefusesWhatIsOutOfRange) {
  EXPECT_THROW(meanOf({0.1, -0.1}), std::domain_error);
  EXPECT_THROW(meanOf({0.1, kNan}), std::domain_error);
  EXPECT_THROW(meanOf({0.1, std::numeric_limits<double>::infinity()}), std::domain_error);
  EXPECT_THROW(meanOf({0.1, 3.2}, kPi), std::domain_error);
  EXPECT_NO_THROW(meanOf({0.1, kPi + 1e-12, -1e-12}, kPi));
  try {
    meanOf({3.5}, 3.0);
  } catch (const std::domain_error& error) {
    EXPECT_STREQ(error.what(), "sample 3.5: must be from 0 to 3.0");
  }
}

/// With fewer samples of so long a tail it holds the mean less often: docs/statistics.md has the table.
TEST(MeanOf, CoversTheMeanOfSkewedDistances) {
  std::lognormal_distribution<double> distance(std::log(0.0697), 0.5);
  expectCoverage(0.0697 * std::exp(0.125), [&](std::mt19937_64& random) {
    std::vector<double> samples(200);
    for (double& sample : samples) {
      sample = distance(random);
    }
    return *meanOf(samples).interval;
  });
}

/// Computed with scipy 1.10 (stats.binom.cdf) from the paper's formula: ranks 3 of 12, 2 of 10.
TEST(MedianOf, LiesBetweenOrderStatistics) {
  EXPECT_DOUBLE_EQ(medianOf(kTwelve).value, 0.065);
  expectNear(medianOf(kTwelve).interval, 0.02263118440779611, 0.11473763118440779);
  expectNear(medianOf(kTen).interval, 0.02657657657657658, 0.11711711711711709);
}

/// The samples are the ranks themselves, so that the ends tell which ranks were taken: those next to the outermost
/// ones whose coverage is enough, never farther out, never farther in than the next.
TEST(MedianOf, TakesTheRanksWhoseCoverageIsEnough) {
  for (int n = kFewestEpisodes; n <= 2000; n += 1 + n / 20) {
    std::vector<double> ranks(n);
    for (int i = 0; i < n; ++i) {
      ranks[i] = i + 1.0;
    }
    const Interval interval = *medianOf(ranks).interval;
    const boost::math::binomial heads(n, 0.5);
    const int k = static_cast<int>(interval.low);
    EXPECT_GE(1.0 - 2.0 * cdf(heads, k - 1), kConfidence) << n;
    EXPECT_LT(1.0 - 2.0 * cdf(heads, k), kConfidence) << n;
    EXPECT_NEAR(interval.low + interval.high, n + 1.0, 1e-9) << n;
  }
}

TEST(MedianOf, DoesNotDependOnTheOrderAndStaysAmongItsSamples) {
  std::vector<double> reversed(kTwelve.rbegin(), kTwelve.rend());
  EXPECT_EQ(medianOf(reversed).interval->low, medianOf(kTwelve).interval->low);
  const std::vector<double> same(30, 2.0);
  expectNear(medianOf(same).interval, 2.0, 2.0, 0.0);
}

TEST(MedianOf, HasNoIntervalOfTooLittle) {
  EXPECT_FALSE(medianOf({1.0, 3.0, 2.0}).interval);
  EXPECT_EQ(medianOf({1.0, 3.0, 2.0}).value, 2.0);
  EXPECT_FALSE(medianOf(std::vector<double>(9, 1.0)).interval);
  EXPECT_TRUE(std::isnan(medianOf({}).value));
  EXPECT_THROW(medianOf({1.0, kNan}), std::domain_error);
}

TEST(MedianOf, CoversTheMedianOfSkewedDistances) {
  std::lognormal_distribution<double> distance(0.0, 1.0);
  expectCoverage(1.0, [&](std::mt19937_64& random) {
    std::vector<double> samples(20);
    for (double& sample : samples) {
      sample = distance(random);
    }
    return *medianOf(samples).interval;
  });
}

/// Computed with numpy 1.24 (quantile, whose default is type 7).
TEST(QuantileOf, IsType7) {
  const std::vector<double> sorted = {0.0, 0.01, 0.02, 0.03, 0.05, 0.06, 0.07, 0.08, 0.10, 0.12, 0.15, 0.31};
  EXPECT_EQ(quantileOf(sorted, 0.0), 0.0);
  EXPECT_NEAR(quantileOf(sorted, 0.1), 0.011, 1e-15);
  EXPECT_NEAR(quantileOf(sorted, 0.25), 0.0275, 1e-15);
  EXPECT_NEAR(quantileOf(sorted, 0.9), 0.147, 1e-15);
  EXPECT_EQ(quantileOf(sorted, 1.0), 0.31);
  EXPECT_EQ(quantileOf({4.0}, 0.3), 4.0);
  EXPECT_THROW(quantileOf({}, 0.5), std::domain_error);
  EXPECT_THROW(quantileOf({1.0}, 1.5), std::domain_error);
  EXPECT_THROW(quantileOf({1.0}, kNan), std::domain_error);
}

/// Computed with scipy 1.10 (stats.ttest_1samp, stats.t.interval).
TEST(MeanDifference, IsStudentsT) {
  const Difference difference = meanDifference(twentyDifferences());
  EXPECT_NEAR(difference.value, 0.035, 1e-15);
  expectNear(difference.interval, 0.007311894319798059, 0.06268810568020193);
  ASSERT_TRUE(difference.p);
  EXPECT_NEAR(*difference.p, 0.01594556107568348, 1e-13);
  expectNear(meanDifference(twentyDifferences(), 0.99).interval, -0.002846607429424601, 0.07284660742942459);
}

/// The interval at confidence 1 - p ends at zero: test and interval say the same.
TEST(MeanDifference, TestAndIntervalAgree) {
  const double p = *meanDifference(twentyDifferences()).p;
  EXPECT_NEAR(meanDifference(twentyDifferences(), 1.0 - p).interval->low, 0.0, 1e-12);
}

TEST(MeanDifference, ChangesItsSignWithTheRoles) {
  const Difference forth = meanDifference(twentyDifferences());
  const Difference back = meanDifference(scaled(twentyDifferences(), -1.0));
  EXPECT_EQ(back.value, -forth.value);
  EXPECT_EQ(back.interval->low, -forth.interval->high);
  EXPECT_EQ(*back.p, *forth.p);
}

TEST(MeanDifference, WithoutSpreadHasNoInterval) {
  const Difference tie = meanDifference(std::vector<double>(20, 0.0));
  EXPECT_EQ(tie.value, 0.0);
  EXPECT_FALSE(tie.interval);
  EXPECT_EQ(tie.p, 1.0);
  const Difference constant = meanDifference(std::vector<double>(20, 0.1));
  EXPECT_NEAR(constant.value, 0.1, 1e-15);
  EXPECT_FALSE(constant.interval);
  EXPECT_FALSE(constant.p);
  // Rounding is no spread: with it t would be 17 here.
  std::vector<double> rounding(20, 7.5e-15);
  rounding[0] = 0.0;
  rounding[1] = 7.5e-15 / 2.0;
  EXPECT_FALSE(meanDifference(rounding).interval);
  EXPECT_EQ(meanDifference(rounding).p, 1.0);
}

TEST(MeanDifference, HasNoIntervalOfTooLittle) {
  std::vector<double> nineteen = twentyDifferences();
  nineteen.pop_back();
  EXPECT_FALSE(meanDifference(nineteen).interval);
  EXPECT_FALSE(meanDifference(nineteen).p);
  EXPECT_TRUE(std::isfinite(meanDifference(nineteen).value));
  EXPECT_TRUE(std::isnan(meanDifference({}).value));
  EXPECT_THROW(meanDifference({kNan}), std::domain_error);
  EXPECT_THROW(meanDifference(twentyDifferences(), 1.0), std::domain_error);
  EXPECT_THROW(meanDifference(twentyDifferences(), 0.0), std::domain_error);
}

}  // namespace
}  // namespace sim2sim
