// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/tails.hpp"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "sim2sim_statistics/common.hpp"

namespace sim2sim {
namespace {

double normalCdf(double z) { return boost::math::cdf(boost::math::normal(), std::clamp(z, -40.0, 40.0)); }

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void requireAtLeastZero(const char* name, double value) {
  if (!(std::isfinite(value) && value >= 0.0)) {
    refuse(name, value, "a finite number of at least 0");
  }
}

void requireAtLeastZero(const std::vector<double>& samples) {
  for (const double sample : samples) {
    requireAtLeastZero("sample", sample);
  }
}

void requireConfidence(double confidence) {
  if (!(confidence > 0.0 && confidence < 1.0)) {
    refuse("confidence", confidence, "above 0 and below 1");
  }
}

std::vector<double> sizesOf(std::vector<double> samples) {
  for (double& sample : samples) {
    if (!std::isfinite(sample)) {
      refuse("sample", sample, "a finite number");
    }
    sample = std::abs(sample);
  }
  return samples;
}

double largestOf(const std::vector<double>& samples, double extreme) {
  return std::accumulate(samples.begin(), samples.end(), extreme, [](double a, double b) { return std::max(a, b); });
}

/// The cumulants of a sum of the values, each weighted by a standard exponential variable, tilted by exp(t sum).
struct Tilted {
  double generator = 0.0;  ///< K(t) = -sum ln(1 - t v)
  double first = 0.0;      ///< derivatives of K at t
  double second = 0.0;
  double third = 0.0;

