// SPDX-License-Identifier: BSD-3-Clause
/// Figures of starts that are played several times each, with other random numbers of the policy. Episodes of one start
/// resemble each other, so the start is the independent unit (the cluster), not the episode.
///
/// Intervals of rates are the score intervals of independent episodes, with counts divided by a design effect: how many
/// times larger the variance between starts makes that of the figure. It is estimated from the sums of residuals by
/// start, lies between 1 (repeats as good as other starts) and the number of repeats (all alike), and is drawn toward
/// the latter where few episodes tell. Student's t with one degree of freedom less than starts takes the place of the
/// normal quantile.
/// Sources: J. N. K. Rao and A. J. Scott, "A Simple Method for the Analysis of Clustered Binary Data" (Biometrics,
/// 1992); E. L. Korn and B. I. Graubard, "Confidence Intervals for Proportions with Small Expected Number of Positive
/// Counts Estimated from Survey Data" (Survey Methodology, 1998), for t.
///
/// The measured coverage is in docs/statistics.md. Functions throw std::domain_error, with value and rule, for input
/// out of range.
#pragma once

#include <optional>
#include <vector>

#include "sim2sim_statistics/intervals.hpp"
#include "sim2sim_statistics/pairs.hpp"

namespace sim2sim {

/// Outcomes of the episodes of one start.
struct StartCount {
  int successes;
  int episodes;  ///< at least 1
};

/// Interval of a success rate; none below kFewestEpisodes starts.
std::optional<Interval> repeatedRateInterval(const std::vector<StartCount>& starts);

/// Difference of success rates over all pairs, second - first, with its interval and the p-value of a test that both
/// rates are equal; neither below kFewestEpisodes starts. A table for each start, of at least one pair. The test is
/// McNemar's with the same design effect; p is at most 0.05 where the interval does not hold 0.
Difference repeatedDifference(const std::vector<PairTable>& starts);

/// Interval of the ratio of success rates, second / first. None below kFewestEpisodes starts, or if the first never
/// succeeds.
std::optional<Interval> repeatedRatioInterval(const std::vector<PairTable>& starts);

/// Difference of two such ratios over the same starts, second - first, as of the transfers of two policies: does one
/// keep more of its success than the other? NaN if the first of either never succeeds; no interval and no p below
/// kFewestEpisodes starts. `first` and `second` have a table for each start, in the same order. The interval is
/// recovered from Tang's of each ratio (with repeats repeatedRatioInterval()) and their correlation over starts; p is
/// that of the widest interval without 0.
/// Source: G. Y. Zou and A. Donner, "Construction of confidence limits about effect measures: a general approach"
/// (Statistics in Medicine, 2008), equation 15, of correlated estimates.
Difference differenceOfRatios(const std::vector<PairTable>& first, const std::vector<PairTable>& second);

/// Variance of a figure of one episode, split into two sources, in the square of the figure's unit (one-way random
/// effects). Their sum is the variance of an episode from any start.
/// Source: S. R. Searle, G. Casella and C. E. McCulloch, "Variance Components" (1992), chapter 3.
struct NoiseSplit {
  Estimate starts;   ///< between the means of starts; 0 if the estimate is negative
  Estimate repeats;  ///< between the episodes of a start: the noise of policy and loop
};

/// Split of a quantity, without intervals: its values by start. Starts with fewer than two values do not count. NaN
/// below two starts.
NoiseSplit noiseSplit(const std::vector<std::vector<double>>& starts);

/// Split of success, likewise, with intervals from kFewestOfTail starts on. That of the repeats is
/// Gaffke's (sim2sim_statistics/tails.hpp) of the variances within starts; that of the starts is Gaffke's of the
/// jackknife's pseudo-values, whose extreme is that of a start which always does what is rare.
NoiseSplit successNoiseSplit(const std::vector<StartCount>& starts);

}  // namespace sim2sim
