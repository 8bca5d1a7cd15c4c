// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/tails.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/distributions/beta.hpp>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <stdexcept>
#include <vector>

namespace sim2sim {
namespace {

const double kNotANumber = std::numeric_limits<double>::quiet_NaN();

/// Twenty divergences [m] over seven decades; two episodes part.
const std::vector<double> kFewPart = {3e-7, 0.0,  5e-6, 0.081, 2e-5, 8e-7, 1e-4, 4e-6, 0.012, 6e-5,
                                      9e-8, 7e-6, 2e-7, 3e-5,  1e-6, 9e-6, 4e-4, 6e-7, 1e-8,  2e-6};
/// Another simulator in the same episodes.
const std::vector<double> kOthers = {2e-6, 1e-7, 7e-4, 0.034, 3e-3, 1e-6, 5e-5, 9e-6, 0.048, 2e-3,
                                     4e-7, 1e-5, 3e-6, 2e-4,  8e-6, 5e-6, 1e-3, 4e-6, 6e-8,  7e-5};
constexpr double kExtreme = 0.1;  // [m]

/// The error of the saddlepoint approximation, as a probability.
constexpr double kSaddlepoint = 0.002;

/// Samples less a mean, and one more.
std::vector<double> residuals(const std::vector<double>& samples, double one_more, double mean) {
  std::vector<double> values(samples);
  values.push_back(one_more);
  for (double& value : values) {
    value -= mean;
  }
  return values;
}

/// The probability that the sum of the values, each times a standard exponential variable, is at most zero, in closed
/// form: partial fractions of its characteristic function, summed over the sign that fewer values have. No two of these
/// may be equal.
double exactProbability(const std::vector<double>& values) {
  const auto positive = std::count_if(values.begin(), values.end(), [](double value) { return value > 0.0; });
  const double sign = 2 * positive < static_cast<std::ptrdiff_t>(values.size()) ? 1.0 : -1.0;
  double probability = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    double term = sign * values[i] > 0.0 ? 1.0 : 0.0;
    for (std::size_t j = 0; j < values.size(); ++j) {
      term *= j == i ? 1.0 : values[i] / (values[i] - values[j]);
    }
    probability += term;
  }
  return sign > 0.0 ? 1.0 - probability : probability;
}

std::vector<double> zerosAndOnes(int zeros, int ones) {
  std::vector<double> samples(zeros, 0.0);
  samples.resize(zeros + ones, 1.0);
  return samples;
}

std::vector<double> multiplied(std::vector<double> samples, double factor) {
  for (double& sample : samples) {
    sample *= factor;
  }
  return samples;
}

std::vector<double> differencesOf(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> differences(a.size());
  std::transform(a.begin(), a.end(), b.begin(), differences.begin(), std::minus<>());
  return differences;
}

void expectNear(const Interval& found, const Interval& expected, double relative) {
  EXPECT_NEAR(found.low, expected.low, relative * std::abs(expected.low));
  EXPECT_NEAR(found.high, expected.high, relative * std::abs(expected.high));
}

/// Clopper and Pearson's ends are quantiles of beta distributions.
TEST(TailMeanInterval, OfZerosAndOnesIsClopperAndPearsons) {
  for (const int n : {20, 50, 1000}) {
    for (const int ones : {0, 1, 2, 5, n / 2, n - 1, n}) {
      const Interval interval = *tailMeanInterval(zerosAndOnes(n - ones, ones), 1.0);
      const double low = ones == 0 ? 0.0 : quantile(boost::math::beta_distribution<>(ones, n - ones + 1.0), 0.025);
      const double high = ones == n ? 1.0 : quantile(boost::math::beta_distribution<>(ones + 1.0, n - ones), 0.975);
      EXPECT_NEAR(interval.low, low, ones == 1 ? 0.025 * low : 0.003 * low) << ones << " of " << n;
      EXPECT_NEAR(interval.high, high, 0.006 * high) << ones << " of " << n;
    }
  }
}

TEST(TailMeanInterval, LeavesTwoAndAHalfPercentBeyondEitherEnd) {
  const Interval interval = *tailMeanInterval(kFewPart, kExtreme);
  EXPECT_NEAR(exactProbability(residuals(kFewPart, -1e-12, interval.low)), 0.025, kSaddlepoint);
  EXPECT_NEAR(exactProbability(residuals(kFewPart, kExtreme, interval.high)), 0.975, kSaddlepoint);
}

/// The weights drawn, plainly: spacings are exponential variables over their sum.
TEST(TailMeanInterval, IsThatOfWeightsDrawnAtRandom) {
  constexpr int kDraws = 100'000;
  std::mt19937_64 random(1);  // NOLINT(cert-msc51-cpp): every run draws alike
  std::exponential_distribution<double> exponential;
  const Interval interval = *tailMeanInterval(kFewPart, kExtreme);
  int below = 0;
  int above = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    double weights = 0.0;
    double sum = 0.0;
    for (const double sample : kFewPart) {
      const double weight = exponential(random);
      weights += weight;
      sum += weight * sample;
    }
    const double one_more = exponential(random);
    below += sum / (weights + one_more) < interval.low ? 1 : 0;
    above += (sum + one_more * kExtreme) / (weights + one_more) > interval.high ? 1 : 0;
  }
  const double error = std::sqrt(0.025 * 0.975 / kDraws);
  EXPECT_NEAR(static_cast<double>(below) / kDraws, 0.025, kSaddlepoint + 3.0 * error);
  EXPECT_NEAR(static_cast<double>(above) / kDraws, 0.025, kSaddlepoint + 3.0 * error);
}

