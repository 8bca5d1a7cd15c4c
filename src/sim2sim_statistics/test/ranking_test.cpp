// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/ranking.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "refused.hpp"
#include "sim2sim_statistics/crossed.hpp"
#include "sim2sim_statistics/intervals.hpp"
#include "sim2sim_statistics/planning.hpp"

namespace sim2sim {
namespace {

using Column = std::vector<double>;

std::mt19937_64 rankingNumber(std::uint64_t seed) { return std::mt19937_64(seed); }

/// Success rates of a task by policy: SIMPLER's and the real robot's, and what follows from them.
struct SimplerTask {
  std::string name;
  Column simulated;
  Column real;
  double violation;
  double pearson;
  double spearman;
  double kendall;
};

/// Rates published with SIMPLER (simpler_env/utils/metrics.py). The violations were computed with numpy 1.24 from the
/// definition, and with SIMPLER's own function, to the same bits; the correlations with scipy 1.10.
const std::vector<SimplerTask> kSimpler = {
    {"pick coke can",
     {0.787, 0.857, 0.710, 0.567, 0.027, 0.170},
     {0.907, 0.853, 0.920, 0.760, 0.133, 0.293},
     0.03133333333333336,
     0.975433978718709,
     0.7714285714285715,
     0.6},
    {"move near",
     {0.779, 0.442, 0.354, 0.317, 0.050, 0.042},
     {0.733, 0.633, 0.583, 0.450, 0.017, 0.350},
     0.11099999999999999,
     0.856096688680937,
     0.942857142857143,
     0.8666666666666666},
    {"open drawer",
     {0.157, 0.601, 0.463, 0.296, 0.000, 0.009},
     {0.333, 0.815, 0.704, 0.519, 0.000, 0.148},
     0.0,
     0.9831665170133749,
     1.0,
     1.0},
    {"close drawer",
     {0.343, 0.861, 0.667, 0.891, 0.278, 0.444},
     {0.630, 0.926, 0.889, 0.741, 0.000, 0.519},
     0.12333333333333335,
     0.7712328353682198,
     0.7714285714285715,
     0.6},
    {"place apple",
     {0.037, 0.065, 0.130, 0.213, 0.000, 0.000},
     {0.074, 0.185, 0.185, 0.407, 0.000, 0.000},
     0.0,
     0.9691719566996975,
     0.9851843661437779,
     0.9636241116594316},
    {"carrot on plate",
     {0.042, 0.083, 0.097},
     {0.000, 0.250, 0.083},
     0.11133333333333333,
     0.5713683834061977,
     0.5,
     1.0 / 3.0},
    {"stack cube", {0.000, 0.000, 0.042}, {0.000, 0.000, 0.125}, 0.0, 1.0, 1.0, 1.0}};

TEST(RankFigures, AgreeWithSimpler) {
  for (const SimplerTask& task : kSimpler) {
    EXPECT_NEAR(meanMaximumRankViolation(task.simulated, task.real), task.violation, 1e-12) << task.name;
    EXPECT_NEAR(pearson(task.simulated, task.real), task.pearson, 1e-12) << task.name;
    EXPECT_NEAR(spearman(task.simulated, task.real), task.spearman, 1e-12) << task.name;
    EXPECT_NEAR(kendallTauB(task.simulated, task.real), task.kendall, 1e-12) << task.name;
  }
}

/// The violation is measured in the reference; the correlations have no direction.
TEST(RankFigures, AreThoseOfTheOtherDirection) {
  const SimplerTask& coke = kSimpler.front();
  EXPECT_NEAR(meanMaximumRankViolation(coke.real, coke.simulated), 0.06183333333333335, 1e-12);
  EXPECT_EQ(pearson(coke.real, coke.simulated), pearson(coke.simulated, coke.real));
  EXPECT_EQ(spearman(coke.real, coke.simulated), spearman(coke.simulated, coke.real));
  EXPECT_EQ(kendallTauB(coke.real, coke.simulated), kendallTauB(coke.simulated, coke.real));
}

/// Ties on both sides, computed with scipy 1.10.
TEST(RankFigures, AgreeWithScipyOnTies) {
  const Column first = {3, 1, 4, 1, 5, 9, 2, 6};
  const Column second = {2, 7, 1, 8, 2, 8, 1, 8};
  EXPECT_NEAR(pearson(first, second), 0.2096553190730122, 1e-12);
  EXPECT_NEAR(spearman(first, second), 0.19885368120992467, 1e-12);
  EXPECT_NEAR(kendallTauB(first, second), 0.16051447078102563, 1e-12);
}

/// A tie on one side alone is a violation, as in SIMPLER: the pair is above on one side, and not on the other.
TEST(RankFigures, ViolationOfSmallRankings) {
  EXPECT_EQ(meanMaximumRankViolation({0.1, 0.2, 0.3}, {0.4, 0.5, 0.9}), 0.0);
  EXPECT_DOUBLE_EQ(meanMaximumRankViolation({0.2, 0.1, 0.3}, {0.4, 0.5, 0.9}), 0.2 / 3.0);
  EXPECT_DOUBLE_EQ(meanMaximumRankViolation({0.3, 0.2, 0.1}, {0.4, 0.5, 0.9}), (0.5 + 0.4 + 0.5) / 3.0);
  EXPECT_DOUBLE_EQ(meanMaximumRankViolation({0.5, 0.5}, {0.25, 0.75}), 0.25 + 0.0);
}

TEST(RankFigures, DoNotExistWithoutSpread) {
  const Column equal = {0.1, 0.1, 0.1};
  const Column rising = {0.1, 0.2, 0.3};
  EXPECT_TRUE(std::isnan(pearson(equal, rising)));
  EXPECT_TRUE(std::isnan(spearman(rising, equal)));
  EXPECT_TRUE(std::isnan(kendallTauB(equal, rising)));
}

TEST(RankFigures, RanksIgnoreARisingChange) {
  const SimplerTask& coke = kSimpler.front();
  Column changed = coke.simulated;
  for (double& rate : changed) {
    rate = std::exp(3.0 * rate) - 100.0;
  }
  EXPECT_EQ(spearman(changed, coke.real), spearman(coke.simulated, coke.real));
  EXPECT_EQ(kendallTauB(changed, coke.real), kendallTauB(coke.simulated, coke.real));
  EXPECT_EQ(meanMaximumRankViolation(changed, coke.real), meanMaximumRankViolation(coke.simulated, coke.real));
}

/// Successes by policy, drawn with these rates.
CrossedTable drawnSuccesses(const Column& rates, int starts, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform;
  std::vector<Column> rows;
  for (const double rate : rates) {
    Column row(static_cast<std::size_t>(starts));
    std::generate(row.begin(), row.end(), [&] { return uniform(random) < rate ? 1.0 : 0.0; });
    rows.push_back(row);
  }
  return CrossedTable(rows);
}

/// Successes by policy, as many as counted, in the first starts.
CrossedTable countedSuccesses(const std::vector<int>& counts, int starts) {
  std::vector<Column> rows;
  for (const int count : counts) {
    Column row(static_cast<std::size_t>(starts), 0.0);
    std::fill_n(row.begin(), count, 1.0);
    rows.push_back(row);
  }
  return CrossedTable(rows);
}

CrossedTable failures(const CrossedTable& successes) {
  std::vector<Column> rows;
  for (std::size_t row = 0; row < successes.rows(); ++row) {
    rows.emplace_back();
    for (std::size_t column = 0; column < successes.columns(); ++column) {
      rows.back().push_back(1.0 - successes.at(row, column));
    }
  }
  return CrossedTable(rows);
}

/// Rates of policies that act at random in a share of 0, 5, 10 ... % of their steps, say.
Column worsening(std::size_t policies, double best, double step) {
  Column rates;
  for (std::size_t policy = 0; policy < policies; ++policy) {
    rates.push_back(best - step * static_cast<double>(policy));
  }
  return rates;
}

void expectInOrder(const Estimate& estimate) {
  ASSERT_TRUE(estimate.interval);
  EXPECT_LE(estimate.interval->low, estimate.value);
  EXPECT_LE(estimate.value, estimate.interval->high);
}

TEST(CompareRankings, FindsAPlantedRanking) {
  std::mt19937_64 random = rankingNumber(3);
  const CrossedTable home = drawnSuccesses(worsening(12, 0.8, 0.06), 400, random);
  const CrossedTable away = drawnSuccesses(worsening(12, 0.5, 0.04), 400, random);
  const RankingComparison same = compareRankings(home, away);
  EXPECT_EQ(same.verdict, RankingVerdict::kPreserved);
  EXPECT_GT(same.kendall.interval->low, 0.5);
  EXPECT_GT(same.reference_reliability, 0.95);
  for (const Estimate& estimate : {same.pearson, same.spearman, same.kendall, same.violation}) {
    expectInOrder(estimate);
  }
  EXPECT_LT(same.spearman.interval->low, same.spearman.value - 0.02) << "12 policies are few";
  const RankingComparison turned = compareRankings(home, failures(away));
  EXPECT_EQ(turned.verdict, RankingVerdict::kReversed);
  for (const auto& figure : {&RankingComparison::pearson, &RankingComparison::spearman, &RankingComparison::kendall}) {
    EXPECT_NEAR((turned.*figure).value, -(same.*figure).value, 1e-12);
    EXPECT_NEAR((turned.*figure).interval->low, -(same.*figure).interval->high, 1e-9);
    EXPECT_NEAR((turned.*figure).interval->high, -(same.*figure).interval->low, 1e-9);
  }
  EXPECT_GT(turned.violation.value, 0.3);
}

/// Policies that are all alike, in simulators whose chance is common: the measured rates agree, and say nothing.
TEST(CompareRankings, CannotSayOfAPlantedTie) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U}) {
    std::mt19937_64 random = rankingNumber(seed);
    const CrossedTable home = drawnSuccesses(Column(16, 0.5), 200, random);
    const RankingComparison comparison = compareRankings(home, home);
    EXPECT_NEAR(comparison.kendall.value, 1.0, 1e-12);
    EXPECT_EQ(comparison.verdict, RankingVerdict::kCannotSay);
    EXPECT_LT(comparison.reference_reliability, kLeastReliability);
    EXPECT_FALSE(comparison.pearson.interval);
    EXPECT_FALSE(comparison.spearman.interval);
    EXPECT_FALSE(comparison.kendall.interval);
    EXPECT_FALSE(comparison.violation.interval);
  }
}

