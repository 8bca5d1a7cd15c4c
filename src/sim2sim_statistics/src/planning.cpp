// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/planning.hpp"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/complement.hpp>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <string>

#include "sim2sim_statistics/common.hpp"
#include "sim2sim_statistics/intervals.hpp"

namespace sim2sim {
namespace {

double normalQuantile(double p) { return boost::math::quantile(boost::math::normal(), p); }

double testQuantile() { return normalQuantile(0.5 * (1.0 + kConfidence)); }

void requireEpisodes(int episodes) {
  if (episodes < 1 || episodes > kMostEpisodes) {
    refuse("episodes", episodes, "from 1 to " + std::to_string(kMostEpisodes));
  }
}

void requireDeviation(double standard_deviation) {
  if (!(standard_deviation >= 0.0 && std::isfinite(standard_deviation))) {
    refuse("standard deviation", standard_deviation, "a finite number of at least 0");
  }
}

void requireAboveZero(double difference) {
  if (!(difference > 0.0)) {
    refuse("difference", difference, "above 0");
  }
}

void requireRates(double discordant, double difference) {
  if (!(discordant > 0.0 && discordant <= 1.0)) {
    refuse("discordant share", discordant, "above 0 and at most 1");
  }
  if (!(difference >= 0.0 && difference <= discordant)) {
    refuse("difference", difference, "from 0 to the discordant share", discordant);
  }
}

/// The most of the rarer kind among `discordant` pairs that the mid-p test still calls a difference; -1 if there is no
/// such number. It is at least `guess`.
int rareEnough(int discordant, int guess) {
  const boost::math::binomial coin(discordant, 0.5);
  const auto finds = [&](int rarer) {
    return 2 * rarer < discordant && 2.0 * cdf(coin, rarer) - pdf(coin, rarer) <= 1.0 - kConfidence;
  };
  while (finds(guess + 1)) {
    ++guess;
  }
  return guess;
}

/// mcnemarPower of what has been checked.
double powerOf(double discordant, double difference, int episodes) {
  const boost::math::binomial number(episodes, discordant);
  constexpr double kReach = 7.0;  // [standard deviations] from the mean: beyond lie 3e-12 of the outcomes
  const double reach = kReach * standard_deviation(number) + 1.0;
  const int first = std::max(0, static_cast<int>(mean(number) - reach));
  const int last = std::min(episodes, static_cast<int>(mean(number) + reach));
  int rarer = std::max(-1, static_cast<int>(0.5 * first - 1.3 * std::sqrt(first)) - 1);  // 2.6 deviations or more
  double power = 0.0;
  for (int pairs = first; pairs <= last; ++pairs) {
    rarer = rareEnough(pairs, rarer);
    if (rarer >= 0) {
      const boost::math::binomial favorable(pairs, 0.5 + 0.5 * difference / discordant);
      power += pdf(number, pairs) * (cdf(favorable, rarer) + cdf(complement(favorable, pairs - rarer - 1)));
    }
  }
  return power;
}

}  // namespace

double smallestDifference(double standard_deviation, int episodes) {
  requireDeviation(standard_deviation);
  if (episodes < kFewestPairs) {
    refuse("episodes", episodes, "at least " + std::to_string(kFewestPairs));
  }
  return (testQuantile() + normalQuantile(kPower)) * standard_deviation / std::sqrt(episodes);
}

std::optional<int> episodesFor(double standard_deviation, double difference) {
  requireDeviation(standard_deviation);
  requireAboveZero(difference);
  const double z = testQuantile() + normalQuantile(kPower);
  const double episodes = std::ceil(std::pow(z * standard_deviation / difference, 2));
  return episodes > kMostEpisodes ? std::nullopt : std::optional(std::max(kFewestPairs, static_cast<int>(episodes)));
}

double mcnemarPower(double discordant, double difference, int episodes) {
  requireRates(discordant, difference);
  requireEpisodes(episodes);
  return powerOf(discordant, difference, episodes);
}

std::optional<double> smallestRateDifference(double discordant, int episodes) {
  requireRates(discordant, 0.0);
  requireEpisodes(episodes);
  constexpr int kBits = 20;
  const auto found = [&](double difference) { return powerOf(discordant, difference, episodes) >= kPower; };
  return found(discordant) ? std::optional(edge(found, discordant, 0.0, kBits)) : std::nullopt;
}

std::optional<int> episodesForRates(double discordant, double difference) {
  requireRates(discordant, difference);
  requireAboveZero(difference);
  const auto found = [&](int episodes) { return powerOf(discordant, difference, episodes) >= kPower; };
  int few = 0;
  int enough = 1;
  while (!found(enough)) {
    if (enough == kMostEpisodes) {
      return std::nullopt;
    }
    few = enough;
    enough = std::min(2 * enough, kMostEpisodes);
  }
  while (enough - few > 1) {
    const int middle = few + (enough - few) / 2;
    (found(middle) ? enough : few) = middle;
  }
  return enough;
}

}  // namespace sim2sim