TEST(TailMeanInterval, DependsNeitherOnUnitNorOnOrder) {
  const Interval interval = *tailMeanInterval(kFewPart, kExtreme);
  const Interval millimeters = *tailMeanInterval(multiplied(kFewPart, 1000.0), 1000.0 * kExtreme);
  expectNear(millimeters, {1000.0 * interval.low, 1000.0 * interval.high}, 1e-9);
  expectNear(*tailMeanInterval({kFewPart.rbegin(), kFewPart.rend()}, kExtreme), interval, 1e-9);
}

/// A larger sample takes the place of the extreme; the lower end does not depend on it.
TEST(TailMeanInterval, KnowsTheExtremeAtItsUpperEndOnly) {
  const Interval interval = *tailMeanInterval(kFewPart, kExtreme);
  const Interval farther = *tailMeanInterval(kFewPart, 2.0 * kExtreme);
  EXPECT_EQ(farther.low, interval.low);
  EXPECT_GT(farther.high, 1.2 * interval.high);
  EXPECT_EQ(tailMeanInterval(kFewPart, 0.0)->high, tailMeanInterval(kFewPart, 0.081)->high);
}

/// Where nothing has parted yet, the upper end tells that three in a hundred episodes may.
TEST(TailMeanInterval, SpeaksWhereNothingWasSeen) {
  const Interval interval = *tailMeanInterval(std::vector<double>(100, 0.0), kExtreme);
  EXPECT_EQ(interval.low, 0.0);
  EXPECT_NEAR(interval.high, kExtreme * (1.0 - std::pow(0.025, 0.01)), 1e-2 * interval.high);
  const Interval all = *tailMeanInterval(std::vector<double>(100, kExtreme), kExtreme);
  EXPECT_NEAR(all.low, kExtreme * std::pow(0.025, 0.01), 1e-4);
  EXPECT_NEAR(all.high, kExtreme, 1e-15);
}

TEST(TailMeanInterval, HasNoneOfTooLittle) {
  EXPECT_FALSE(tailMeanInterval(std::vector<double>(19, 0.1), kExtreme));
  EXPECT_TRUE(tailMeanInterval(std::vector<double>(20, 0.1), kExtreme));
  EXPECT_FALSE(tailMeanInterval({}, kExtreme));
  EXPECT_FALSE(tailMeanInterval(std::vector<double>(50, 0.0), 0.0));
}

