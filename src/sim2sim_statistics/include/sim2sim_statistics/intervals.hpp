// SPDX-License-Identifier: BSD-3-Clause
/// How sure a figure of one sample is: rates, means, medians, means of paired differences.
/// How often each interval holds the truth is in docs/statistics.md.
#pragma once

#include <limits>
#include <optional>
#include <vector>

namespace sim2sim {

constexpr double kConfidence = 0.95;  ///< of every interval in a report

/// Below it no interval of a mean, a median or a pair of rates is given. At 10 episodes those given here cover the
/// truth in 94.5 to 98.8 % of simulated runs of the shipped policy (nominal: 95), means of quantities with a longer
/// tail in 93 %. Fewer were not simulated.
constexpr int kFewestEpisodes = 10;

/// Below it there is no Student's t on paired differences. At 20 pairs it covers the truth in 93 to 98 % of simulated
/// runs, from 200 on in 94.4 to 95.9 %.
constexpr int kFewestPairs = 20;

/// [m or rad] What is closer than that is the same: where nothing moved, rounding leaves angles of up to 7.5e-15.
constexpr double kSame = 1e-9;

/// Interval of a figure, in its unit; of 95 % unless said otherwise.
struct Interval {
  double low;
  double high;
};

/// Wilson's score interval of a success probability, from `successes` of `trials` > 0.
/// Source: E. B. Wilson, "Probable Inference, the Law of Succession, and Statistical Inference" (1927).
Interval wilsonInterval(int successes, int trials);

/// A figure, in the unit of its samples.
struct Estimate {
  double value = std::numeric_limits<double>::quiet_NaN();  ///< NaN without samples
  std::optional<Interval> interval;                         ///< none below kFewestEpisodes
};

/// The mean of a quantity that lies in [0, `limit`], summed in order; the interval never leaves that range. There is
/// none if the mean is 0: then no sample tells how large the quantity can be. Samples outside the range by more than
/// kSame, and those that are not finite, are refused.
/// The interval is Student's t on the scale of the logarithm: [m exp(-h), m exp(h)], h = t s / (sqrt(n) m).
/// Source: W. Q. Meeker and L. A. Escobar, "Statistical Methods for Reliability Data" (1998), chapter 7, of positive
/// quantities; t, for the spread is estimated.
Estimate meanOf(const std::vector<double>& samples, double limit = std::numeric_limits<double>::infinity());

/// The median, with an interval between order statistics that hardly depends on the distribution.
/// Source: T. P. Hettmansperger and S. J. Sheather, "Confidence intervals based on interpolated order statistics"
/// (Statistics & Probability Letters, 1986).
Estimate medianOf(std::vector<double> samples);

/// Of at least two samples, which are some of many; in their unit.
double standardDeviation(const std::vector<double>& samples);

/// The `p` quantile, 0 <= p <= 1, of at least one sample in rising order; between two of them it is interpolated.
/// Source: type 7 of R. J. Hyndman and Y. Fan, "Sample Quantiles in Statistical Packages" (1996); numpy's default.
double quantileOf(const std::vector<double>& sorted, double p);

/// The mean of paired differences, and whether it can be told from zero.
struct Difference {
  double value = std::numeric_limits<double>::quiet_NaN();  ///< NaN without differences
  std::optional<Interval> interval;                         ///< none below kFewestPairs
  std::optional<double> p;                                  ///< two-sided; none below kFewestPairs
};

/// Student's t on paired differences, at any `confidence` in (0, 1): for m simultaneous intervals after Bonferroni
/// 1 - (1 - kConfidence) / m. Differences that are all the same to within kSame have no spread that could tell how sure
/// their mean is, hence no interval; p is 1 if they are all zero, and otherwise there is none.
/// Source: Student, "The Probable Error of a Mean" (1908).
Difference meanDifference(const std::vector<double>& differences, double confidence = kConfidence);

}  // namespace sim2sim
