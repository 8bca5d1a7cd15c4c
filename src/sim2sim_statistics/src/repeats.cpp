// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/repeats.hpp"

#include <algorithm>
#include <boost/math/distributions/complement.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <cstddef>
#include <functional>
#include <iterator>

#include "pair_scores.hpp"
#include "sim2sim_statistics/common.hpp"
#include "sim2sim_statistics/tails.hpp"
#include "wilson.hpp"

namespace sim2sim {
namespace {

constexpr double kUpperQuantile = 0.5 * (1.0 + kConfidence);

boost::math::students_t studentsOf(std::size_t starts) {
  return boost::math::students_t(static_cast<double>(starts) - 1.0);
}

bool areTooFew(std::size_t starts) { return starts < static_cast<std::size_t>(kFewestEpisodes); }

/// Factor by which the variance of a figure is larger than if all episodes were independent. `residuals` has the sum of
/// the residuals of each start; `variance` is that of the residual of an episode.
double designEffect(const std::vector<double>& residuals, double variance, double episodes) {
  constexpr double kDoubt = 0.5;  // variance, in starts, of what is seen: with less of it, half the doubt remains
  const auto starts = static_cast<double>(residuals.size());
  const double most = episodes / starts;
  if (variance <= 0.0) {
    return most;
  }
  double squares = 0.0;
  for (const double residual : residuals) {
    squares += residual * residual;
  }
  const double seen = std::clamp(starts / (starts - 1.0) * squares / (episodes * variance), 1.0, most);
  const double weight = starts * variance;
  return (weight * seen + kDoubt * most) / (weight + kDoubt);
}

/// Factor on counts with which a normal quantile stands for Student's t.
double studentsFactor(std::size_t starts) {
  const double z = boost::math::quantile(boost::math::normal(), kUpperQuantile);
  const double ratio = z / quantile(studentsOf(starts), kUpperQuantile);
  return ratio * ratio;
}

PairTable sumOfTables(const std::vector<PairTable>& starts) {
  PairTable sum;
  for (const PairTable& start : starts) {
    start.validate();
    if (start.pairs() < 1) {
      refuse("pairs of a start", start.pairs(), "at least 1");
    }
    sum.both += start.both;
    sum.first_only += start.first_only;
    sum.second_only += start.second_only;
    sum.neither += start.neither;
  }
  return sum;
}

/// Design effect of a figure whose residual in a pair is that of its kind.
double designEffectOf(const std::vector<PairTable>& starts, const PairTable& sum,
                      const std::function<double(bool, bool)>& residual) {
  const double both = residual(true, true);
  const double first_only = residual(true, false);
  const double second_only = residual(false, true);
  const double neither = residual(false, false);
  std::vector<double> residuals(starts.size());
  std::transform(starts.begin(), starts.end(), residuals.begin(), [&](const PairTable& start) {
    return start.both * both + start.first_only * first_only + start.second_only * second_only +
           start.neither * neither;
  });
  const double pairs = sum.pairs();
  const double variance = (sum.both * both * both + sum.first_only * first_only * first_only +
                           sum.second_only * second_only * second_only + sum.neither * neither * neither) /
                          pairs;
  return designEffect(residuals, variance, pairs);
}

Counts scaled(const PairTable& sum, double factor) {
  return {factor * sum.both, factor * sum.second_only, factor * sum.first_only, factor * sum.pairs()};
}

double asNumber(bool success) { return success ? 1.0 : 0.0; }

/// Ratio of success rates, second / first; none if the first never succeeds.
std::optional<double> ratioOf(const PairTable& sum) {
  const double first = sum.both + sum.first_only;
  return first == 0.0 ? std::nullopt : std::optional((sum.both + sum.second_only) / first);
}

/// Effective counts of the interval of a ratio.
Counts countsOfRatio(const std::vector<PairTable>& starts, const PairTable& sum, double ratio) {
  const double effect = designEffectOf(
      starts, sum, [ratio](bool in_first, bool in_second) { return asNumber(in_second) - ratio * asNumber(in_first); });
  return scaled(sum, studentsFactor(starts.size()) / effect);
}

/// Effective counts of a ratio in a difference of two, where starts of one pair each are independent pairs.
Counts countsOfTransfer(const std::vector<PairTable>& starts, const PairTable& sum, double ratio) {
  const bool is_repeated = sum.pairs() > static_cast<int>(starts.size());
  return is_repeated ? countsOfRatio(starts, sum, ratio) : scaled(sum, 1.0);
}

/// Correlation of the estimates of two ratios over the same starts, from the sums of residuals by start; 0 if one has
/// none.
double correlationOf(const std::vector<PairTable>& first, double first_ratio, const std::vector<PairTable>& second,
                     double second_ratio) {
  const auto sum_of = [](const PairTable& start, double ratio) {
    return start.both + start.second_only - ratio * (start.both + start.first_only);
  };
  double products = 0.0;
  double squares_of_first = 0.0;
  double squares_of_second = 0.0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const double of_first = sum_of(first[i], first_ratio);
    const double of_second = sum_of(second[i], second_ratio);
    products += of_first * of_second;
    squares_of_first += of_first * of_first;
    squares_of_second += of_second * of_second;
  }
  const double scale = std::sqrt(squares_of_first * squares_of_second);
  return scale > 0.0 ? std::clamp(products / scale, -1.0, 1.0) : 0.0;
}

/// Distance of an end of the interval of a difference from the difference, from those of its two terms.
double recovered(double of_one, double of_other, double correlation) {
  return std::sqrt(std::max(0.0, of_one * of_one + of_other * of_other - 2.0 * correlation * of_one * of_other));
}

/// Ratio with the counts of its interval.
struct SampledRatio {
  double value;
  Counts counts;
};

/// Interval of the difference of two ratios, second - first, for a normal quantile.
Interval intervalOfDifference(const SampledRatio& first, const SampledRatio& second, double correlation, double z) {
  const Interval less = tang(first.counts, z);
  const Interval more = tang(second.counts, z);
  const double difference = second.value - first.value;
  return {difference - recovered(second.value - more.low, less.high - first.value, correlation),
          difference + recovered(more.high - second.value, first.value - less.low, correlation)};
}

bool holdsZero(const Interval& interval) { return interval.low <= 0.0 && interval.high >= 0.0; }

void requireCounts(const std::vector<StartCount>& starts) {
  for (const StartCount& start : starts) {
    if (start.episodes < 1) {
      refuse("episodes of a start", start.episodes, "at least 1");
    }
    if (start.successes < 0 || start.successes > start.episodes) {
      refuse("successes of a start", start.successes, "from 0 to the number of its episodes");
    }
  }
}

/// Values of one start.
struct StartMoments {
  double mean;
  double variance;  ///< of a value, unbiased
  double values;    ///< how many

