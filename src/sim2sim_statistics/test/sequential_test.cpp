// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/sequential.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

namespace sim2sim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Probability of each kind of pair.
struct Probabilities {
  double both;
  double first_only;
  double second_only;
};

/// The two-mass engine against MuJoCo, at the default parameters (docs/statistics.md).
constexpr Probabilities kDefault = {0.1240, 0.4885, 0.0661};

std::mt19937_64 randomWalk(std::uint64_t seed) { return std::mt19937_64(seed); }

struct Pair {
  bool first;
  bool second;
};

Pair draw(const Probabilities& p, std::mt19937_64& random) {
  const double u = std::uniform_real_distribution<double>()(random);
  const bool only_first = u >= p.both && u < p.both + p.first_only;
  const bool only_second = u >= p.both + p.first_only && u < p.both + p.first_only + p.second_only;
  return {u < p.both || only_first, u < p.both || only_second};
}

template <class Test>
void addTimes(Test& test, int times, bool first, bool second) {
  for (int i = 0; i < times; ++i) {
    test.add(first, second);
  }
}

/// The bet as it is played: pair by pair, ten purses, no logarithms.
class Purses {
 public:
  Purses(double share, double direction) : share_(share), direction_(direction), money_(10, 0.1L) {}

  void add(bool reference, bool engine) {
    const double gain = (engine ? 1.0 : 0.0) - share_ * (reference ? 1.0 : 0.0);
    for (std::size_t j = 0; j < money_.size(); ++j) {
      money_[j] *= 1.0L + direction_ * (0.05L + 0.1L * static_cast<double>(j)) * gain;
    }
  }

  double log() const {
    long double sum = 0.0L;
    for (const long double money : money_) {
      sum += money;
    }
    return static_cast<double>(std::log(sum));
  }

 private:
  double share_;
  double direction_;
  std::vector<long double> money_;
};

TEST(TransferBet, IsTheGameAsItIsPlayed) {
  std::mt19937_64 random = randomWalk(1);
  for (const double share : {0.1, 0.31, 0.5, 1.0}) {
    TransferBet bet(share);
    Purses more(share, 1.0);
    Purses less(share, -1.0);
    for (int i = 0; i < 300; ++i) {
      const Pair pair = draw(kDefault, random);
      bet.add(pair.first, pair.second);
      more.add(pair.first, pair.second);
      less.add(pair.first, pair.second);
      ASSERT_NEAR(bet.logMore(), more.log(), 1e-10);
      ASSERT_NEAR(bet.logLess(), less.log(), 1e-10);
    }
  }
}

/// Computed with mpmath 1.3 in 40 digits. The long runs would over- and underflow a double.
TEST(TransferBet, MatchesArithmeticInManyDigits) {
  TransferBet fifth(0.2);
  TransferBet all(1.0);
  for (TransferBet* bet : {&fifth, &all}) {
    addTimes(*bet, 1240, true, true);
    addTimes(*bet, 4885, true, false);
    addTimes(*bet, 661, false, true);
    addTimes(*bet, 3214, false, false);
  }
  EXPECT_NEAR(fifth.logMore(), 170.34297441087905, 1e-9);
  EXPECT_NEAR(fifth.logLess(), -38.219359670555224, 1e-9);
  EXPECT_NEAR(all.logMore(), -220.62002966018385, 1e-9);
  EXPECT_NEAR(all.logLess(), 1815.0799662712981, 1e-9);
  EXPECT_EQ(fifth.verdict(), Verdict::kKeeps);
  EXPECT_EQ(all.verdict(), Verdict::kDoesNot);
}

/// If the engine keeps exactly the share, no pair is expected to change the money: the mean over all pairs is 1.
TEST(TransferBet, IsFairAtTheShare) {
  const double share = (kDefault.both + kDefault.second_only) / (kDefault.both + kDefault.first_only);
  double more = 0.0;
  double less = 0.0;
  const double neither = 1.0 - kDefault.both - kDefault.first_only - kDefault.second_only;
  for (const auto& [probability, pair] : {std::pair(kDefault.both, Pair{true, true}),
                                          {kDefault.first_only, {true, false}},
                                          {kDefault.second_only, {false, true}},
                                          {neither, {false, false}}}) {
    TransferBet bet(share);
    bet.add(pair.first, pair.second);
    more += probability * std::exp(bet.logMore());
    less += probability * std::exp(bet.logLess());
  }
  EXPECT_NEAR(more, 1.0, 1e-14);
  EXPECT_NEAR(less, 1.0, 1e-14);
}