/// A share `parting` of episodes parts, by up to 0.1 m; in the others rounding is left.
double divergence(double parting, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform;
  return uniform(random) < parting ? kExtreme * uniform(random) : 1e-6 * uniform(random);
}

/// Over so many samples of 20 episodes, of which 5 % part: how often the interval holds the mean.
template <class MakesInterval>
double coverage(const MakesInterval& make) {
  constexpr int kRepetitions = 2000;
  constexpr double kParting = 0.05;
  constexpr double kMean = 0.5 * (kParting * kExtreme + (1.0 - kParting) * 1e-6);
  std::mt19937_64 random(1);  // NOLINT(cert-msc51-cpp): every run draws alike
  int covered = 0;
  for (int i = 0; i < kRepetitions; ++i) {
    std::vector<double> samples(20);
    std::generate(samples.begin(), samples.end(), [&] { return divergence(kParting, random); });
    const Interval interval = make(samples);
    covered += interval.low <= kMean && kMean <= interval.high ? 1 : 0;
  }
  return static_cast<double>(covered) / kRepetitions;
}

TEST(TailMeanInterval, HoldsTheMeanWhereFewPart) {
  EXPECT_GE(coverage([](const std::vector<double>& samples) { return *tailMeanInterval(samples, kExtreme); }), 0.95);
  EXPECT_LE(coverage([](const std::vector<double>& samples) { return *meanOf(samples).interval; }), 0.70);
}

TEST(TailMeanInterval, RefusesWhatIsOutOfRange) {
  EXPECT_THROW(tailMeanInterval({-0.1, 0.1}, kExtreme), std::domain_error);
  EXPECT_THROW(tailMeanInterval({kNotANumber}, kExtreme), std::domain_error);
  EXPECT_THROW(tailMeanInterval(kFewPart, kNotANumber), std::domain_error);
  try {
    tailMeanInterval(kFewPart, -1.0);
    FAIL();
  } catch (const std::domain_error& error) {
    EXPECT_STREQ(error.what(), "extreme -1.0: must be a finite number of at least 0");
  }
}

TEST(TailRatioInterval, LeavesTwoAndAHalfPercentBeyondEitherEnd) {
  const Interval interval = *tailRatioInterval(kFewPart, kOthers, kExtreme);
  const auto at = [](double ratio, double numerator, double denominator) {
    std::vector<double> values = differencesOf(kFewPart, multiplied(kOthers, ratio));
    values.push_back(numerator - ratio * denominator);
    return exactProbability(values);
  };
  EXPECT_NEAR(at(interval.low, 0.0, kExtreme), 0.025, kSaddlepoint);
  EXPECT_NEAR(at(interval.high, kExtreme, 0.0), 0.975, kSaddlepoint);
}

TEST(TailRatioInterval, TurnsOverWithTheRoles) {
  const Interval forth = *tailRatioInterval(kFewPart, kOthers, kExtreme);
  const Interval back = *tailRatioInterval(kOthers, kFewPart, kExtreme);
  expectNear(back, {1.0 / forth.high, 1.0 / forth.low}, 1e-9);
  EXPECT_LT(forth.low, std::accumulate(kFewPart.begin(), kFewPart.end(), 0.0) /
                           std::accumulate(kOthers.begin(), kOthers.end(), 0.0));
}

/// Against a constant the lower end is that of the mean.
TEST(TailRatioInterval, OverAConstantHasTheLowerEndOfTheMean) {
  const std::vector<double> ones(kFewPart.size(), 1.0);
  EXPECT_NEAR(tailRatioInterval(kFewPart, ones, kExtreme)->low, tailMeanInterval(kFewPart, kExtreme)->low, 1e-12);
}

TEST(TailRatioInterval, HasNoneOfTooLittle) {
  const std::vector<double> zeros(20, 0.0);
  const std::vector<double> ones(20, 1.0);
  EXPECT_FALSE(tailRatioInterval(zeros, ones, kExtreme));
  EXPECT_FALSE(tailRatioInterval(ones, zeros, kExtreme));
  EXPECT_FALSE(tailRatioInterval(zeros, zeros, kExtreme));
  EXPECT_FALSE(tailRatioInterval({1.0, 2.0}, {1.0, 2.0}, kExtreme));
  EXPECT_THROW(tailRatioInterval(ones, {1.0}, kExtreme), std::domain_error);
  EXPECT_THROW(tailRatioInterval(ones, multiplied(ones, -1.0), kExtreme), std::domain_error);
}

