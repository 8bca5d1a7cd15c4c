// SPDX-License-Identifier: BSD-3-Clause
/// Figures of rankings without a check of their input, and the rates that they compare. Private to the rankings.
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

namespace sim2sim {

using Values = std::vector<double>;

inline constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

inline double square(double x) { return x * x; }

/// 1 if a > b, -1 if a < b, and 0 otherwise.
inline int order(double a, double b) { return (a > b ? 1 : 0) - (a < b ? 1 : 0); }

/// Whether two values differ.
bool hasSpread(const Values& values);

/// Ranks from 1; ties have the average of theirs.
Values ranksOf(const Values& values);

/// Pearson's correlation; NaN if either side has no spread.
double correlation(const Values& first, const Values& second);

/// Mean maximum rank violation, in the unit of the reference.
double violation(const Values& test, const Values& reference);

/// Jackknife's variance, from the figures without each sample in turn.
double jackknifeVariance(const Values& left_out);

/// Quantile of Student's t at which an interval ends, from so many samples.
double studentsCritical(std::size_t samples);

/// Success rates of the policies.
struct PolicyRates {
  Values reference;
  Values test;

  /// Rates of all other policies.
  PolicyRates without(std::size_t policy) const;

  /// Whether no single policy makes the whole spread of one side.
  bool spreadWithoutAny() const;
};

}  // namespace sim2sim