  double noiseInMean() const { return variance / values; }
};

/// Sums over starts, from which the variance between them follows.
struct StartSums {
  double starts = 0.0;
  double means = 0.0;
  double squares = 0.0;  ///< of the means
  double noise = 0.0;    ///< in the means

  void add(const StartMoments& start, double times) {
    starts += times;
    means += times * start.mean;
    squares += times * start.mean * start.mean;
    noise += times * start.noiseInMean();
  }

  /// Negative by chance, where there is little.
  double varianceBetween() const { return (squares - means * means / starts) / (starts - 1.0) - noise / starts; }
};

StartSums sumsOf(const std::vector<StartMoments>& starts) {
  StartSums sums;
  for (const StartMoments& start : starts) {
    sums.add(start, 1.0);
  }
  return sums;
}

std::vector<double> variancesOf(const std::vector<StartMoments>& starts) {
  std::vector<double> variances;
  std::transform(starts.begin(), starts.end(), std::back_inserter(variances),
                 [](const StartMoments& start) { return start.variance; });
  return variances;
}

NoiseSplit splitOf(const std::vector<StartMoments>& starts) {
  NoiseSplit split{};
  if (starts.size() > 1) {
    split.starts.value = std::max(0.0, sumsOf(starts).varianceBetween());
    split.repeats.value = averageOf(variancesOf(starts));
  }
  return split;
}

/// Interval of the variance between starts of success.
std::optional<Interval> betweenInterval(const std::vector<StartMoments>& starts) {
  const StartSums all = sumsOf(starts);
  std::vector<double> pseudo_values;
  for (const StartMoments& start : starts) {
    StartSums others = all;
    others.add(start, -1.0);
    pseudo_values.push_back(all.starts * all.varianceBetween() - others.starts * others.varianceBetween());
  }
  const double rate = all.means / all.starts;
  const double farthest = std::max(rate, 1.0 - rate);
  std::optional<Interval> interval = tailDifference(pseudo_values, farthest * farthest).interval;
  if (interval) {
    interval = Interval{std::max(0.0, interval->low), std::max(0.0, interval->high)};
  }
  return interval;
}

}  // namespace

