// SPDX-License-Identifier: BSD-3-Clause
/// Intervals for figures of one sample: rates, means, medians, means of paired differences. The measured coverage of
/// each is in docs/statistics.md. Functions throw std::domain_error, with value and rule, for input out of range.
#pragma once

#include <limits>
#include <optional>
#include <vector>

namespace sim2sim {

/// Confidence of all intervals, unless a function says otherwise.
constexpr double kConfidence = 0.95;

/// Fewest episodes for an interval of a mean, a median or a pair of rates. With 10 episodes the intervals cover the
/// truth in 94.5 to 98.8 % of simulated runs (nominal: 95 %), those of means of quantities with a longer tail in 93 %.
/// Fewer were not simulated.
constexpr int kFewestEpisodes = 10;

/// Fewest pairs for Student's t on paired differences. With 20 pairs it covers the truth in 93 to 98 % of simulated
/// runs, from 200 on in 94.4 to 95.9 %.
constexpr int kFewestPairs = 20;

/// Values that differ by at most this are equal, in the unit of the samples (meters or radians here). Rounding alone
/// leaves angles of up to 7.5e-15 rad where nothing moved.
constexpr double kSame = 1e-9;

/// A closed interval.
struct Interval {
  double low;
  double high;
};

/// Wilson's score interval of a success probability, from `successes` of `trials` > 0.
/// Source: E. B. Wilson, "Probable Inference, the Law of Succession, and Statistical Inference" (1927).
Interval wilsonInterval(int successes, int trials);

/// A figure with its interval, in the unit of the samples.
struct Estimate {
  double value = std::numeric_limits<double>::quiet_NaN();  ///< NaN without samples
  std::optional<Interval> interval;                         ///< none below kFewestEpisodes
};

/// Mean of a quantity in [0, `limit`], summed in order, with an interval within that range. There is no interval if the
/// mean is 0, because then no sample tells how large the quantity can be. Samples outside the range by more than kSame,
/// and those that are not finite, are refused.
/// The interval is Student's t on the scale of the logarithm: [m exp(-h), m exp(h)], h = t s / (sqrt(n) m).
/// Source: W. Q. Meeker and L. A. Escobar, "Statistical Methods for Reliability Data" (1998), chapter 7, of positive
/// quantities; t, for the spread is estimated.
Estimate meanOf(const std::vector<double>& samples, double limit = std::numeric_limits<double>::infinity());

/// Median, with an interval between order statistics that hardly depends on the distribution.
/// Source: T. P. Hettmansperger and S. J. Sheather, "Confidence intervals based on interpolated order statistics"
/// (Statistics & Probability Letters, 1986).
Estimate medianOf(std::vector<double> samples);

/// Standard deviation of the population behind at least two samples (n - 1), in their unit.
double standardDeviation(const std::vector<double>& samples);

/// Quantile `p`, 0 <= p <= 1, of at least one sample in rising order, interpolated between two samples.
/// Source: type 7 of R. J. Hyndman and Y. Fan, "Sample Quantiles in Statistical Packages" (1996); numpy's default.
double quantileOf(const std::vector<double>& sorted, double p);

/// Mean of paired differences, with the p-value of a test against 0.
struct Difference {
  double value = std::numeric_limits<double>::quiet_NaN();  ///< NaN without differences
  std::optional<Interval> interval;                         ///< none below kFewestPairs
  std::optional<double> p;                                  ///< two-sided; none below kFewestPairs
};

/// Mean of paired differences by Student's t, at any `confidence` in (0, 1); for m simultaneous intervals after
/// Bonferroni it is 1 - (1 - kConfidence) / m. Differences that are all equal to within kSame have no spread, hence no
/// interval; p is 1 if they are all zero, and otherwise there is none.
/// Source: Student, "The Probable Error of a Mean" (1908).
Difference meanDifference(const std::vector<double>& differences, double confidence = kConfidence);

}  // namespace sim2sim
