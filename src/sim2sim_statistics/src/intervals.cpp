// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/intervals.hpp"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/complement.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "sim2sim_statistics/common.hpp"
#include "wilson.hpp"

namespace sim2sim {
namespace {

/// The probability below which the upper end of a two-sided interval lies.
constexpr double kUpperTail = 0.5 * (1.0 + kConfidence);

/// Moments of samples, summed in order.
struct Moments {
  double mean;
  double standard_error;  ///< of the mean
};

Moments momentsOf(const std::vector<double>& samples) {
  const auto n = static_cast<double>(samples.size());
  const double mean = averageOf(samples);
  const double squares = std::accumulate(samples.begin(), samples.end(), 0.0, [mean](double sum, double sample) {
    return sum + (sample - mean) * (sample - mean);
  });
  return {mean, std::sqrt(squares / (n - 1.0) / n)};
}

boost::math::students_t studentsT(const std::vector<double>& samples) {
  return boost::math::students_t(static_cast<double>(samples.size()) - 1.0);
}

bool isFewerThan(int fewest, const std::vector<double>& samples) {
  return samples.size() < static_cast<std::size_t>(fewest);
}

void requireFinite(const std::vector<double>& samples, const char* name) {
  for (const double sample : samples) {
    if (!std::isfinite(sample)) {
      refuse(name, sample, "a finite number");
    }
  }
}

/// Order statistics around the median: the k-th from either end, moved inwards by a share `inwards` of the way to the
/// next one.
struct Rank {
  int k;
  double inwards;
};

/// Rank for n samples, by Hettmansperger and Sheather. The k-th from either end cover the median with probability
/// 1 - 2 P(B < k), B being binomial (n, 1/2); k is the last rank whose coverage is enough.
Rank medianRank(int n) {
  const boost::math::binomial heads(n, 0.5);
  const auto coverage = [&](int k) { return 1.0 - 2.0 * cdf(heads, k - 1); };
  int k = std::max(1, static_cast<int>(0.5 * n - 1.1 * std::sqrt(n)));  // it is about n / 2 - 0.98 sqrt(n)
  while (coverage(k + 1) >= kConfidence) {
    ++k;
  }
  const double surplus = (coverage(k) - kConfidence) / (coverage(k) - coverage(k + 1));
  return {k, (n - k) * surplus / (k + (n - 2 * k) * surplus)};
}

}  // namespace

Interval wilsonInterval(int successes, int trials) {
  const double z = boost::math::quantile(boost::math::normal(), kUpperTail);
  const double n = trials;
  const Interval interval = wilson(successes / n, n, z);
  // At the ends of the scale the formula gives 0 or 1 but for rounding.
  return {successes == 0 ? 0.0 : interval.low, successes == trials ? 1.0 : interval.high};
}

Estimate meanOf(const std::vector<double>& samples, double limit) {
  for (const double sample : samples) {
    if (!(std::isfinite(sample) && sample >= -kSame && sample <= limit + kSame)) {
      refuse("sample", sample, "from 0 to", limit);
    }
  }
  if (samples.empty()) {
    return {};
  }
  const Moments moments = momentsOf(samples);
  if (isFewerThan(kFewestEpisodes, samples) || moments.mean <= 0.0) {
    return {moments.mean, std::nullopt};
  }
  const double h = boost::math::quantile(studentsT(samples), kUpperTail) * moments.standard_error / moments.mean;
  return {moments.mean,
          Interval{std::min(moments.mean * std::exp(-h), limit), std::min(moments.mean * std::exp(h), limit)}};
}

double standardDeviation(const std::vector<double>& samples) {
  return momentsOf(samples).standard_error * std::sqrt(static_cast<double>(samples.size()));
}

Estimate medianOf(std::vector<double> samples) {
  requireFinite(samples, "sample");
  if (samples.empty()) {
    return {};
  }
  std::sort(samples.begin(), samples.end());
  const double median = quantileOf(samples, 0.5);
  if (isFewerThan(kFewestEpisodes, samples)) {
    return {median, std::nullopt};
  }
  const Rank rank = medianRank(static_cast<int>(samples.size()));
  const auto end = [&](auto outermost) {  // k-th from there
    const double outer = outermost[rank.k - 1];
    return outer + rank.inwards * (outermost[rank.k] - outer);
  };
  return {median, Interval{end(samples.begin()), end(samples.rbegin())}};
}

double quantileOf(const std::vector<double>& sorted, double p) {
  if (sorted.empty()) {
    refuse("number of samples", 0, "at least 1");
  }
  if (!(p >= 0.0 && p <= 1.0)) {
    refuse("p", p, "from 0 to 1");
  }
  const double place = p * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

Difference meanDifference(const std::vector<double>& differences, double confidence) {
  requireFinite(differences, "difference");
  if (!(confidence > 0.0 && confidence < 1.0)) {
    refuse("confidence", confidence, "above 0 and below 1");
  }
  if (differences.empty()) {
    return {};
  }
  const Moments moments = momentsOf(differences);
  if (isFewerThan(kFewestPairs, differences)) {
    return {moments.mean, std::nullopt, std::nullopt};
  }
  const auto [least, greatest] = std::minmax_element(differences.begin(), differences.end());
  if (*greatest - *least <= kSame) {
    return {moments.mean, std::nullopt, std::abs(moments.mean) <= kSame ? std::optional(1.0) : std::nullopt};
  }
  const boost::math::students_t t = studentsT(differences);
  const double half_width = quantile(t, 0.5 * (1.0 + confidence)) * moments.standard_error;
  const double p = 2.0 * cdf(complement(t, std::abs(moments.mean) / moments.standard_error));
  return {moments.mean, Interval{moments.mean - half_width, moments.mean + half_width}, p};
}

}  // namespace sim2sim