TEST(TransferBet, DecidesAtFortyTimesTheMoneyAndStaysDecided) {
  TransferBet bet(0.5);
  Purses purses(0.5, 1.0);
  int pairs = 0;
  while (purses.log() < std::log(40.0)) {
    EXPECT_EQ(bet.verdict(), Verdict::kUndecided);
    EXPECT_FALSE(bet.decidedAfter());
    purses.add(false, true);
    bet.add(false, true);
    ++pairs;
  }
  EXPECT_EQ(bet.verdict(), Verdict::kKeeps);
  EXPECT_EQ(bet.decidedAfter(), pairs);
  addTimes(bet, 1000, true, false);
  EXPECT_GT(bet.logLess(), 100.0);
  EXPECT_EQ(bet.verdict(), Verdict::kKeeps);
  EXPECT_EQ(bet.decidedAfter(), pairs);
  EXPECT_EQ(bet.counts().first_only, 1000);
}

/// The words of a decision follow from the interval that is shown beside them: it leaves the share out from the episode
/// on that decides, and not before.
TEST(TransferBet, DecidesAsSoonAsTheSequenceLeavesTheShareOut) {
  std::mt19937_64 random = randomWalk(3);
  for (const double share : {0.1, 0.2, 0.5, 0.9}) {
    TransferBet bet(share);
    for (int i = 0; i < 400 && bet.verdict() == Verdict::kUndecided; ++i) {
      const Pair pair = draw(kDefault, random);
      bet.add(pair.first, pair.second);
      const Interval sequence = transferSequence(bet.counts());
      EXPECT_EQ(bet.verdict() == Verdict::kKeeps, sequence.low >= share) << share << ", " << i;
      EXPECT_EQ(bet.verdict() == Verdict::kDoesNot, sequence.high <= share) << share << ", " << i;
    }
    EXPECT_NE(bet.verdict(), Verdict::kUndecided) << share;
  }
}

TEST(TransferBet, IsNotMovedByPairsWithoutSuccess) {
  TransferBet bet(0.3);
  addTimes(bet, 5000, false, false);
  EXPECT_NEAR(bet.logMore(), 0.0, 1e-14);
  EXPECT_NEAR(bet.logLess(), 0.0, 1e-14);
  EXPECT_EQ(bet.verdict(), Verdict::kUndecided);
}