TEST(CompareRankings, CannotSayOfUnrelatedRankings) {
  std::mt19937_64 random = rankingNumber(4);
  const CrossedTable home = drawnSuccesses(worsening(12, 0.8, 0.05), 400, random);
  const CrossedTable away =
      drawnSuccesses({0.5, 0.3, 0.7, 0.4, 0.6, 0.2, 0.65, 0.35, 0.55, 0.25, 0.45, 0.6}, 400, random);
  const RankingComparison comparison = compareRankings(home, away);
  EXPECT_EQ(comparison.verdict, RankingVerdict::kCannotSay);
  ASSERT_TRUE(comparison.kendall.interval);
  EXPECT_LT(comparison.kendall.interval->low, 0.0);
  EXPECT_GT(comparison.kendall.interval->high, 0.0);
}

TEST(CompareRankings, CannotSayOfFewPolicies) {
  std::mt19937_64 random = rankingNumber(5);
  const auto comparison_of = [&](std::size_t policies, int starts) {
    return compareRankings(drawnSuccesses(worsening(policies, 0.9, 0.1), starts, random),
                           drawnSuccesses(worsening(policies, 0.9, 0.1), starts, random));
  };
  EXPECT_EQ(comparison_of(8, 400).verdict, RankingVerdict::kPreserved);
  const RankingComparison few = comparison_of(7, 400);
  EXPECT_EQ(few.verdict, RankingVerdict::kCannotSay);
  EXPECT_FALSE(few.pearson.interval);
  EXPECT_FALSE(few.violation.interval);
  EXPECT_GT(few.kendall.value, 0.8);
  EXPECT_EQ(comparison_of(8, 19).verdict, RankingVerdict::kCannotSay);
}

