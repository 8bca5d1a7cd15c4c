// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/hypotheses.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_testing/refusal.hpp"

namespace sim2sim {
namespace {

using HypothesisSide = Hypothesis::Side;
using HypothesisVerdict = HypothesisResult::Verdict;
using ::testing::ElementsAre;

constexpr std::size_t kHomeColumn = 0;
constexpr std::size_t kAwayColumn = 1;
constexpr int kFewestStarts = 20;       // for an interval
constexpr double kMetersOfOne = 0.01;   // position divergence of a policy with one success
constexpr double kRadiansOfOne = 0.05;  // its angle divergence
const std::string kPositionFigure = kMatrixDivergences[0];
const std::string kAngleFigure = kMatrixDivergences[1];

/// Name of a group, and for each policy the number of starts in which it succeeds.
using GroupOfCounts = std::pair<std::string, std::vector<int>>;

/// Successes in the first `count` of all starts.
std::vector<bool> successesInFirst(int count, int starts = kFewestStarts) {
  std::vector<bool> successes(static_cast<std::size_t>(starts), false);
  std::fill_n(successes.begin(), count, true);
  return successes;
}

/// Divergences that are alike from every start and grow with a policy's successes: in a table of them nothing but the
/// policies varies, so the crossed intervals are those of Student's and Welch's t on one value for each policy.
MatrixCell awayCell(int count, int starts) {
  MatrixCell cell = {};
  cell.successes = successesInFirst(count, starts);
  cell.divergences[0].assign(static_cast<std::size_t>(starts), kMetersOfOne * count);
  cell.divergences[1].assign(static_cast<std::size_t>(starts), kRadiansOfOne * count);
  return cell;
}

/// Matrix of the simulators home, the reference of all policies, and away. A policy succeeds from the same starts in
/// both.
Matrix matrixOf(const std::vector<GroupOfCounts>& groups, int starts = kFewestStarts) {
  Matrix matrix = {};
  matrix.episodes = starts;
  matrix.simulators = {{"home", "Home"}, {"away", "Away"}};
  for (const auto& [name, counts] : groups) {
    MatrixGroup group = {};
    group.name = name;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      group.policies.push_back(matrix.policies.size());
      matrix.policies.push_back({name + "-" + std::to_string(i), name, kHomeColumn});
      MatrixCell home = {};
      home.successes = successesInFirst(counts[i], starts);
      matrix.cells.push_back({home, awayCell(counts[i], starts)});
    }
    matrix.groups.push_back(group);
  }
  return matrix;
}

/// Groups of five policies with n, n + 1, ..., n + 4 successes. The standard error of the difference of two such groups
/// of divergences is sqrt(2 * 2.5 / 5) = 1 success, with 8 degrees of freedom: their means differ by the difference d
/// of their n, +- 2.306; d = 5, 3, 2, 1 has the p below (scipy.stats.t).
Matrix steps() {
  return matrixOf({{"from1", {1, 2, 3, 4, 5}},
                   {"from3", {3, 4, 5, 6, 7}},
                   {"from4", {4, 5, 6, 7, 8}},
                   {"from6", {6, 7, 8, 9, 10}}});
}
constexpr double kHalfWidth = 2.306004135033371 * kMetersOfOne;
constexpr double kP5 = 0.001052825793366539;
constexpr double kP3 = 0.017071681233782634;
constexpr double kP2 = 0.08051623795726257;
constexpr double kP1 = 0.3465935070873342;
constexpr double kTolerance = 1e-9;

/// Hypothesis on the position divergence away from home.
Hypothesis apartBy(const std::string& more, const std::string& less, HypothesisSide side, double margin = 0.0) {
  return {more + " - " + less, GroupDifference{more, less, "away", kPositionFigure}, side, margin};
}

/// Hypothesis on the rankings at home and away.
Hypothesis rankedAlike(const std::vector<std::string>& groups, HypothesisSide side, double margin = 0.0) {
  return {"ranking", GroupRanking{groups, "home", "away"}, side, margin};
}

HypothesisResult only(const Matrix& matrix, const Hypothesis& hypothesis) {
  const std::vector<HypothesisResult> results = test(matrix, {hypothesis});
  EXPECT_EQ(results.size(), 1U);
  return results.at(0);
}

std::vector<HypothesisVerdict> verdictsOf(const Matrix& matrix, const std::vector<Hypothesis>& hypotheses) {
  std::vector<HypothesisVerdict> verdicts;
  for (const HypothesisResult& result : test(matrix, hypotheses)) {
    verdicts.push_back(result.verdict);
  }
  return verdicts;
}

std::string refusalOfHypothesis(const Matrix& matrix, const Hypothesis& hypothesis) {
  return pusht::testing::refusalOf<pusht::InvalidInput>([&] { test(matrix, {hypothesis}); });
}

void expectFound(const Difference& found, double value, const Interval& interval, double p) {
  EXPECT_NEAR(found.value, value, kTolerance);
  EXPECT_NEAR(found.interval.value().low, interval.low, kTolerance);
  EXPECT_NEAR(found.interval.value().high, interval.high, kTolerance);
  EXPECT_NEAR(found.p.value(), p, kTolerance);
}

TEST(Hypotheses, HaveTheIntervalOfWelchsTIfOnlyPoliciesVary) {
  const HypothesisResult result = only(steps(), apartBy("from6", "from1", HypothesisSide::kAbove));
  expectFound(result.found, 5 * kMetersOfOne, {5 * kMetersOfOne - kHalfWidth, 5 * kMetersOfOne + kHalfWidth}, kP5);
  EXPECT_NEAR(result.adjusted_p.value(), kP5, kTolerance) << "a family of one";
  EXPECT_EQ(result.hypothesis.name, "from6 - from1");
  // Welch's t on 6, 8, 10, 12, 14 and 3, 4, 5, 6, 7, 8: scipy.stats.ttest_ind(equal_var=False).
  const Matrix unequal = matrixOf({{"five", {6, 8, 10, 12, 14}}, {"six", {3, 4, 5, 6, 7, 8}}});
  expectFound(only(unequal, apartBy("five", "six", HypothesisSide::kAbove)).found, 4.5 * kMetersOfOne,
              {0.6047257477633172 * kMetersOfOne, 8.395274252236682 * kMetersOfOne}, 0.0298604691197072);
}

/// The numbers are those of the analysis of variance in numpy, by the formulas of crossed.hpp.
TEST(Hypotheses, OnSuccessCompareTheSameStarts) {
  const Matrix matrix = matrixOf({{"good", {12, 14, 16, 18, 19}}, {"bad", {4, 6, 8, 10, 13}}});
  for (const char* simulator : {"home", "away"}) {
    const GroupDifference independent = {"good", "bad", simulator};
    expectFound(only(matrix, {"independent", independent}).found, 0.38, {0.1317929294861742, 0.628207070513826},
                0.00612711123677479);
    const GroupDifference paired = {"good", "bad", simulator, kSuccessFigure, true};
    expectFound(only(matrix, {"paired", paired}).found, 0.38, {0.2582103068143389, 0.5017896931856611},
                0.0002069870894174313);
  }
}

TEST(Hypotheses, OnAnglesHaveTheSecondDivergence) {
  const GroupDifference difference = {"from6", "from1", "away", kAngleFigure};
  EXPECT_NEAR(only(steps(), {"angles", difference}).found.value, 5 * kRadiansOfOne, kTolerance);
}

TEST(Hypotheses, HoldOnTheirSideAndAreContradictedOnTheOther) {
  EXPECT_THAT(verdictsOf(steps(), {apartBy("from6", "from1", HypothesisSide::kAbove),
                                   apartBy("from6", "from1", HypothesisSide::kBelow),
                                   apartBy("from1", "from6", HypothesisSide::kAbove),
                                   apartBy("from1", "from6", HypothesisSide::kBelow)}),
              ElementsAre(HypothesisVerdict::kHolds, HypothesisVerdict::kContradicted, HypothesisVerdict::kContradicted,
                          HypothesisVerdict::kHolds));
}

TEST(Hypotheses, AreNotShownWhereTheIntervalHoldsZero) {
  for (const HypothesisSide side : {HypothesisSide::kAbove, HypothesisSide::kBelow}) {
    const HypothesisResult result = only(steps(), apartBy("from6", "from4", side));
    EXPECT_NEAR(result.found.interval.value().low, 2 * kMetersOfOne - kHalfWidth, kTolerance);
    EXPECT_EQ(result.verdict, HypothesisVerdict::kNotShown);
  }
}

/// By hand: 0.0171 alone is below 0.05, three times that is not. The interval has no 0 either way.
TEST(Hypotheses, AreNotShownIfNotSignificantAfterHolm) {
  for (const auto& [side, alone] : {std::pair(HypothesisSide::kAbove, HypothesisVerdict::kHolds),
                                    std::pair(HypothesisSide::kBelow, HypothesisVerdict::kContradicted)}) {
    const Hypothesis hypothesis = apartBy("from6", "from3", side);
    EXPECT_EQ(only(steps(), hypothesis).verdict, alone);
    const std::vector<HypothesisResult> family =
        test(steps(), {hypothesis, apartBy("from6", "from4", side), apartBy("from4", "from3", side)});
    EXPECT_GT(family[0].found.interval.value().low, 0.0);
    EXPECT_NEAR(family[0].adjusted_p.value(), 3 * kP3, kTolerance);
    EXPECT_GT(3 * kP3, 0.05);
    EXPECT_EQ(family[0].verdict, HypothesisVerdict::kNotShown);
  }
}

/// By hand: the family is 0.0805, 0.0011, 0.0805, 0.3466; the least is taken four times, a 0.0805 three times, the
/// other one twice, but at least as much as the first, and the largest once.
TEST(Hypotheses, FamilyIsAllDifferencesWithASignExpected) {
  Matrix matrix = steps();
  Matrix few = matrixOf({{"few", {18, 19, 20}}});
  matrix.groups.push_back(few.groups[0]);
  for (std::size_t i = 0; i < few.policies.size(); ++i) {
    matrix.groups.back().policies[i] = matrix.policies.size();
    matrix.policies.push_back(few.policies[i]);
    matrix.cells.push_back(few.cells[i]);
  }
  const std::vector<HypothesisResult> results =
      test(matrix, {
                       apartBy("from6", "from4", HypothesisSide::kAbove),
                       apartBy("from6", "from3", HypothesisSide::kWithin, 1.0),
                       apartBy("from6", "from1", HypothesisSide::kAbove),
                       rankedAlike({"from1", "from6"}, HypothesisSide::kAbove),
                       apartBy("from1", "from3", HypothesisSide::kBelow),
                       apartBy("few", "from3", HypothesisSide::kAbove),
                       apartBy("from4", "from3", HypothesisSide::kBelow),
                   });
  ASSERT_EQ(results.size(), 7U);
  EXPECT_NEAR(results[0].adjusted_p.value(), 3 * kP2, kTolerance);
  EXPECT_NEAR(results[2].adjusted_p.value(), 4 * kP5, kTolerance);
  EXPECT_NEAR(results[4].adjusted_p.value(), 3 * kP2, kTolerance);
  EXPECT_NEAR(results[6].adjusted_p.value(), kP1, kTolerance);
  EXPECT_NEAR(results[1].found.p.value(), kP3, kTolerance) << "is not corrected";
  for (const std::size_t outside : {1U, 3U, 5U}) {
    EXPECT_FALSE(results[outside].adjusted_p) << results[outside].hypothesis.name;
  }
  EXPECT_EQ(results[1].verdict, HypothesisVerdict::kHolds);
  EXPECT_EQ(results[2].verdict, HypothesisVerdict::kHolds);
  EXPECT_EQ(results[3].verdict, HypothesisVerdict::kHolds);
}

TEST(Hypotheses, WithinAMarginAreDecidedByTheWholeInterval) {
  // The interval of from6 - from3 is [0.0069, 0.0531].
  for (const auto& [margin, verdict] :
       {std::pair(0.054, HypothesisVerdict::kHolds), std::pair(0.053, HypothesisVerdict::kNotShown),
        std::pair(0.007, HypothesisVerdict::kNotShown), std::pair(0.0069, HypothesisVerdict::kContradicted)}) {
    EXPECT_THAT(verdictsOf(steps(), {apartBy("from6", "from3", HypothesisSide::kWithin, margin),
                                     apartBy("from3", "from6", HypothesisSide::kWithin, margin)}),
                ElementsAre(verdict, verdict))
        << margin;
  }
  EXPECT_EQ(only(steps(), apartBy("from6", "from4", HypothesisSide::kWithin, 0.044)).verdict, HypothesisVerdict::kHolds)
      << "an interval with 0";
}

/// The differences of the pairs are 1, 2, 1, 2, 1: scipy.stats.ttest_1samp. Among the policies of a group they are
/// lost.
TEST(Hypotheses, OnPairsHaveStudentsTOfTheirDifferences) {
  const Matrix matrix = matrixOf({{"late", {3, 7, 11, 15, 20}}, {"early", {2, 5, 10, 13, 19}}});
  Hypothesis hypothesis = apartBy("late", "early", HypothesisSide::kAbove);
  EXPECT_NEAR(only(matrix, hypothesis).found.p.value(), 0.7484072405148883, kTolerance);
  EXPECT_EQ(only(matrix, hypothesis).verdict, HypothesisVerdict::kNotShown);
  std::get<GroupDifference>(hypothesis.figure).paired = true;
  const HypothesisResult paired = only(matrix, hypothesis);
  expectFound(paired.found, 1.4 * kMetersOfOne, {0.719912619341743 * kMetersOfOne, 2.0800873806582567 * kMetersOfOne},
              0.004635839417904412);
  EXPECT_EQ(paired.verdict, HypothesisVerdict::kHolds);
}

TEST(Hypotheses, OnPairsRefuseGroupsOfUnequalSize) {
  const Matrix matrix = matrixOf({{"late", {3, 7, 11, 15, 20, 20}}, {"early", {2, 5, 10, 13, 19}}});
  for (const std::string& figure : {std::string(kSuccessFigure), kPositionFigure}) {
    GroupDifference difference = {"late", "early", "away", figure, true};
    EXPECT_EQ(refusalOfHypothesis(matrix, {"H1", difference}),
              "hypothesis H1: group early: has 5 policies; must have as many as the other, 6");
    difference.paired = false;
    EXPECT_EQ(refusalOfHypothesis(matrix, {"H1", difference}), pusht::testing::kNotRefused);
  }
}

TEST(Hypotheses, AreNotShownByFewerThanFivePoliciesOrTwentyStarts) {
  const std::vector<int> low = {1, 2, 3, 4, 5};
  const std::vector<int> high = {14, 15, 16, 17, 18};
  const std::vector<int> four_low(low.begin(), low.end() - 1);
  const std::vector<int> four_high(high.begin(), high.end() - 1);
  const std::vector<Matrix> too_small = {matrixOf({{"high", four_high}, {"low", low}}),
                                         matrixOf({{"high", high}, {"low", four_low}}),
                                         matrixOf({{"high", high}, {"low", low}}, kFewestStarts - 1)};
  for (const Matrix& matrix : too_small) {
    for (const HypothesisSide side : {HypothesisSide::kAbove, HypothesisSide::kBelow, HypothesisSide::kWithin}) {
      const HypothesisResult result = only(matrix, apartBy("high", "low", side, 1.0));
      EXPECT_NEAR(result.found.value, 13 * kMetersOfOne, 0.5 * kMetersOfOne + kTolerance);
      EXPECT_FALSE(result.found.interval);
      EXPECT_FALSE(result.found.p);
      EXPECT_FALSE(result.adjusted_p);
      EXPECT_EQ(result.verdict, HypothesisVerdict::kNotShown);
    }
  }
  EXPECT_EQ(only(matrixOf({{"high", high}, {"low", low}}), apartBy("high", "low", HypothesisSide::kAbove)).verdict,
            HypothesisVerdict::kHolds);
  Hypothesis paired = apartBy("high", "low", HypothesisSide::kAbove);
  std::get<GroupDifference>(paired.figure).paired = true;
  EXPECT_FALSE(only(matrixOf({{"high", four_high}, {"low", {1, 2, 3, 5}}}), paired).found.interval);
}

TEST(Hypotheses, RefuseADivergenceInAReference) {
  Hypothesis hypothesis = apartBy("from6", "from1", HypothesisSide::kAbove);
  std::get<GroupDifference>(hypothesis.figure).simulator = "home";
  EXPECT_EQ(refusalOfHypothesis(steps(), hypothesis),
            "hypothesis from6 - from1: group from6: has no early_position_divergence of from6-0 in home");
  Matrix matrix = steps();
  matrix.policies[2].reference = kAwayColumn;  // of from1
  EXPECT_EQ(refusalOfHypothesis(matrix, apartBy("from6", "from1", HypothesisSide::kAbove)),
            "hypothesis from6 - from1: group from1: has no early_position_divergence of from1-2 in away");
  EXPECT_EQ(refusalOfHypothesis(matrix, {"H1", GroupDifference{"from6", "from1", "away"}}), pusht::testing::kNotRefused)
      << "there is a success";
}

TEST(Hypotheses, RefuseAGroupWithoutACell) {
  Matrix matrix = steps();
  matrix.cells[1][kAwayColumn].reset();
  EXPECT_EQ(refusalOfHypothesis(matrix, apartBy("from6", "from1", HypothesisSide::kAbove)),
            "hypothesis from6 - from1: group from1: has no early_position_divergence of from1-1 in away");
  EXPECT_EQ(refusalOfHypothesis(matrix, {"H1", GroupDifference{"from1", "from6", "away"}}),
            "hypothesis H1: group from1: has no success of from1-1 in away");
  EXPECT_EQ(refusalOfHypothesis(matrix, rankedAlike({"from6", "from1"}, HypothesisSide::kAbove)),
            "hypothesis ranking: group from1: has no success of from1-1 in away");
  EXPECT_EQ(refusalOfHypothesis(matrix, {"H1", GroupDifference{"from1", "from6", "home"}}),
            pusht::testing::kNotRefused);
}

TEST(Hypotheses, RefuseWhatTheMatrixDoesNotHave) {
  EXPECT_EQ(refusalOfHypothesis(steps(), {"H1", GroupDifference{"from6", "from9", "away"}}),
            "hypothesis H1: group from9: must be one of the matrix, from1, from3, from4, from6");
  EXPECT_EQ(refusalOfHypothesis(steps(), {"H1", GroupDifference{"from6", "from1", "mars"}}),
            "hypothesis H1: simulator mars: must be one of home, away");
  EXPECT_EQ(refusalOfHypothesis(steps(), {"H1", GroupDifference{"from6", "from1", "away", "luck"}}),
            "hypothesis H1: figure luck: must be success, early_position_divergence or early_angle_divergence");
  EXPECT_EQ(refusalOfHypothesis(steps(), {"H1", GroupRanking{{"from6"}, "home", "mars"}}),
            "hypothesis H1: simulator mars: must be one of home, away");
}

TEST(Hypotheses, LeaveOutAStartThatOnePolicyIsTooShortFor) {
  Matrix matrix = matrixOf({{"high", {6, 7, 8, 9, 10}}, {"low", {1, 2, 3, 4, 5}}}, kFewestStarts + 1);
  const auto set_divergence = [&](std::size_t policy, std::size_t start, double divergence) {
    matrix.cells[policy][kAwayColumn]->divergences[0][start] = divergence;
  };
  for (const std::size_t policy : matrix.groups[0].policies) {
    set_divergence(policy, 3, 1000.0);
  }
  set_divergence(7, 3, std::nan(""));
  const Hypothesis hypothesis = apartBy("high", "low", HypothesisSide::kAbove);
  expectFound(only(matrix, hypothesis).found, 5 * kMetersOfOne,
              {5 * kMetersOfOne - kHalfWidth, 5 * kMetersOfOne + kHalfWidth}, kP5);
  set_divergence(0, 4, std::nan(""));
  EXPECT_FALSE(only(matrix, hypothesis).found.interval) << "19 starts are left";
  for (std::size_t start = 0; start < static_cast<std::size_t>(matrix.episodes); ++start) {
    set_divergence(start % 2, start, std::nan(""));
  }
  EXPECT_EQ(refusalOfHypothesis(matrix, hypothesis),
            "hypothesis high - low: figure early_position_divergence: must be there for all policies of both groups in "
            "some episode, is in none");
}

/// By hand: of 20 starts one is the largest 5 %; it makes 30 % of the mean if it is 0.3 * 19 / 0.7 = 8.14 times the
/// others.
TEST(Hypotheses, OnDivergencesHaveNoIntervalIfFewStartsCarryTheMeanOfAGroup) {
  for (const char* group : {"from1", "from6"}) {
    for (const auto& [factor, is_there] : {std::pair(8.1, true), std::pair(8.2, false)}) {
      Matrix matrix = steps();
      for (const MatrixGroup& candidate : matrix.groups) {
        for (const std::size_t policy : candidate.policies) {
          matrix.cells[policy][kAwayColumn]->divergences[0][7] *= candidate.name == group ? factor : 1.0;
        }
      }
      const HypothesisResult result = only(matrix, apartBy("from6", "from1", HypothesisSide::kAbove));
      EXPECT_EQ(result.found.interval.has_value(), is_there) << group << " " << factor;
      EXPECT_EQ(result.found.p.has_value(), is_there);
      EXPECT_EQ(result.adjusted_p.has_value(), is_there);
      if (!is_there) {
        EXPECT_EQ(result.verdict, HypothesisVerdict::kNotShown);
      }
    }
  }
  const Matrix rare = matrixOf({{"good", {10, 12, 14, 16, 18}}, {"bad", {0, 1, 1, 2, 2}}});
  EXPECT_EQ(only(rare, {"rare", GroupDifference{"good", "bad", "away"}}).verdict, HypothesisVerdict::kHolds)
      << "successes have one";
}

const std::vector<int> kEightCounts = {2, 4, 6, 8, 10, 12, 14, 16};

/// Matrix of one group, "all", with these numbers of successes.
Matrix rankings(const std::vector<int>& home, const std::vector<int>& away) {
  Matrix matrix = matrixOf({{"all", home}});
  for (std::size_t i = 0; i < away.size(); ++i) {
    matrix.cells[i][kAwayColumn]->successes = successesInFirst(away[i]);
  }
  return matrix;
}

/// By hand: of 28 pairs two neighbors are swapped, (26 - 2) / 28.
TEST(Hypotheses, OnARankingAreOnTheSideOfKendallsInterval) {
  const Hypothesis same = rankedAlike({"all"}, HypothesisSide::kAbove);
  const Hypothesis reversed = rankedAlike({"all"}, HypothesisSide::kBelow);
  const Matrix alike = rankings(kEightCounts, {4, 2, 6, 8, 10, 12, 16, 14});
  const HypothesisResult result = only(alike, same);
  EXPECT_NEAR(result.found.value, 24.0 / 28.0, kTolerance);
  EXPECT_GT(result.found.interval.value().low, 0.0);
  EXPECT_FALSE(result.found.p);
  EXPECT_FALSE(result.adjusted_p);
  EXPECT_THAT(verdictsOf(alike, {same, reversed}),
              ElementsAre(HypothesisVerdict::kHolds, HypothesisVerdict::kContradicted));
  const Matrix opposite = rankings(kEightCounts, {16, 14, 12, 10, 8, 6, 4, 2});
  EXPECT_NEAR(only(opposite, reversed).found.value, -1.0, kTolerance);
  EXPECT_THAT(verdictsOf(opposite, {same, reversed}),
              ElementsAre(HypothesisVerdict::kContradicted, HypothesisVerdict::kHolds));
}

/// By hand: of 28 pairs 13 are in the same order, (13 - 15) / 28.
TEST(Hypotheses, OnARankingAreNotShownWhereTheIntervalHoldsZeroOrIsNone) {
  const Hypothesis same = rankedAlike({"all"}, HypothesisSide::kAbove);
  const Hypothesis reversed = rankedAlike({"all"}, HypothesisSide::kBelow);
  const Matrix mixed = rankings(kEightCounts, {8, 16, 2, 10, 6, 14, 12, 4});
  const Interval interval = only(mixed, same).found.interval.value();
  EXPECT_NEAR(only(mixed, same).found.value, -2.0 / 28.0, kTolerance);
  EXPECT_LT(interval.low, 0.0);
  EXPECT_GT(interval.high, 0.0);
  EXPECT_THAT(verdictsOf(mixed, {same, reversed}),
              ElementsAre(HypothesisVerdict::kNotShown, HypothesisVerdict::kNotShown));
  const std::vector<int> seven(kEightCounts.begin(), kEightCounts.end() - 1);
  const HypothesisResult too_few = only(rankings(seven, seven), same);
  EXPECT_NEAR(too_few.found.value, 1.0, kTolerance);
  EXPECT_FALSE(too_few.found.interval);
  EXPECT_EQ(too_few.verdict, HypothesisVerdict::kNotShown);
  const std::vector<int> equal(8, 4);
  const HypothesisResult undefined = only(rankings(equal, equal), same);
  EXPECT_TRUE(std::isnan(undefined.found.value));
  EXPECT_EQ(undefined.verdict, HypothesisVerdict::kNotShown);
}

TEST(Hypotheses, OnARankingMayBeWithinAMargin) {
  const Matrix mixed = rankings(kEightCounts, {8, 16, 2, 10, 6, 14, 12, 4});
  EXPECT_THAT(verdictsOf(mixed, {rankedAlike({"all"}, HypothesisSide::kWithin, 0.99),
                                 rankedAlike({"all"}, HypothesisSide::kWithin, 0.1)}),
              ElementsAre(HypothesisVerdict::kHolds, HypothesisVerdict::kNotShown));
  EXPECT_EQ(only(rankings(kEightCounts, kEightCounts), rankedAlike({"all"}, HypothesisSide::kWithin, 0.1)).verdict,
            HypothesisVerdict::kContradicted);
}

/// By hand: all four policies of the one group are below those of the other at home, above them away; within the groups
/// the order stays: (12 - 16) / 28.
TEST(Hypotheses, OnARankingJoinItsGroups) {
  Matrix matrix = matrixOf({{"low", {2, 4, 6, 8}}, {"other", {1}}, {"high", {10, 12, 14, 16}}});
  const std::vector<int> away = {10, 12, 14, 16, 20, 2, 4, 6, 8};
  for (std::size_t i = 0; i < away.size(); ++i) {
    matrix.cells[i][kAwayColumn]->successes = successesInFirst(away[i]);
  }
  EXPECT_NEAR(only(matrix, rankedAlike({"low", "high"}, HypothesisSide::kAbove)).found.value, -4.0 / 28.0, kTolerance);
}

TEST(Hypotheses, OnARankingRefuseOnePolicyOrOneStart) {
  EXPECT_EQ(refusalOfHypothesis(matrixOf({{"all", {3}}}), rankedAlike({"all"}, HypothesisSide::kAbove)),
            "hypothesis ranking: ranking all: has 1 policies and 20 episodes; must have two or more of each");
  EXPECT_EQ(refusalOfHypothesis(matrixOf({{"a", {0}}, {"b", {1}}}, 1), rankedAlike({"a", "b"}, HypothesisSide::kAbove)),
            "hypothesis ranking: ranking a, b: has 2 policies and 1 episodes; must have two or more of each");
  EXPECT_EQ(refusalOfHypothesis(matrixOf({{"all", {3, 4}}}), rankedAlike({"all"}, HypothesisSide::kAbove)),
            pusht::testing::kNotRefused);
}

TEST(Hypotheses, OnARankingRefuseAGroupTwiceOrOneSimulator) {
  const Matrix matrix = matrixOf({{"all", {1, 2, 3, 4}}});
  EXPECT_EQ(refusalOfHypothesis(matrix, rankedAlike({"all", "all"}, HypothesisSide::kAbove)),
            "hypothesis ranking: ranking all, all: must name each group once");
  Hypothesis alone = rankedAlike({"all"}, HypothesisSide::kAbove);
  std::get<GroupRanking>(alone.figure).there = std::get<GroupRanking>(alone.figure).here;
  EXPECT_EQ(refusalOfHypothesis(matrix, alone),
            "hypothesis ranking: ranking all: must be of two simulators, is of home alone");
}

TEST(Hypotheses, AreNoneIfNothingIsExpected) { EXPECT_TRUE(test(steps(), {}).empty()); }

}  // namespace
}  // namespace sim2sim