TEST(TransferBet, RefusesSharesThatItCannotBetOn) {
  for (const double share : {0.0, -0.1, 1.01, kInfinity, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(TransferBet{share}, std::domain_error) << share;
  }
  try {
    TransferBet bet(1.5);
  } catch (const std::domain_error& error) {
    EXPECT_STREQ(error.what(), "share 1.5: must be above 0 and at most 1");
  }
}

/// At the truth each verdict is one in at most 5 % of runs, within four standard errors; well below it, it is found.
TEST(TransferBet, ErrsAsRarelyAsItSays) {
  std::mt19937_64 random = randomWalk(2);
  const double truth = (kDefault.both + kDefault.second_only) / (kDefault.both + kDefault.first_only);
  constexpr int kRuns = 500;
  int keeps = 0;
  int does_not = 0;
  int found = 0;
  for (int run = 0; run < kRuns; ++run) {
    TransferBet at_truth(truth);
    TransferBet below(0.2);
    for (int i = 0; i < 1000; ++i) {
      const Pair pair = draw(kDefault, random);
      at_truth.add(pair.first, pair.second);
      below.add(pair.first, pair.second);
    }
    keeps += at_truth.verdict() == Verdict::kKeeps ? 1 : 0;
    does_not += at_truth.verdict() == Verdict::kDoesNot ? 1 : 0;
    found += below.verdict() == Verdict::kKeeps ? 1 : 0;
  }
  const double most = kErrorRate + 4.0 * std::sqrt(0.05 * 0.95 / kRuns);
  EXPECT_LE(static_cast<double>(keeps) / kRuns, most);
  EXPECT_LE(static_cast<double>(does_not) / kRuns, most);
  EXPECT_GT(keeps + does_not, 0);  // a test that never errs would not be this one
  EXPECT_GT(found, 0.95 * kRuns);
}

/// Computed with mpmath 1.3 and scipy 1.10 (optimize.brentq): where the money is 40. The last is beyond 1.
TEST(TransferSequence, IsWhereTheMoneyIsForty) {
  const Interval short_run = transferSequence({12, 48, 7, 33});
  EXPECT_NEAR(short_run.low, 0.14681637277140133, 1e-10);
  EXPECT_NEAR(short_run.high, 0.5847395043063688, 1e-10);
  const Interval long_run = transferSequence({1240, 4885, 661, 3214});
  EXPECT_NEAR(long_run.low, 0.285392812008466, 1e-10);
  EXPECT_NEAR(long_run.high, 0.3369446164212375, 1e-10);
  const Interval better = transferSequence({10, 12, 40, 38});
  EXPECT_NEAR(better.low, 1.1991664167432639, 1e-10);
  EXPECT_NEAR(better.high, 4.632465666537533, 1e-9);
}

TEST(TransferSequence, BeginsWithEverything) {
  for (const PairTable& nothing : {PairTable{}, PairTable{0, 0, 0, 500}, PairTable{1, 1, 1, 1}}) {
    EXPECT_EQ(transferSequence(nothing).low, 0.0);
    EXPECT_EQ(transferSequence(nothing).high, kInfinity);
  }
  EXPECT_EQ(transferSequence({0, 50, 0, 10}).low, 0.0);
  EXPECT_LT(transferSequence({0, 50, 0, 10}).high, 0.2);
  EXPECT_EQ(transferSequence({0, 0, 50, 10}).high, kInfinity);
  EXPECT_GT(transferSequence({0, 0, 50, 10}).low, 5.0);
}

TEST(TransferSequence, RefusesNegativeCounts) { EXPECT_THROW(transferSequence({1, -1, 1, 1}), std::domain_error); }

TEST(TransferSequence, MirrorsWhenTheRolesSwapAndHoldsWhatWasSeen) {
  std::mt19937_64 random = randomWalk(3);
  PairTable table;
  for (int i = 1; i <= 600; ++i) {
    const Pair pair = draw({0.2, 0.3, 0.3}, random);
    table.add(pair.first, pair.second);
    const Interval interval = transferSequence(table);
    const Interval swapped = transferSequence({table.both, table.second_only, table.first_only, table.neither});
    const double seen = static_cast<double>(table.both + table.second_only) / (table.both + table.first_only);
    if (i > 20) {
      ASSERT_LE(interval.low, seen * (1.0 + 1e-12));
      ASSERT_GE(interval.high, seen * (1.0 - 1e-12));
    }
    if (i > 100) {
      ASSERT_NEAR(interval.low * swapped.high, 1.0, 1e-10);
      ASSERT_NEAR(interval.high * swapped.low, 1.0, 1e-10);
    }
  }
}

/// With few and with many pairs, money falls with the share on one side and grows on the other: one end on each.
TEST(TransferSequence, HasOneEndOnEachSide) {
  for (const PairTable& table : {PairTable{5, 3, 9, 4}, PairTable{120, 480, 70, 330}, PairTable{300, 20, 500, 100}}) {
    double more = kInfinity;
    double less = -kInfinity;
    for (int i = -50; i <= 50; ++i) {
      const double share = std::pow(1.1, i);
      const double now_more = Bets(share, 1).logMoney(table);
      const double now_less = Bets(share, -1).logMoney(table);
      EXPECT_LT(now_more, more);
      EXPECT_GT(now_less, less);
      more = now_more;
      less = now_less;
    }
  }
}

/// Computed with scipy 1.10 (special.betaln).
TEST(AnyDifference, IsAMixtureOfUnfairCoins) {
  AnyDifference few;
  addTimes(few, 17, true, false);
  addTimes(few, 3, false, true);
  EXPECT_NEAR(few.logEvidence(), 3.779637632086942, 1e-12);
  AnyDifference many;
  addTimes(many, 500, false, true);
  addTimes(many, 620, true, false);
  EXPECT_NEAR(many.logEvidence(), 3.149738405355606, 1e-10);
}

/// The mean over both sides of the coin is what it was, and pairs that agree throw none.
TEST(AnyDifference, IsFairIfThereIsNone) {
  for (const auto& [first, second] : {std::pair(0, 0), {1, 0}, {3, 5}, {20, 11}}) {
    AnyDifference test;
    addTimes(test, first, true, false);
    addTimes(test, second, false, true);
    addTimes(test, 30, true, true);
    addTimes(test, 30, false, false);
    AnyDifference heads = test;
    heads.add(true, false);
    AnyDifference tails = test;
    tails.add(false, true);
    EXPECT_NEAR(0.5 * (std::exp(heads.logEvidence()) + std::exp(tails.logEvidence())), std::exp(test.logEvidence()),
                1e-11);
  }
}

/// After k of a kind the money is 2^k / (k + 1): 16 after 7, 28 after 8.
TEST(AnyDifference, DecidesAtFortyTimesTheMoneyAndStaysDecided) {
  AnyDifference test;
  test.add(true, true);
  addTimes(test, 7, false, true);
  EXPECT_NEAR(std::exp(test.logEvidence()), 16.0, 1e-12);
  EXPECT_FALSE(test.differ());
  test.add(false, true);
  EXPECT_TRUE(test.differ());
  EXPECT_EQ(test.decidedAfter(), 9);
  addTimes(test, 8, true, false);
  EXPECT_LT(test.logEvidence(), 0.0);
  EXPECT_TRUE(test.differ());
  addTimes(test, 100, true, false);
  EXPECT_GT(test.logEvidence(), std::log(20.0));
  EXPECT_EQ(test.decidedAfter(), 9);
}

/// Half widths for a standard deviation of 1, computed with Python from the formula.
TEST(DifferenceSequence, HasTheWidthOfTheFormula) {
  DifferenceSequence sequence;
  std::vector<double> half_widths(2001, 0.0);
  for (int i = 1; i <= 2000; ++i) {
    sequence.add(i % 2 == 0 ? 1.0 : -1.0);
    if (i % 50 == 0) {
      ASSERT_TRUE(sequence.interval());
      const double deviation = std::sqrt(i / (i - 1.0));
      half_widths.at(i) = 0.5 * (sequence.interval()->high - sequence.interval()->low) / deviation;
      EXPECT_NEAR(sequence.interval()->high, -sequence.interval()->low, 1e-12);
    }
  }
  EXPECT_NEAR(half_widths[50], 0.5451870546427807, 1e-12);
  EXPECT_NEAR(half_widths[100], 0.3363887725782781, 1e-12);
  EXPECT_NEAR(half_widths[500], 0.13573867256799613, 1e-12);
  EXPECT_NEAR(half_widths[2000], 0.06992439798687392, 1e-12);
  EXPECT_EQ(sequence.sign(), Sign::kUndecided);
}

TEST(DifferenceSequence, WaitsForItsBurnIn) {
  DifferenceSequence sequence;
  for (int i = 0; i < 49; ++i) {
    sequence.add(10.0 + i % 3);
  }
  EXPECT_FALSE(sequence.interval());
  EXPECT_EQ(sequence.sign(), Sign::kUndecided);
  sequence.add(10.0);
  ASSERT_TRUE(sequence.interval());
  EXPECT_EQ(sequence.sign(), Sign::kPositive);
  EXPECT_EQ(sequence.decidedAfter(), 50);
}

TEST(DifferenceSequence, StaysDecidedAndKnowsTheSign) {
  DifferenceSequence sequence;
  for (int i = 0; i < 60; ++i) {
    sequence.add(-1.0 - 0.1 * (i % 2));
  }
  EXPECT_EQ(sequence.sign(), Sign::kNegative);
  for (int i = 0; i < 1000; ++i) {
    sequence.add(5.0 + 0.1 * (i % 2));
  }
  EXPECT_GT(sequence.interval()->low, 0.0);
  EXPECT_EQ(sequence.sign(), Sign::kNegative);
  EXPECT_EQ(sequence.decidedAfter(), 50);
}

/// Far from zero the sum of squares less the square of the sum would keep no digit.
TEST(DifferenceSequence, IsStableFarFromZero) {
  DifferenceSequence near;
  DifferenceSequence far;
  for (int i = 0; i < 400; ++i) {
    const double difference = 0.25 * (i % 4);
    near.add(difference);
    far.add(difference + 1e8);
  }
  EXPECT_NEAR(far.mean() - 1e8, near.mean(), 1e-6);
  EXPECT_NEAR(far.interval()->high - far.interval()->low, near.interval()->high - near.interval()->low, 1e-6);
}

/// Rounding must not decide: nothing moved in any of these pairs.
TEST(DifferenceSequence, HasNoIntervalWithoutSpread) {
  DifferenceSequence sequence;
  for (int i = 0; i < 200; ++i) {
    sequence.add(7.5e-15 * (1.0 + i % 2));
  }
  EXPECT_FALSE(sequence.interval());
  EXPECT_EQ(sequence.sign(), Sign::kUndecided);
  EXPECT_THROW(sequence.add(kInfinity), std::domain_error);
  EXPECT_EQ(sequence.pairs(), 200);
}

/// Skewed differences with mean 0: the sign is called in at most 5 % of runs, within four standard errors.
TEST(DifferenceSequence, ErrsAboutAsRarelyAsItSays) {
  std::mt19937_64 random = randomWalk(4);
  std::lognormal_distribution<double> distance(0.0, 0.5);
  constexpr int kRuns = 500;
  int called = 0;
  for (int run = 0; run < kRuns; ++run) {
    DifferenceSequence sequence;
    for (int i = 0; i < 1000; ++i) {
      sequence.add(distance(random) - std::exp(0.125));
    }
    called += sequence.decidedAfter() ? 1 : 0;
  }
  EXPECT_LE(static_cast<double>(called) / kRuns, kErrorRate + 4.0 * std::sqrt(0.05 * 0.95 / kRuns));
}

}  // namespace
}  // namespace sim2sim