/// One policy that differs from all others makes no correlation.
TEST(CompareRankings, CannotSayWhereOnePolicyMakesTheSpread) {
  const CrossedTable one = countedSuccesses({40, 10, 10, 10, 10, 10, 10, 10, 10, 10}, 50);
  const RankingComparison comparison = compareRankings(one, one);
  EXPECT_GT(comparison.reference_reliability, kLeastReliability);
  EXPECT_EQ(comparison.pearson.value, 1.0);
  EXPECT_FALSE(comparison.pearson.interval);
  EXPECT_EQ(comparison.verdict, RankingVerdict::kCannotSay);
}

TEST(CompareRankings, OfASimulatorWithItselfIsPerfect) {
  std::mt19937_64 random = rankingNumber(6);
  const CrossedTable home = drawnSuccesses(worsening(10, 0.9, 0.08), 300, random);
  const RankingComparison comparison = compareRankings(home, home);
  EXPECT_EQ(comparison.verdict, RankingVerdict::kPreserved);
  EXPECT_DOUBLE_EQ(comparison.pearson.value, 1.0);
  EXPECT_EQ(comparison.violation.value, 0.0);
  EXPECT_EQ(comparison.kendall.interval->high, 1.0);
  EXPECT_EQ(comparison.reference_reliability, comparison.test_reliability);
}

