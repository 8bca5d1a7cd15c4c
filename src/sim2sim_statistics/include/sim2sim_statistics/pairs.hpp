// SPDX-License-Identifier: BSD-3-Clause
/// Comparison of two policies or simulators over the same episodes, by their successes: difference and ratio of the
/// rates, tests, and the correction for many tests.
#pragma once

#include <optional>
#include <vector>

#include "sim2sim_statistics/intervals.hpp"

namespace sim2sim {

/// Counts of paired successes. The first is the reference or baseline, the second is compared with it.
struct PairTable {
  int both = 0;
  int first_only = 0;
  int second_only = 0;
  int neither = 0;

  /// Adds the successes of one episode.
  void add(bool first, bool second);
  /// Throws std::domain_error if a count is negative, as all functions of a table.
  void validate() const;
  int pairs() const { return both + first_only + second_only + neither; }
  /// Share of pairs in which only one succeeds.
  double discordant() const { return (first_only + second_only) / static_cast<double>(pairs()); }
  /// Difference of the success rates, second - first.
  double difference() const { return (second_only - first_only) / static_cast<double>(pairs()); }
};

/// Interval of the difference of success rates, second - first, in [-1, 1]; none below kFewestEpisodes pairs.
/// Source: T. Tango, "Equivalence test and confidence interval for the difference in proportions for the paired-sample
/// design" (Statistics in Medicine, 1998).
std::optional<Interval> tangoInterval(const PairTable& table);

/// Interval of the ratio of success rates, second / first (the transfer, if the first is the reference), in
/// [0, infinity). None below kFewestEpisodes pairs, or if the first never succeeds: then there is no ratio.
/// Source: N.-S. Tang, M.-L. Tang and I. S. F. Chan, "On tests of equivalence via non-unity relative risk for
/// matched-pair design" (Statistics in Medicine, 2003).
std::optional<Interval> tangInterval(const PairTable& table);

/// p-value of McNemar's exact test that both rates are equal, two-sided: a fair coin for each pair in which only one
/// succeeded. 1 without such a pair. Its error rate never exceeds the level, but is mostly much lower.
/// Source: Q. McNemar, "Note on the sampling error of the difference between correlated proportions or percentages"
/// (Psychometrika, 1947).
double mcnemarExact(const PairTable& table);

/// p-value of McNemar's test with half the probability of the observed counts (mid-p). Its error rate is near the
/// level. Source: M. W. Fagerland, S. Lydersen and P. Laake, "The McNemar test for binary matched-pairs data: mid-p and
/// asymptotic are better than exact conditional" (BMC Medical Research Methodology, 2013).
double mcnemarMidP(const PairTable& table);

/// Difference of success rates, second - first, with Tango's interval and McNemar's mid-p.
Difference rateDifference(const PairTable& table);

/// p-values of a family of tests after Holm's correction, in the order given. If all at or below 0.05 are called
/// findings, at most 5 % of families have a false one.
/// Source: S. Holm, "A Simple Sequentially Rejective Multiple Test Procedure" (1979).
std::vector<double> holm(const std::vector<double>& p);

}  // namespace sim2sim
