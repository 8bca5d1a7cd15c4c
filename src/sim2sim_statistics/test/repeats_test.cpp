// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/repeats.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

namespace sim2sim {
namespace {

using Random = std::mt19937_64;

double uniformNumber(Random& random) { return std::uniform_real_distribution<double>()(random); }

double betaNumber(double a, double b, Random& random) {
  const double x = std::gamma_distribution<double>(a)(random);
  return x / (x + std::gamma_distribution<double>(b)(random));
}

/// A policy that succeeds by a coin, whose bias in the reference each start draws from a beta distribution of mean 0.6
/// and concentration 1; in the engine it is two thirds of that. Both get the same noise.
std::vector<PairTable> tossedCoins(int starts, int repeats, Random& random) {
  std::vector<PairTable> tables(static_cast<std::size_t>(starts));
  for (PairTable& table : tables) {
    const double bias = betaNumber(0.6, 0.4, random);
    for (int i = 0; i < repeats; ++i) {
      const double noise = uniformNumber(random);
      table.add(noise < bias, noise < 2.0 / 3.0 * bias);
    }
  }
  return tables;
}

std::vector<StartCount> countsOfSecond(const std::vector<PairTable>& starts) {
  std::vector<StartCount> counts;
  counts.reserve(starts.size());
  for (const PairTable& start : starts) {
    counts.push_back({start.both + start.second_only, start.pairs()});
  }
  return counts;
}

PairTable tableOf(const std::vector<PairTable>& starts) {
  PairTable sum;
  for (const PairTable& start : starts) {
    sum = {sum.both + start.both, sum.first_only + start.first_only, sum.second_only + start.second_only,
           sum.neither + start.neither};
  }
  return sum;
}

bool holdsNumber(const std::optional<Interval>& interval, double number) {
  return interval.value().low <= number && number <= interval.value().high;
}

void expectSameEnds(const std::optional<Interval>& found, const std::optional<Interval>& expected) {
  ASSERT_TRUE(found && expected);
  EXPECT_NEAR(found->low, expected->low, 1e-12);
  EXPECT_NEAR(found->high, expected->high, 1e-12);
}

/// Planted variances are recovered: benchmark `coverage` has the whole tables.
TEST(Repeats, IntervalsHoldPlantedTruths) {
  constexpr int kRuns = 600;
  constexpr double kBetween = 4.0 / 9.0 * 0.6 * 0.4 / 2.0;
  constexpr double kWithin = 0.4 * 0.6 - kBetween;
  constexpr std::array kNames = {"rate", "difference", "ratio", "variance of starts", "variance of repeats"};
  std::array<int, kNames.size()> held{};
  int held_by_episodes = 0;
  Random random(1);  // NOLINT(cert-msc51-cpp): every run draws alike
  for (int run = 0; run < kRuns; ++run) {
    const std::vector<PairTable> starts = tossedCoins(25, 10, random);
    const std::vector<StartCount> counts = countsOfSecond(starts);
    const NoiseSplit split = successNoiseSplit(counts);
    const std::array holds = {
        holdsNumber(repeatedRateInterval(counts), 0.4), holdsNumber(repeatedDifference(starts).interval, -0.2),
        holdsNumber(repeatedRatioInterval(starts), 2.0 / 3.0), holdsNumber(split.starts.interval, kBetween),
        holdsNumber(split.repeats.interval, kWithin)};
    for (std::size_t i = 0; i < holds.size(); ++i) {
      held.at(i) += holds.at(i) ? 1 : 0;
    }
    const PairTable sum = tableOf(starts);
    held_by_episodes += holdsNumber(wilsonInterval(sum.both + sum.second_only, sum.pairs()), 0.4) ? 1 : 0;
  }
  for (std::size_t i = 0; i < held.size(); ++i) {
    EXPECT_GE(held.at(i), 0.93 * kRuns) << kNames.at(i);
  }
  EXPECT_LT(held_by_episodes, 0.85 * kRuns) << "episodes of a start are not independent";
}

/// Repeats that are all alike say nothing more.
TEST(Repeats, AllAlikeAreOneEpisode) {
  Random random(2);  // NOLINT(cert-msc51-cpp): every run draws alike
  const std::vector<PairTable> once = tossedCoins(30, 1, random);
  std::vector<PairTable> often = once;
  for (PairTable& start : often) {
    start = {5 * start.both, 5 * start.first_only, 5 * start.second_only, 5 * start.neither};
  }
  expectSameEnds(repeatedRateInterval(countsOfSecond(often)), repeatedRateInterval(countsOfSecond(once)));
  expectSameEnds(repeatedDifference(often).interval, repeatedDifference(once).interval);
  expectSameEnds(repeatedRatioInterval(often), repeatedRatioInterval(once));
  EXPECT_NEAR(repeatedDifference(often).p.value(), repeatedDifference(once).p.value(), 1e-12);
  EXPECT_EQ(successNoiseSplit(countsOfSecond(often)).repeats.value, 0.0);
}

/// With one episode of each of many starts, Student's t is normal, and all is as of independent episodes.
TEST(Repeats, OfOneEpisodeAreIndependentEpisodes) {
  constexpr double kNormal = 1e-4;
  Random random(3);  // NOLINT(cert-msc51-cpp): every run draws alike
  const std::vector<PairTable> starts = tossedCoins(20'000, 1, random);
  const PairTable sum = tableOf(starts);
  const auto expect_near = [&](const Interval& found, const Interval& expected) {
    EXPECT_NEAR(found.low, expected.low, kNormal);
    EXPECT_NEAR(found.high, expected.high, kNormal);
  };
  expect_near(repeatedRateInterval(countsOfSecond(starts)).value(),
              wilsonInterval(sum.both + sum.second_only, sum.pairs()));
  expect_near(repeatedDifference(starts).interval.value(), tangoInterval(sum).value());
  expect_near(repeatedRatioInterval(starts).value(), tangInterval(sum).value());
}

TEST(Repeats, TestAndIntervalOfADifferenceAgree) {
  Random random(4);  // NOLINT(cert-msc51-cpp): every run draws alike
  int found = 0;
  for (int run = 0; run < 300; ++run) {
    std::vector<PairTable> starts = tossedCoins(12, 2, random);
    const Difference difference = repeatedDifference(starts);
    const bool excludes = !holdsNumber(difference.interval, 0.0);
    EXPECT_EQ(*difference.p <= 0.05, excludes) << *difference.p;
    EXPECT_DOUBLE_EQ(difference.value, tableOf(starts).difference());
    found += excludes ? 1 : 0;
  }
  EXPECT_GT(found, 30);
  EXPECT_LT(found, 270);
}

/// By hand: 10 starts of 2 episodes, rate 0.3; residuals by start are 1.4 (twice), 0.4 (twice) and -0.6 (six times), so
/// the design effect is 10 / 9 * 6.4 / (20 * 0.21) = 1.693, and with half a start of doubt
/// (2.1 * 1.693 + 0.5 * 2) / 2.6 = 1.752. Student's t with 9 degrees is 2.262157; Wilson's formula by an independent
/// program (Python) gives the ends.
TEST(Repeats, RateByHand) {
  const std::vector<StartCount> starts = {{2, 2}, {2, 2}, {1, 2}, {1, 2}, {0, 2},
                                          {0, 2}, {0, 2}, {0, 2}, {0, 2}, {0, 2}};
  const Interval interval = repeatedRateInterval(starts).value();
  EXPECT_NEAR(interval.low, 0.099541198, 1e-6);
  EXPECT_NEAR(interval.high, 0.624275845, 1e-6);
}

TEST(Repeats, WhatNeverHappensMayHappenInEveryStart) {
  const std::vector<StartCount> never(25, {0, 10});
  const Interval interval = repeatedRateInterval(never).value();
  EXPECT_EQ(interval.low, 0.0);
  EXPECT_GT(interval.high, wilsonInterval(0, 25).high) << "as 25 episodes, with Student's t";
  EXPECT_LT(interval.high, 0.2);
  std::vector<StartCount> rarely = never;
  rarely.front().successes = 1;
  EXPECT_GT(repeatedRateInterval(rarely).value().high, 0.06) << "one success does not make 250 episodes independent";
}

TEST(Repeats, VariancesByHand) {
  const NoiseSplit split = noiseSplit({{1.0, 3.0}, {5.0, 7.0}, {100.0}, {}});
  EXPECT_NEAR(split.repeats.value, 2.0, 1e-15);
  EXPECT_NEAR(split.starts.value, 8.0 - 2.0 / 2.0, 1e-14);
  EXPECT_EQ(noiseSplit({{1.0, 3.0}, {2.0, 2.0}}).starts.value, 0.0) << "negative by chance";
  EXPECT_TRUE(std::isnan(noiseSplit({{1.0, 3.0}, {2.0}}).starts.value));
  const NoiseSplit success = successNoiseSplit({{0, 2}, {1, 2}, {2, 2}, {1, 2}});
  EXPECT_NEAR(success.repeats.value, 0.25, 1e-15);
  EXPECT_NEAR(success.starts.value, 0.5 / 3.0 - 0.125, 1e-15);
  EXPECT_FALSE(success.starts.interval);
  EXPECT_FALSE(success.repeats.interval);
}

TEST(Repeats, TooFewStarts) {
  Random random(5);  // NOLINT(cert-msc51-cpp): every run draws alike
  const std::vector<PairTable> starts = tossedCoins(kFewestEpisodes - 1, 50, random);
  EXPECT_FALSE(repeatedRateInterval(countsOfSecond(starts)));
  EXPECT_FALSE(repeatedRatioInterval(starts));
  const Difference difference = repeatedDifference(starts);
  EXPECT_FALSE(difference.interval || difference.p);
  EXPECT_EQ(difference.value, tableOf(starts).difference());
  EXPECT_FALSE(repeatedRatioInterval(std::vector<PairTable>(25, PairTable{0, 0, 1, 1}))) << "the first never succeeds";
}

TEST(Repeats, RefuseCountsThatCannotBe) {
  EXPECT_THROW(repeatedRateInterval({{3, 2}}), std::domain_error);
  EXPECT_THROW(repeatedRateInterval({{-1, 2}}), std::domain_error);
  EXPECT_THROW(successNoiseSplit({{0, 0}}), std::domain_error);
  EXPECT_THROW(repeatedDifference({PairTable{}}), std::domain_error);
  EXPECT_THROW(repeatedRatioInterval({PairTable{-1, 2, 0, 0}}), std::domain_error);
}

/// Starts of one pair each: (both, first only, second only, neither) of each policy in turn.
std::vector<PairTable> startsOf(const std::vector<PairTable>& tables) {
  std::vector<PairTable> starts;
  for (const PairTable& table : tables) {
    starts.insert(starts.end(), table.both, {1, 0, 0, 0});
    starts.insert(starts.end(), table.first_only, {0, 1, 0, 0});
    starts.insert(starts.end(), table.second_only, {0, 0, 1, 0});
    starts.insert(starts.end(), table.neither, {0, 0, 0, 1});
  }
  return starts;
}

/// Each kind of start of one policy meets all kinds of the other in the same shares, so their residuals do not
/// correlate.
TEST(DifferenceOfRatios, OfUnrelatedPoliciesAddsTheSquaresOfTheDistances) {
  const PairTable first{24, 16, 8, 16};
  std::vector<PairTable> second_by_kind;
  for (const int count : {24, 16, 8, 16}) {
    second_by_kind.push_back({count / 2, count / 8, count / 4, count / 8});
  }
  const Difference found = differenceOfRatios(startsOf({first}), startsOf(second_by_kind));
  EXPECT_NEAR(found.value, 48.0 / 40.0 - 32.0 / 40.0, 1e-12);
  const Interval less = tangInterval(first).value();
  const Interval more = tangInterval({32, 8, 16, 8}).value();
  EXPECT_NEAR(found.interval.value().low, 0.4 - std::hypot(1.2 - more.low, less.high - 0.8), 1e-9);
  EXPECT_NEAR(found.interval.value().high, 0.4 + std::hypot(more.high - 1.2, 0.8 - less.low), 1e-9);
  EXPECT_LT(found.p.value(), 0.05);
}

TEST(DifferenceOfRatios, OfAlikePoliciesIsNarrower) {
  const std::vector<PairTable> first = startsOf({{24, 16, 8, 16}});
  std::vector<PairTable> second = first;
  std::swap(second.front(), second.back());
  const Interval alike = differenceOfRatios(first, second).interval.value();
  const Interval unlike = differenceOfRatios(first, {first.rbegin(), first.rend()}).interval.value();
  EXPECT_EQ(differenceOfRatios(first, first).p.value(), 1.0);
  EXPECT_LT(alike.high - alike.low, 0.5 * (unlike.high - unlike.low));
}

/// p is 0.05 where the interval ends at 0, and both agree on either side of it.
TEST(DifferenceOfRatios, HasAProbabilityThatAgreesWithItsInterval) {
  int findings = 0;
  for (int gained = 0; gained <= 20; ++gained) {
    const std::vector<PairTable> second = startsOf({{20 + gained, 20 - gained, 10, 30}});
    const Difference found = differenceOfRatios(startsOf({{20, 20, 10, 30}}), second);
    const bool excludes_zero = found.interval.value().low > 0.0;
    EXPECT_EQ(found.p.value() < 0.05, excludes_zero) << gained;
    findings += excludes_zero ? 1 : 0;
  }
  EXPECT_GT(findings, 0);
  EXPECT_LT(findings, 20);
}

TEST(DifferenceOfRatios, OfRepeatsIsThatOfTheirStarts) {
  const std::vector<PairTable> once = startsOf({{24, 16, 8, 16}});
  const std::vector<PairTable> other(once.rbegin(), once.rend());
  const auto often = [](std::vector<PairTable> starts) {
    for (PairTable& start : starts) {
      start = {5 * start.both, 5 * start.first_only, 5 * start.second_only, 5 * start.neither};
    }
    return starts;
  };
  const Interval of_often = differenceOfRatios(often(once), often(other)).interval.value();
  const Interval of_once = differenceOfRatios(once, other).interval.value();
  EXPECT_NEAR(of_often.high, of_once.high, 0.05) << "Student's t in place of the normal quantile";
  EXPECT_GE(of_often.high, of_once.high);
}

TEST(DifferenceOfRatios, NeedsTenStartsAndSuccessOfBothReferences) {
  const std::vector<PairTable> never(12, {0, 0, 1, 0});
  const std::vector<PairTable> always(12, {1, 0, 0, 0});
  EXPECT_TRUE(std::isnan(differenceOfRatios(never, always).value));
  EXPECT_TRUE(std::isnan(differenceOfRatios(always, never).value));
  const Difference few = differenceOfRatios({9, {1, 0, 0, 0}}, {9, {0, 1, 0, 0}});
  EXPECT_EQ(few.value, -1.0);
  EXPECT_FALSE(few.interval || few.p);
  EXPECT_THROW(differenceOfRatios(never, {}), std::domain_error);
}

}  // namespace
}  // namespace sim2sim