void expectEqualFigures(const Estimate& found, const Estimate& expected, double tolerance) {
  EXPECT_NEAR(found.value, expected.value, tolerance);
  ASSERT_EQ(found.interval.has_value(), expected.interval.has_value());
  if (found.interval) {
    EXPECT_NEAR(found.interval->low, expected.interval->low, tolerance);
    EXPECT_NEAR(found.interval->high, expected.interval->high, tolerance);
  }
}

/// A seed has its bits; another one changes the resampled starts, hence the violation's interval alone.
TEST(CompareRankings, DependsOnTheSeedOnlyInTheViolation) {
  std::mt19937_64 random = rankingNumber(7);
  const CrossedTable home = drawnSuccesses(worsening(10, 0.7, 0.05), 200, random);
  const CrossedTable away = drawnSuccesses(worsening(10, 0.6, 0.03), 200, random);
  const RankingComparison first = compareRankings(home, away);
  const RankingComparison again = compareRankings(home, away, kStartSeed);
  const RankingComparison other = compareRankings(home, away, kStartSeed + 1);
  ASSERT_TRUE(first.violation.interval);
  EXPECT_EQ(first.violation.interval->low, again.violation.interval->low);
  EXPECT_EQ(first.violation.interval->high, again.violation.interval->high);
  EXPECT_NE(first.violation.interval->high, other.violation.interval->high);
  EXPECT_NEAR(first.violation.interval->high, other.violation.interval->high, 0.1 * first.violation.interval->high);
  expectEqualFigures(other.pearson, first.pearson, 0.0);
  expectEqualFigures(other.spearman, first.spearman, 0.0);
  expectEqualFigures(other.kendall, first.kendall, 0.0);
}

TEST(CompareRankings, DoesNotDependOnTheOrderOfPolicies) {
  std::mt19937_64 random = rankingNumber(8);
  const Column rates = worsening(12, 0.7, 0.05);
  const CrossedTable home = drawnSuccesses(rates, 100, random);
  const CrossedTable away = drawnSuccesses(rates, 100, random);
  const auto turned = [](const CrossedTable& table) {
    std::vector<Column> rows;
    for (std::size_t row = table.rows(); row-- > 0;) {
      rows.emplace_back();
      for (std::size_t column = 0; column < table.columns(); ++column) {
        rows.back().push_back(table.at(row, column));
      }
    }
    return CrossedTable(rows);
  };
  const RankingComparison straight = compareRankings(home, away);
  const RankingComparison reversed = compareRankings(turned(home), turned(away));
  expectEqualFigures(reversed.pearson, straight.pearson, 1e-12);
  expectEqualFigures(reversed.spearman, straight.spearman, 1e-12);
  expectEqualFigures(reversed.kendall, straight.kendall, 1e-12);
  expectEqualFigures(reversed.violation, straight.violation, 1e-12);
  for (std::size_t bin = 0; bin < straight.agreement.size(); ++bin) {
    EXPECT_EQ(reversed.agreement.at(bin).pairs, straight.agreement.at(bin).pairs);
    expectEqualFigures(reversed.agreement.at(bin).share, straight.agreement.at(bin).share, 1e-12);
  }
}

TEST(CompareRankings, CorrelationsHaveNoDirection) {
  std::mt19937_64 random = rankingNumber(9);
  const CrossedTable home = drawnSuccesses(worsening(12, 0.7, 0.05), 100, random);
  const CrossedTable away = drawnSuccesses(worsening(12, 0.7, 0.03), 100, random);
  const RankingComparison there = compareRankings(home, away);
  const RankingComparison back = compareRankings(away, home);
  expectEqualFigures(back.pearson, there.pearson, 1e-12);
  expectEqualFigures(back.spearman, there.spearman, 1e-12);
  expectEqualFigures(back.kendall, there.kendall, 1e-12);
  EXPECT_EQ(back.reference_reliability, there.test_reliability);
}