TEST(TailRatioToLargest, IsTheLeastOfTheCorrectedRatios) {
  std::vector<double> tenth = kOthers;
  std::for_each(tenth.begin(), tenth.end(), [](double& sample) { sample *= 0.1; });
  const Interval alone = tailRatioToLargest(kFewPart, {kOthers}, kExtreme).value();
  const Interval ratio = tailRatioInterval(kFewPart, kOthers, kExtreme).value();
  EXPECT_EQ(alone.low, ratio.low);
  EXPECT_EQ(alone.high, ratio.high);

  const Interval of_two = tailRatioToLargest(kFewPart, {tenth, kOthers}, kExtreme).value();
  const Interval corrected = tailRatioInterval(kFewPart, kOthers, kExtreme, 0.975).value();
  EXPECT_LE(of_two.low, corrected.low);
  EXPECT_EQ(of_two.high, corrected.high) << "the other ratio is ten times as large";
  EXPECT_LT(corrected.low, ratio.low);
  EXPECT_GT(corrected.high, ratio.high);

  EXPECT_FALSE(tailRatioToLargest(kFewPart, {kOthers, std::vector<double>(20, 0.0)}, kExtreme)) << "a mean is 0";
  EXPECT_THROW(tailRatioToLargest(kFewPart, {}, kExtreme), std::domain_error);
}

TEST(TailDifference, LeavesTwoAndAHalfPercentBeyondEitherEnd) {
  const std::vector<double> differences = differencesOf(kFewPart, kOthers);
  const Difference difference = tailDifference(differences, kExtreme);
  EXPECT_NEAR(difference.value, std::accumulate(differences.begin(), differences.end(), 0.0) / 20.0, 1e-17);
  EXPECT_NEAR(exactProbability(residuals(differences, -kExtreme, difference.interval->low)), 0.025, kSaddlepoint);
  EXPECT_NEAR(exactProbability(residuals(differences, kExtreme, difference.interval->high)), 0.975, kSaddlepoint);
}

TEST(TailDifference, ChangesItsSignWithTheRoles) {
  const Difference forth = tailDifference(differencesOf(kFewPart, kOthers), kExtreme);
  const Difference back = tailDifference(differencesOf(kOthers, kFewPart), kExtreme);
  expectNear(*back.interval, {-forth.interval->high, -forth.interval->low}, 1e-9);
  EXPECT_NEAR(*back.p, *forth.p, 1e-9);
}

/// The interval at confidence 1 - p ends at zero: test and interval say the same.
TEST(TailDifference, TestAndIntervalAgree) {
  std::vector<double> differences = kFewPart;
  for (std::size_t i = 0; i < differences.size(); ++i) {
    differences[i] += 0.02 * static_cast<double>(i % 5) - 0.01;
  }
  const double p = *tailDifference(differences, 0.01).p;
  EXPECT_GT(p, 1e-4);
  EXPECT_LT(p, 0.05);
  EXPECT_NEAR(tailDifference(differences, 0.01, 1.0 - p).interval->low, 0.0, 1e-9);
  EXPECT_GT(tailDifference(differences, 0.01).interval->low, 0.0);
  EXPECT_LT(tailDifference(differences, 0.01, 1.0 - 0.5 * p).interval->low, 0.0);
}

TEST(TailDifference, WithoutAnyIsNotShown) {
  const Difference tie = tailDifference(std::vector<double>(20, 0.0), kExtreme);
  EXPECT_EQ(tie.value, 0.0);
  EXPECT_NEAR(tie.interval->high, kExtreme * (1.0 - std::pow(0.025, 0.05)), 1e-3);
  EXPECT_EQ(tie.interval->low, -tie.interval->high);
  EXPECT_EQ(tie.p, 1.0);
}

