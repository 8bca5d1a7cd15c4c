// SPDX-License-Identifier: BSD-3-Clause
/// Two that played the same episodes, compared by their successes: difference and ratio of the rates, tests, and what
/// many tests at once mean.
#pragma once

#include <optional>
#include <vector>

#include "sim2sim_statistics/intervals.hpp"

namespace sim2sim {

/// Who succeeded in how many episodes. The first is the reference, or the row that others are held against; the second
/// is the engine, or another row.
struct PairTable {
  int both = 0;
  int first_only = 0;
  int second_only = 0;
  int neither = 0;

  void add(bool first, bool second);
  /// Throws std::domain_error if a count is negative, as all functions of a table do.
  void validate() const;
  int pairs() const { return both + first_only + second_only + neither; }
  /// Of the success rates, second - first.
  double difference() const { return (second_only - first_only) / static_cast<double>(pairs()); }
};

/// Of the difference of success rates, second - first, in [-1, 1]; none below kFewestEpisodes pairs.
/// Source: T. Tango, "Equivalence test and confidence interval for the difference in proportions for the paired-sample
/// design" (Statistics in Medicine, 1998).
std::optional<Interval> tangoInterval(const PairTable& table);

/// Of the ratio of success rates, second / first: the transfer, if the first is the reference. In [0, infinity); none
/// below kFewestEpisodes pairs, and none if the first never succeeds, for then there is no ratio.
/// Source: N.-S. Tang, M.-L. Tang and I. S. F. Chan, "On tests of equivalence via non-unity relative risk for
/// matched-pair design" (Statistics in Medicine, 2003).
std::optional<Interval> tangInterval(const PairTable& table);

/// McNemar's exact test that both rates are the same, two-sided: a coin thrown for each pair in which only one
/// succeeded. 1 if there is no such pair. It never errs more often than it says, but mostly much less often.
/// Source: Q. McNemar, "Note on the sampling error of the difference between correlated proportions or percentages"
/// (Psychometrika, 1947).
double mcnemarExact(const PairTable& table);

/// The same with half the probability of what was seen, which errs nearly as often as it says.
/// Source: M. W. Fagerland, S. Lydersen and P. Laake, "The McNemar test for binary matched-pairs data: mid-p and
/// asymptotic are better than exact conditional" (BMC Medical Research Methodology, 2013).
double mcnemarMidP(const PairTable& table);

/// The p-values of a family of tests, in the order given, so raised that with all those at or below 0.05 called
/// findings there is a false one in at most 5 % of families.
/// Source: S. Holm, "A Simple Sequentially Rejective Multiple Test Procedure" (1979).
std::vector<double> holm(const std::vector<double>& p);

}  // namespace sim2sim
