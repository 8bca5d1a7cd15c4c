// SPDX-License-Identifier: BSD-3-Clause
/// Score intervals of paired successes, for whole and for effective numbers of pairs. Private to the statistics.
#pragma once

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>

#include "sim2sim_statistics/common.hpp"
#include "sim2sim_statistics/intervals.hpp"

namespace sim2sim {

/// Counts of a table by the letters of the papers; they need not be whole.
struct Counts {
  double a;  ///< both
  double b;  ///< second only
  double c;  ///< first only
  double n;  ///< pairs
};

/// The larger root of a x^2 + b x + c, a > 0, computed without the difference of nearly equal numbers. It has one here:
/// a discriminant below zero is rounding.
inline double largerRoot(double a, double b, double c) {
  const double root = std::sqrt(std::max(0.0, b * b - 4.0 * a * c));
  return b > 0.0 ? -2.0 * c / (b + root) : (root - b) / (2.0 * a);
}

/// Normal quantile of intervals of kConfidence.
inline double usualQuantile() {
  static const double z = boost::math::quantile(boost::math::normal(), 0.5 * (1.0 + kConfidence));
  return z;
}

/// Whether a score, divided by its standard deviation under the hypothesis, does not reject the hypothesis. `z` is the
/// normal quantile of the confidence.
inline bool isLikely(double score, double variance, double z) {
  return std::abs(score) <= z * std::sqrt(std::max(0.0, variance));
}

/// Tango's score of the hypothesis that the rates differ by d. q is how probable a pair of the kind "first only" most
/// likely is if they do.
inline bool isLikelyDifference(const Counts& t, double d) {
  const double q = largerRoot(2.0 * t.n, -t.b - t.c + (2.0 * t.n - t.b + t.c) * d, -t.c * d * (1.0 - d));
  return isLikely(t.b - t.c - t.n * d, t.n * (2.0 * q + d * (1.0 - d)), usualQuantile());
}

/// Tang's score of the hypothesis that the rates have the ratio f; q as above.
inline bool isLikelyRatio(const Counts& t, double f, double z) {
  const double succeeding = t.a + t.b + t.c;
  const double q =
      largerRoot(t.n * (1.0 + f), (t.a + t.c) * f * f - (t.a + t.b + 2.0 * t.c), t.c * (1.0 - f) * succeeding / t.n);
  return isLikely(t.a + t.b - (t.a + t.c) * f, t.n * (1.0 + f) * q + succeeding * (f - 1.0), z);
}

/// Tango's interval of the difference of success rates, second - first.
inline Interval tango(const Counts& t) {
  const double seen = (t.b - t.c) / t.n;
  const auto likely = [&](double d) { return isLikelyDifference(t, d); };
  return {edge(likely, seen, -1.0), edge(likely, seen, 1.0)};
}

/// Tang's interval of the ratio of success rates, second / first. The first must have succeeded.
inline Interval tang(const Counts& t, double z = usualQuantile()) {
  // Bounds of the logarithm, far beyond the ratios that any number of pairs could tell from 0 and from infinity.
  constexpr double kFarthest = 40.0;
  const double seen = (t.a + t.b) / (t.a + t.c);
  const auto likely = [&](double log_ratio) { return isLikelyRatio(t, std::exp(log_ratio), z); };
  const double inside = seen > 0.0 ? std::log(seen) : -kFarthest;
  return {seen > 0.0 ? std::exp(edge(likely, inside, -kFarthest)) : 0.0, std::exp(edge(likely, inside, kFarthest))};
}

}  // namespace sim2sim