TEST(TailDifference, HasNoneOfTooLittle) {
  EXPECT_TRUE(std::isnan(tailDifference({}, kExtreme).value));
  const Difference few = tailDifference(std::vector<double>(19, 0.1), kExtreme);
  EXPECT_NEAR(few.value, 0.1, 1e-15);
  EXPECT_FALSE(few.interval);
  EXPECT_FALSE(few.p);
  const Difference zeros = tailDifference(std::vector<double>(20, 0.0), 0.0);
  EXPECT_FALSE(zeros.interval);
  EXPECT_EQ(zeros.p, 1.0);
  EXPECT_THROW(tailDifference({kNotANumber}, kExtreme), std::domain_error);
  EXPECT_THROW(tailDifference({0.1}, kExtreme, 1.0), std::domain_error);
}

TEST(PairedDifference, IsTheMethodThatHolds) {
  const std::vector<double> few = differencesOf(kFewPart, kOthers);
  const Difference of_few = pairedDifference(few, kExtreme);
  expectNear(*of_few.interval, *tailDifference(few, kExtreme).interval, 0.0);
  EXPECT_EQ(of_few.p, tailDifference(few, kExtreme).p);
  EXPECT_EQ(pairedDifference(few, std::nullopt).p, meanDifference(few).p);
  std::vector<double> even(40, 0.05);
  even.front() = 0.04;
  expectNear(*pairedDifference(even, kExtreme).interval, *meanDifference(even).interval, 0.0);
  EXPECT_GT(pairedDifference(even, 1.0).interval->high, 2.0 * meanDifference(even).interval->high) << "one unseen";
}

TEST(PairedDifference, WithoutAnyHasNoInterval) {
  const Difference tie = pairedDifference(std::vector<double>(20, 0.0), kExtreme);
  EXPECT_FALSE(tie.interval);
  EXPECT_EQ(tie.p, 1.0);
  EXPECT_TRUE(std::isnan(pairedDifference({}, kExtreme).value));
}

TEST(IsCarriedByFew, LooksAtTheLargestAndAtTheUnseen) {
  EXPECT_TRUE(isCarriedByFew(kFewPart, kExtreme));
  const std::vector<double> even(40, 0.05);
  EXPECT_FALSE(isCarriedByFew(even, 0.25));  // the sum is 2, eight times that
  EXPECT_TRUE(isCarriedByFew(even, 0.26));
  std::vector<double> uneven = even;
  uneven[3] = uneven[7] = 0.40;  // 0.80 of 2.70
  EXPECT_FALSE(isCarriedByFew(uneven, kExtreme));
  uneven[7] = -0.44;
  EXPECT_TRUE(isCarriedByFew(uneven, kExtreme));
  EXPECT_FALSE(isCarriedByFew(multiplied(even, -1.0), kExtreme));
  EXPECT_FALSE(isCarriedByFew({0.0, 0.0}, 0.0));
  EXPECT_THROW(isCarriedByFew({kNotANumber}, kExtreme), std::domain_error);
  EXPECT_THROW(isCarriedByFew(even, -1.0), std::domain_error);
}

TEST(ShareOfLargest, IsTheirPartOfTheSum) {
  std::vector<double> samples(50, 1.0);
  EXPECT_DOUBLE_EQ(shareOfLargest(samples), 3.0 / 50.0);  // 5 % of 50, rounded up
  samples[7] = 51.0;
  EXPECT_DOUBLE_EQ(shareOfLargest(samples), 53.0 / 100.0);
  EXPECT_EQ(shareOfLargest({2.0}), 1.0);
  EXPECT_DOUBLE_EQ(shareOfLargest(std::vector<double>(20, 0.1)), 0.05);
  EXPECT_TRUE(std::isnan(shareOfLargest({0.0, 0.0})));
  EXPECT_TRUE(std::isnan(shareOfLargest({})));
  EXPECT_THROW(shareOfLargest({-1.0}), std::domain_error);
}

}  // namespace
}  // namespace sim2sim