std::optional<Interval> repeatedRateInterval(const std::vector<StartCount>& starts) {
  requireCounts(starts);
  if (areTooFew(starts.size())) {
    return std::nullopt;
  }
  double successes = 0.0;
  double episodes = 0.0;
  for (const StartCount& start : starts) {
    successes += start.successes;
    episodes += start.episodes;
  }
  const double rate = successes / episodes;
  std::vector<double> residuals(starts.size());
  std::transform(starts.begin(), starts.end(), residuals.begin(),
                 [rate](const StartCount& start) { return start.successes - rate * start.episodes; });
  const double effect = designEffect(residuals, rate * (1.0 - rate), episodes);
  const double z = boost::math::quantile(boost::math::normal(), kUpperQuantile);
  const Interval interval = wilson(rate, studentsFactor(starts.size()) * episodes / effect, z);
  return Interval{rate == 0.0 ? 0.0 : interval.low, rate == 1.0 ? 1.0 : interval.high};
}

Difference repeatedDifference(const std::vector<PairTable>& starts) {
  const PairTable sum = sumOfTables(starts);
  if (starts.empty()) {
    return {};
  }
  const double difference = sum.difference();
  if (areTooFew(starts.size())) {
    return {difference, std::nullopt, std::nullopt};
  }
  const double effect = designEffectOf(
      starts, sum, [difference](bool first, bool second) { return asNumber(second) - asNumber(first) - difference; });
  const double discordant = sum.first_only + sum.second_only;
  const double score = std::abs(difference) * sum.pairs() / std::sqrt(std::max(1.0, discordant) * effect);
  return {difference, tango(scaled(sum, studentsFactor(starts.size()) / effect)),
          2.0 * cdf(complement(studentsOf(starts.size()), score))};
}

std::optional<Interval> repeatedRatioInterval(const std::vector<PairTable>& starts) {
  const PairTable sum = sumOfTables(starts);
  const std::optional<double> ratio = ratioOf(sum);
  if (areTooFew(starts.size()) || !ratio) {
    return std::nullopt;
  }
  return tang(countsOfRatio(starts, sum, *ratio));
}

Difference differenceOfRatios(const std::vector<PairTable>& first, const std::vector<PairTable>& second) {
  if (first.size() != second.size()) {
    refuse("starts of the second", second.size(), "as many as of the first, " + std::to_string(first.size()));
  }
  const PairTable sum_of_first = sumOfTables(first);
  const PairTable sum_of_second = sumOfTables(second);
  const std::optional<double> less = ratioOf(sum_of_first);
  const std::optional<double> more = ratioOf(sum_of_second);
  if (!less || !more) {
    return {};
  }
  const double difference = *more - *less;
  if (areTooFew(first.size())) {
    return {difference, std::nullopt, std::nullopt};
  }
  const SampledRatio of_first{*less, countsOfTransfer(first, sum_of_first, *less)};
  const SampledRatio of_second{*more, countsOfTransfer(second, sum_of_second, *more)};
  const double correlation = correlationOf(first, *less, second, *more);
  const auto interval = [&](double z) { return intervalOfDifference(of_first, of_second, correlation, z); };
  constexpr double kFarthest = 38.0;  // the normal tail beyond is below the least double
  const auto excludes_zero = [&](double z) { return !holdsZero(interval(z)); };
  const double score = difference == 0.0 ? 0.0 : edge(excludes_zero, 0.0, kFarthest);
  return {difference, interval(usualQuantile()), 2.0 * cdf(complement(boost::math::normal(), score))};
}

NoiseSplit noiseSplit(const std::vector<std::vector<double>>& starts) {
  std::vector<StartMoments> moments;
  for (const std::vector<double>& values : starts) {
    if (values.size() > 1) {
      const double deviation = standardDeviation(values);
      moments.push_back({averageOf(values), deviation * deviation, static_cast<double>(values.size())});
    }
  }
  return splitOf(moments);
}

NoiseSplit successNoiseSplit(const std::vector<StartCount>& starts) {
  requireCounts(starts);
  std::vector<StartMoments> moments;
  double largest = 0.0;  // variance within a start
  for (const StartCount& start : starts) {
    if (start.episodes > 1) {
      const double values = start.episodes;
      const double mean = start.successes / values;
      const double half = std::floor(0.5 * values) / values;
      moments.push_back({mean, mean * (1.0 - mean) * values / (values - 1.0), values});
      largest = std::max(largest, half * (1.0 - half) * values / (values - 1.0));
    }
  }
  NoiseSplit split = splitOf(moments);
  if (moments.size() >= static_cast<std::size_t>(kFewestOfTail)) {
    split.starts.interval = betweenInterval(moments);
    split.repeats.interval = tailMeanInterval(variancesOf(moments), largest);
  }
  return split;
}

}  // namespace sim2sim