/// Pairs by hand, of 20 starts: reference 0.1, 0.15, 0.3, 0.3, 1; test 0.5, 0.5, 0.25, 0.75, 0.6.
TEST(PairAgreement, CountsPairsByTheirDifference) {
  const RankingComparison comparison =
      compareRankings(countedSuccesses({2, 3, 6, 6, 20}, 20), countedSuccesses({10, 10, 5, 15, 12}, 20));
  const std::array<int, 4> pairs = {0, 1, 2, 6};  // 0.3 ties with 0.3
  const std::array<double, 4> agreeing = {0.0, 0.5, 1.0, 1.0 + 1.0 + 0.0 + 1.0 + 1.0 + 0.0};
  for (std::size_t bin = 0; bin < pairs.size(); ++bin) {
    const PairAgreement& agreement = comparison.agreement.at(bin);
    EXPECT_EQ(agreement.from, kAgreementBins.at(bin));
    EXPECT_EQ(agreement.to, bin + 1 < kAgreementBins.size() ? kAgreementBins.at(bin + 1) : 1.0);
    EXPECT_EQ(agreement.pairs, pairs.at(bin)) << bin;
    EXPECT_FALSE(agreement.share.interval);
    if (agreement.pairs > 0) {
      EXPECT_DOUBLE_EQ(agreement.share.value, agreeing.at(bin) / pairs.at(bin)) << bin;
    } else {
      EXPECT_TRUE(std::isnan(agreement.share.value));
    }
  }
}

/// A difference of 0.05 is in the second bin, also where rounding makes it less: 0.35 - 0.3.
TEST(PairAgreement, BinsDoNotDependOnRounding) {
  for (int count = 0; count < 20; ++count) {
    const CrossedTable table = countedSuccesses({count, count + 1}, 20);
    EXPECT_EQ(compareRankings(table, table).agreement.at(1).pairs, 1) << count;
  }
}

/// All 21 pairs with a difference of at least 0.2 agree. They are of ten policies, hence Wilson's interval of 5 of 5.
TEST(PairAgreement, OfPoliciesThatAllAgree) {
  const CrossedTable table = countedSuccesses({0, 3, 6, 9, 12, 15, 18, 21, 24, 27}, 50);
  const PairAgreement far = compareRankings(table, table).agreement.back();
  EXPECT_EQ(far.pairs, 21);
  EXPECT_EQ(far.share.value, 1.0);
  ASSERT_TRUE(far.share.interval);
  const double t = quantile(boost::math::students_t(9.0), 0.975);
  EXPECT_NEAR(far.share.interval->low, 1.0 / (1.0 + t * t / 5.0), 1e-12);
  EXPECT_DOUBLE_EQ(far.share.interval->high, 1.0);
}

/// Policies with a planted correlation of 0.9 and noise of 100 starts, which lowers the measured one to about 0.75.
TEST(CompareRankings, HoldsTheTrueCorrelationDespiteNoise) {
  std::mt19937_64 random = rankingNumber(10);
  std::normal_distribution<double> normal;
  const double tau = 2.0 / std::acos(-1.0) * std::asin(0.9);
  constexpr int kRuns = 150;
  int given = 0;
  int held = 0;
  int held_without_correction = 0;
  for (int run = 0; run < kRuns; ++run) {
    Column home(24);
    Column away(24);
    for (std::size_t policy = 0; policy < home.size(); ++policy) {
      const double skill = normal(random);
      home[policy] = std::clamp(0.5 + 0.1 * skill, 0.0, 1.0);
      away[policy] = std::clamp(0.5 + 0.1 * (0.9 * skill + std::sqrt(0.19) * normal(random)), 0.0, 1.0);
    }
    const RankingComparison comparison =
        compareRankings(drawnSuccesses(home, 100, random), drawnSuccesses(away, 100, random));
    if (comparison.kendall.interval) {
      const double z = std::atanh(comparison.kendall.value);
      const double plain = std::tanh(z + 1.96 * std::sqrt(0.437 / 20.0));  // Bonett and Wright (2000)
      ++given;
      held += comparison.kendall.interval->low <= tau && tau <= comparison.kendall.interval->high ? 1 : 0;
      held_without_correction += tau <= plain ? 1 : 0;
    }
  }
  EXPECT_GE(given, 0.9 * kRuns);
  EXPECT_GE(held, 0.92 * given);
  EXPECT_LE(held_without_correction, 0.75 * given);
}

