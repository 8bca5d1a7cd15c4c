// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/results/statistics.hpp"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numeric>

namespace sim2sim {
namespace {

/// The probability below which the upper end of a two-sided interval lies.
constexpr double kUpperTail = 0.5 * (1.0 + kConfidence);

}  // namespace

Interval wilsonInterval(int successes, int trials) {
  const double n = trials;
  const double p = successes / n;
  const double z = boost::math::quantile(boost::math::normal(), kUpperTail);
  const double shrink = 1.0 + z * z / n;
  const double centre = (p + z * z / (2.0 * n)) / shrink;
  const double half_width = z / shrink * std::sqrt(p * (1.0 - p) / n + z * z / (4.0 * n * n));
  // At the ends of the scale the formula gives 0 or 1 but for rounding.
  return {successes == 0 ? 0.0 : centre - half_width, successes == trials ? 1.0 : centre + half_width};
}

std::optional<Interval> aboveZero(const std::optional<Interval>& interval) {
  return interval ? std::optional(Interval{std::max(0.0, interval->low), interval->high}) : std::nullopt;
}

Mean meanOf(const std::vector<double>& samples) {
  const auto n = static_cast<double>(samples.size());
  const double mean = std::accumulate(samples.begin(), samples.end(), 0.0) / n;
  if (samples.size() < 2) {
    return {mean, std::nullopt};
  }
  const double squares = std::accumulate(samples.begin(), samples.end(), 0.0, [mean](double sum, double sample) {
    return sum + (sample - mean) * (sample - mean);
  });
  const double standard_error = std::sqrt(squares / (n - 1.0) / n);
  const double half_width = boost::math::quantile(boost::math::students_t(n - 1.0), kUpperTail) * standard_error;
  return {mean, Interval{mean - half_width, mean + half_width}};
}

}  // namespace sim2sim