  Tilted(const std::vector<double>& values, double t) {
    for (const double value : values) {
      const double left = 1.0 - t * value;
      const double ratio = value / left;
      generator -= std::log(left);
      first += ratio;
      second += ratio * ratio;
      third += 2.0 * ratio * ratio * ratio;
    }
  }
};

/// Where the tilted sum is zero in the mean; `least` < 0 < `greatest` of the values.
double saddlepoint(const std::vector<double>& values, double least, double greatest) {
  constexpr int kBits = 40;
  constexpr double kInside = 1.0 - 1e-12;  // at either end K is infinite
  const bool is_negative = sumOf(values) > 0.0;
  const double low = is_negative ? kInside / least : 0.0;
  const double high = is_negative ? 0.0 : kInside / greatest;
  std::uintmax_t steps = 200;
  const auto slope = [&values](double t) {
    double first = 0.0;
    double second = 0.0;
    for (const double value : values) {
      const double ratio = value / (1.0 - t * value);
      first += ratio;
      second += ratio * ratio;
    }
    return std::make_tuple(first, second);
  };
  return boost::math::tools::newton_raphson_iterate(slope, 0.0, low, high, kBits, steps);
}

/// The normal quantile of the probability that the mean of the values with uniform Dirichlet weights is at most zero:
/// that of a sum with exponential weights. The error of the probability is below 0.002 near 0.025 and 0.975.
/// Source: R. Lugannani and S. Rice, "Saddle point approximation for the distribution of the sum of independent random
/// variables" (Advances in Applied Probability, 1980), in the form of O. E. Barndorff-Nielsen (Biometrika, 1986).
double signedRoot(const std::vector<double>& values) {
  const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
  if (*greatest <= 0.0) {
    return kInfinity;
  }
  if (*least >= 0.0) {
    return -kInfinity;
  }
  const double t = saddlepoint(values, *least, *greatest);
  const Tilted tilted(values, t);
  const double w = std::copysign(std::sqrt(std::max(0.0, -2.0 * tilted.generator)), t);
  const double u = t * std::sqrt(tilted.second);
  constexpr double kMiddle = 1e-3;  // closer to it the quotient below is rounding
  return std::abs(w) < kMiddle ? w + tilted.third / (6.0 * std::pow(tilted.second, 1.5)) : w + std::log(u / w) / w;
}

/// Deviations of the samples and one more from a hypothesis.
using Residuals = std::function<std::vector<double>(double)>;

/// The hypothesis between `inside` and `outside` beyond which the share (1 - `confidence`) / 2 of weighted means lies.
/// The signed root rises with the hypothesis.
double endOf(const Residuals& residuals, double inside, double outside, double confidence = kConfidence) {
  const double z = boost::math::quantile(boost::math::normal(), 0.5 * (1.0 + confidence));
  const bool is_upper = outside > inside;
  constexpr double kFarthest = 40.0;  // in place of infinity, which no search could take
  const auto beyond = [&](double hypothesis) {
    return std::clamp(signedRoot(residuals(hypothesis)), -kFarthest, kFarthest) + (is_upper ? -z : z);
  };
  const auto [low, high] = std::minmax(inside, outside);
  const double at_low = beyond(low);
  const double at_high = beyond(high);
  if (at_low >= 0.0 || at_high <= 0.0) {
    return (at_low >= 0.0) == is_upper ? inside : outside;
  }
  constexpr int kBits = 44;
  std::uintmax_t steps = 200;
  const auto [below, above] = boost::math::tools::toms748_solve(
      beyond, low, high, at_low, at_high, boost::math::tools::eps_tolerance<double>(kBits), steps);
  return 0.5 * (below + above);
}

/// Deviations from a mean.
Residuals ofMean(const std::vector<double>& samples, double one_more) {
  return [&samples, one_more](double mean) {
    std::vector<double> values(samples);
    values.push_back(one_more);
    for (double& value : values) {
      value -= mean;
    }
    return values;
  };
}

/// Deviations from a ratio, by its logarithm: numerator - ratio x denominator.
Residuals ofRatio(const std::vector<double>& numerators, const std::vector<double>& denominators, double numerator,
                  double denominator) {
  return [&numerators, &denominators, numerator, denominator](double log_ratio) {
    const double ratio = std::exp(log_ratio);
    std::vector<double> values(numerators.size());
    std::transform(numerators.begin(), numerators.end(), denominators.begin(), values.begin(),
                   [ratio](double above, double below) { return above - ratio * below; });
    values.push_back(numerator - ratio * denominator);
    return values;
  };
}

bool isTooFew(const std::vector<double>& samples) { return samples.size() < static_cast<std::size_t>(kFewestOfTail); }

}  // namespace

double shareOfLargest(std::vector<double> samples) {
  constexpr std::size_t kPart = 20;  // one of so many samples is among the largest
  requireAtLeastZero(samples);
  std::sort(samples.begin(), samples.end());
  const double sum = sumOf(samples);
  const auto largest = static_cast<std::ptrdiff_t>((samples.size() + kPart - 1) / kPart);
  return sum > 0.0 ? std::accumulate(samples.end() - largest, samples.end(), 0.0) / sum
                   : std::numeric_limits<double>::quiet_NaN();
}

bool isCarriedByFew(std::vector<double> samples, double extreme) {
  constexpr double kShare = 0.3;
  constexpr double kExtremes = 8.0;
  requireAtLeastZero("extreme", extreme);
  samples = sizesOf(samples);
  const double sum = sumOf(samples);
  return sum < kExtremes * extreme || shareOfLargest(std::move(samples)) > kShare;
}

std::optional<Interval> tailMeanInterval(const std::vector<double>& samples, double extreme) {
  requireAtLeastZero(samples);
  requireAtLeastZero("extreme", extreme);
  const double largest = largestOf(samples, extreme);
  if (isTooFew(samples) || largest == 0.0) {
    return std::nullopt;
  }
  const double mean = std::clamp(averageOf(samples), 0.0, largest);  // rounding must not lead it out
  return Interval{endOf(ofMean(samples, 0.0), mean, 0.0), endOf(ofMean(samples, largest), mean, largest)};
}

std::optional<Interval> tailRatioInterval(const std::vector<double>& numerators,
                                          const std::vector<double>& denominators, double extreme, double confidence) {
  requireConfidence(confidence);
  if (numerators.size() != denominators.size()) {
    refuse("number of denominators", denominators.size(), "that of the numerators");
  }
  requireAtLeastZero(numerators);
  requireAtLeastZero(denominators);
  requireAtLeastZero("extreme", extreme);
  const double seen = std::log(sumOf(numerators)) - std::log(sumOf(denominators));
  if (isTooFew(numerators) || !std::isfinite(seen)) {
    return std::nullopt;
  }
  constexpr double kFarthest = 40.0;  // of the logarithm, far beyond what any number of pairs could tell from infinity
  const Residuals lower = ofRatio(numerators, denominators, 0.0, largestOf(denominators, extreme));
  const Residuals upper = ofRatio(numerators, denominators, largestOf(numerators, extreme), 0.0);
  return Interval{std::exp(endOf(lower, seen, seen - kFarthest, confidence)),
                  std::exp(endOf(upper, seen, seen + kFarthest, confidence))};
}

std::optional<Interval> tailRatioToLargest(const std::vector<double>& numerators,
                                           const std::vector<std::vector<double>>& denominators, double extreme) {
  if (denominators.empty()) {
    refuse("number of lists of denominators", 0, "at least 1");
  }
  const double confidence = 1.0 - (1.0 - kConfidence) / static_cast<double>(denominators.size());
  std::optional<Interval> least;
  for (const std::vector<double>& denominator : denominators) {
    const std::optional<Interval> ratio = tailRatioInterval(numerators, denominator, extreme, confidence);
    if (!ratio) {
      return std::nullopt;
    }
    const Interval so_far = least.value_or(*ratio);
    least = Interval{std::min(so_far.low, ratio->low), std::min(so_far.high, ratio->high)};
  }
  return least;
}

Difference tailDifference(const std::vector<double>& differences, double extreme, double confidence) {
  requireAtLeastZero("extreme", extreme);
  requireConfidence(confidence);
  const double size = largestOf(sizesOf(differences), extreme);
  if (differences.empty()) {
    return {};
  }
  const double mean = std::clamp(averageOf(differences), -size, size);
  if (isTooFew(differences)) {
    return {mean, std::nullopt, std::nullopt};
  }
  if (size == 0.0) {
    return {mean, std::nullopt, 1.0};
  }
  const Residuals lower = ofMean(differences, -size);
  const Residuals upper = ofMean(differences, size);
  const double p = 2.0 * std::min(normalCdf(signedRoot(lower(0.0))), normalCdf(-signedRoot(upper(0.0))));
  return {mean, Interval{endOf(lower, mean, -size, confidence), endOf(upper, mean, size, confidence)},
          std::min(1.0, p)};
}

Difference pairedDifference(const std::vector<double>& differences, const std::optional<double>& extreme) {
  const auto [least, greatest] = std::minmax_element(differences.begin(), differences.end());
  const bool has_spread = least != differences.end() && *greatest - *least > kSame;
  return extreme && has_spread && isCarriedByFew(differences, *extreme) ? tailDifference(differences, *extreme)
                                                                        : meanDifference(differences);
}

}  // namespace sim2sim