/// Computed with scipy 1.10 (stats.norm) from the formulas.
TEST(KendallPower, MatchesTheFormula) {
  EXPECT_NEAR(kendallPower(0.5, 20), 0.9316017937363894, 1e-10);
  EXPECT_NEAR(kendallPower(0.3, 50), 0.8910789865590707, 1e-10);
  EXPECT_NEAR(kendallPower(0.7, 10), 0.9334582033168464, 1e-10);
}

/// Normal policies, measured without noise: how often tau is beyond what unrelated rankings have.
TEST(KendallPower, IsHowOftenARankingIsFound) {
  std::mt19937_64 random = rankingNumber(12);
  std::normal_distribution<double> normal;
  constexpr int kRuns = 2000;
  for (const auto& [tau, policies] : {std::pair(0.5, 12), std::pair(0.5, 20), std::pair(0.3, 40)}) {
    const double r = std::sin(0.5 * std::acos(-1.0) * tau);
    const double critical = 1.96 * std::sqrt(2.0 * (2.0 * policies + 5.0) / (9.0 * policies * (policies - 1.0)));
    int found = 0;
    for (int run = 0; run < kRuns; ++run) {
      Column first(static_cast<std::size_t>(policies));
      Column second(first.size());
      for (std::size_t policy = 0; policy < first.size(); ++policy) {
        first[policy] = normal(random);
        second[policy] = r * first[policy] + std::sqrt(1.0 - r * r) * normal(random);
      }
      found += kendallTauB(first, second) > critical ? 1 : 0;
    }
    EXPECT_NEAR(static_cast<double>(found) / kRuns, kendallPower(tau, policies), 0.04) << tau << " " << policies;
  }
}

/// Computed with scipy 1.10, trying one number after the other; G. E. Noether's formula (JASA, 1987),
/// 4 (1.96 + 0.84)^2 / (9 tau^2), has 348.8, 87.2, 38.8 and 14.0 for the first four.
TEST(PoliciesForKendall, IsWhereThePowerSuffices) {
  EXPECT_EQ(policiesForKendall(0.1), 350);
  EXPECT_EQ(policiesForKendall(0.2), 89);
  EXPECT_EQ(policiesForKendall(0.3), 40);
  EXPECT_EQ(policiesForKendall(0.5), 16);
  EXPECT_EQ(policiesForKendall(0.7), 9);
  EXPECT_EQ(policiesForKendall(0.9), static_cast<int>(kFewestPolicies));
  EXPECT_FALSE(policiesForKendall(0.01));
}

TEST(Ranking, RefusesWhatHasNoMeaning) {
  expectRefused([] { pearson({1.0}, {2.0}); }, "number of values 1: must be at least 2");
  expectRefused([] { spearman({1.0, 2.0}, {2.0}); }, "number of values 1: must be that of the other side, 2");
  expectRefused([] { kendallTauB({1.0, std::nan("")}, {2.0, 1.0}); }, "value nan: must be a finite number");
  expectRefused(
      [] {
        meanMaximumRankViolation({1.0, 2.0}, {2.0, std::numeric_limits<double>::infinity()});
      },
      "value inf: must be a finite number");
  const CrossedTable two({{0.0, 1.0}, {1.0, 1.0}});
  expectRefused([&] { compareRankings(two, CrossedTable({{0.5, 1.0}, {1.0, 1.0}})); }, "success 0.5: must be 0 or 1");
  expectRefused(
      [&] {
        compareRankings(two, CrossedTable({{0.0, 1.0}, {1.0, 1.0}, {1.0, 0.0}}));
      },
      "number of rows 3: must be that of the first table, 2");
  expectRefused([&] { compareRankings(CrossedTable({{0.0, 1.0}}), two); }, "number of rows 1: must be at least 2");
  expectRefused([] { kendallPower(0.0, 20); }, "tau 0.0: must be above 0 and below 1");
  expectRefused([] { policiesForKendall(1.0); }, "tau 1.0: must be above 0 and below 1");
  expectRefused([] { kendallPower(0.5, 7); }, "policies 7: must be from 8 to 10000");
}

}  // namespace
}  // namespace sim2sim
