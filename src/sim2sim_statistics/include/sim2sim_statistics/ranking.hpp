// SPDX-License-Identifier: BSD-3-Clause
/// Whether one simulator ranks policies as another does: rank correlations of their success rates, each with an
/// interval, and the chance that the better of two policies in one simulator is the better one in the other.
///
/// Model: the policies are drawn from a population, such as the trainings of a recipe, and the starts (initial states)
/// from the task's distribution. Both simulators run every policy from the same starts. The truth that an interval of a
/// correlation or of the rank violation holds is about the true success rates, those of infinitely many starts, over
/// the population of policies. The rates of finitely many starts are noisy: noise of each simulator alone moves a
/// measured correlation toward 0, noise that both share moves it toward 1. The intervals undo both, by the variances
/// and the covariance that the policies have beyond those of the residuals (meanSquares()), in the way of
/// C. Spearman, "The Proof and Measurement of Association between Two Things" (1904). Where the noise is larger than
/// the spread of the policies there is no interval.
///
/// The measured coverage is in docs/statistics.md. Functions throw std::domain_error, with value and rule, for input
/// out of range.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "sim2sim_statistics/crossed.hpp"
#include "sim2sim_statistics/intervals.hpp"

namespace sim2sim {

/// Fewest policies for an interval. With 8 policies Kendall's interval covers the truth in 94 to 99 % of simulated runs
/// (nominal: 95 %). Fewer were not simulated.
constexpr std::size_t kFewestPolicies = 8;

/// Least reliability of measured success rates, in each simulator, for an interval of a correlation or of the rank
/// violation. At 0.5 the true rates spread as much as the noise of the starts.
constexpr double kLeastReliability = 0.5;

/// Pearson's correlation of at least two pairs of finite values; NaN if either side has no spread.
/// Source: K. Pearson, "Note on Regression and Inheritance in the Case of Two Parents" (1895).
double pearson(const std::vector<double>& first, const std::vector<double>& second);

/// Spearman's rank correlation; ties have the average of their ranks. NaN if either side has no spread.
/// Source: C. Spearman, "The Proof and Measurement of Association between Two Things" (1904).
double spearman(const std::vector<double>& first, const std::vector<double>& second);

/// Kendall's tau-b: concordant less discordant pairs, over the geometric mean of the numbers of pairs without a tie on
/// either side. NaN if either side has no spread.
/// Source: M. G. Kendall, "The Treatment of Ties in Ranking Problems" (Biometrika, 1945).
double kendallTauB(const std::vector<double>& first, const std::vector<double>& second);

/// Mean maximum rank violation (MMRV), in the unit of the reference: for each policy the largest difference in the
/// reference to another policy that the test ranks the other way round, averaged over the policies. At least two.
/// Source: X. Li et al., "Evaluating Real-World Robot Manipulation Policies in Simulation" (2024); there the real
/// robot is the reference, and the simulator the test.
double meanMaximumRankViolation(const std::vector<double>& test, const std::vector<double>& reference);

/// Whether a ranking survives the change of the simulator.
enum class RankingVerdict {
  kPreserved,  ///< Kendall's interval is above 0
  kReversed,   ///< it is below 0
  kCannotSay,  ///< it holds 0, or there is none
};

/// Pairs of policies whose success in the reference differs by at least `from`, and by less than `to`; the last bin
/// holds 1 as well. Pairs that tie in the reference are in none.
struct PairAgreement {
  double from;
  double to;
  int pairs = 0;
  /// Share of the pairs whose better policy in the reference is the better one in the test; a tie there counts half, so
  /// 0.5 is what guessing has. The truth is that of new policies measured over as many starts. No interval below
  /// kFewestPairs pairs, if they are of fewer than kFewestPolicies policies, or if one policy is in all of them.
  Estimate share;
};

/// Lower ends of the bins of PairAgreement, as differences of success rates.
constexpr std::array kAgreementBins = {0.0, 0.05, 0.1, 0.2};

/// Figures of two simulators that ran the same policies from the same starts.
struct RankingComparison {
  /// Part of the variance of the measured success rates that the policies make, at most 1; the noise of the starts
  /// makes the rest. It is below 0 by chance where the policies hardly differ, NaN where nothing varies.
  double reference_reliability;
  double test_reliability;
  /// Figures of the measured rates. No interval below kFewestPolicies policies or kFewestColumns starts, below
  /// kLeastReliability, or where the figure does not exist.
  Estimate pearson;
  Estimate spearman;
  Estimate kendall;
  Estimate violation;  ///< MMRV, as a difference of success rates in the reference; its truth is for as many policies
  std::array<PairAgreement, kAgreementBins.size()> agreement;  ///< by the difference in the reference
  RankingVerdict verdict;
};

/// Resamples of the starts, for the noise of the rank violation. They give its standard deviation to 5 %.
constexpr int kStartResamples = 200;
/// Seed of these resamples. Any will do, but results depend on it.
constexpr std::uint32_t kStartSeed = 1904;

/// Comparison of tables of successes, 0 or 1, of at least two policies (rows) from at least two starts (columns); both
/// tables have the same shape.
///
/// Intervals of the correlations: Fisher's z for Pearson's; Bonett and Wright's for Spearman's, where a perfect ranking
/// counts as half a swap of neighbors short of it; for Kendall's all values that a score test does not reject. Their
/// variance is that of normal policies, or the jackknife's over policies where that is larger; for Kendall's at 0,
/// where no distribution matters, the former. The ends are then corrected for noise, through the relations of rank
/// correlations to Pearson's under normal policies. Pearson's holds the ends that are not corrected, too. Each holds
/// its figure. None where one policy makes the whole spread.
/// The violation's is Student's t on the scale of the root, and reaches from the lower of the corrected and the
/// measured figure to the higher one, plus the half-width on either side. Its variance is the jackknife's over policies
/// plus the bootstrap's over starts.
/// The shares' is Wilson's, for the number of independent pairs that has the jackknife's variance over policies, at
/// most as many as policies. Time grows with the third power of the number of policies: milliseconds for 40.
/// Sources: R. A. Fisher, "On the 'Probable Error' of a Coefficient of Correlation Deduced from a Small Sample" (1921);
/// D. G. Bonett and T. A. Wright, "Sample size requirements for estimating Pearson, Kendall and Spearman correlations"
/// (Psychometrika, 2000); F. Esscher, "On a method of determining correlation from the ranks of the variates" (1924),
/// the variance of tau; W. H. Kruskal, "Ordinal Measures of Association" (JASA, 1958), the relations; B. Efron and
/// C. Stein, "The Jackknife Estimate of Variance" (Annals of Statistics, 1981).
RankingComparison compareRankings(const CrossedTable& reference, const CrossedTable& test,
                                  std::uint32_t seed = kStartSeed);

constexpr int kMostPolicies = 10'000;  ///< largest number of policies in plans and answers

/// Power of the verdict: probability of finding that a ranking is preserved with `policies` >= kFewestPolicies, if
/// Kendall's tau of the measured success rates, in (0, 1), is that of the population and the policies are normal.
/// Source: normal approximation with the exact variances of tau, as in compareRankings().
double kendallPower(double tau, int policies);

/// Smallest number of policies to find that a ranking is preserved with 80 % power (kPower), at least kFewestPolicies;
/// none if more than kMostPolicies.
std::optional<int> policiesForKendall(double tau);

}  // namespace sim2sim
