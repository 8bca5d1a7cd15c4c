// SPDX-License-Identifier: BSD-3-Clause
#include "repeat_coverage.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "coverage_tables.hpp"
#include "known_truths.hpp"
#include "sim2sim_statistics/repeats.hpp"
#include "sim2sim_statistics/sequential.hpp"
#include "sim2sim_statistics/tails.hpp"

namespace sim2sim {
namespace {

/// Starts of a run, and how often each is played.
struct RepeatShape {
  int starts;
  int repeats;
};

constexpr std::array kRepeatShapes = {
    RepeatShape{10, 5}, RepeatShape{25, 2},  RepeatShape{25, 5},  RepeatShape{25, 10}, RepeatShape{50, 2},
    RepeatShape{50, 5}, RepeatShape{50, 10}, RepeatShape{100, 2}, RepeatShape{100, 5}, RepeatShape{100, 10}};

/// A policy that succeeds by a coin, whose bias each start draws from a beta distribution. The engine's bias is that of
/// the reference, times a factor, or drawn for itself.
struct Coins {
  double home;           ///< mean bias in the reference
  double away;           ///< in the engine; at most `home`
  double concentration;  ///< of the beta distribution: the larger, the more alike are starts
  bool shared;           ///< both simulators get the same noise
  bool own = false;      ///< the engine's bias is drawn for itself

  double factor() const { return away / home; }
  double betweenStarts() const {
    return (own ? away * (1.0 - away) : factor() * factor() * home * (1.0 - home)) / (concentration + 1.0);
  }
  double withinStarts() const { return away * (1.0 - away) - betweenStarts(); }
  std::string name() const {
    return fixedText(home, 2) + " to " + fixedText(away, 2) + ", concentration " + fixedText(concentration, 1) +
           (own ? ", biases apart" : "") + (shared ? ", shared noise" : "");
  }
};

constexpr double kNullPosition = 0.105;  ///< [m] how far apart a tee that never moves is

double betaNumber(double a, double b, Random& random) {
  const double x = std::gamma_distribution<double>(a)(random);
  return x / (x + std::gamma_distribution<double>(b)(random));
}

/// Pairs of outcomes by start. If `even`, a coin decides in each start which simulator is the better one, so the rates
/// are equal.
std::vector<PairTable> play(const Coins& coins, const RepeatShape& shape, bool even, Random& random) {
  const auto bias = [&](double mean) {
    return betaNumber(mean * coins.concentration, (1.0 - mean) * coins.concentration, random);
  };
  std::vector<PairTable> starts(static_cast<std::size_t>(shape.starts));
  for (PairTable& start : starts) {
    const double home = bias(coins.home);
    const double away = coins.own ? bias(coins.away) : coins.factor() * home;
    const bool swaps = even && uniform(random) < 0.5;
    for (int repeat = 0; repeat < shape.repeats; ++repeat) {
      const double noise = uniform(random);
      const double noise_away = coins.shared ? noise : uniform(random);
      start.add(noise < (swaps ? away : home), noise_away < (swaps ? home : away));
    }
  }
  return starts;
}

std::vector<StartCount> countsOfSecond(const std::vector<PairTable>& starts) {
  std::vector<StartCount> counts;
  counts.reserve(starts.size());
  for (const PairTable& start : starts) {
    counts.push_back({start.both + start.second_only, start.pairs()});
  }
  return counts;
}

/// Answers of one run, in the order of kRepeatFigures; then of intervals that take episodes for independent, by
/// kOfEpisodes.
constexpr std::array kRepeatFigures = {"success rate", "difference", "transfer", "variance between starts",
                                       "variance between repeats"};
constexpr std::array kOfEpisodes = {"success rate, Wilson", "difference, Tango", "transfer, Tang"};

Answers<kRepeatFigures.size() + kOfEpisodes.size()> ask(const Coins& coins, const RepeatShape& shape, Random& random) {
  const std::vector<PairTable> starts = play(coins, shape, false, random);
  const std::vector<StartCount> counts = countsOfSecond(starts);
  const NoiseSplit split = successNoiseSplit(counts);
  PairTable sum;
  for (const PairTable& start : starts) {
    sum = {sum.both + start.both, sum.first_only + start.first_only, sum.second_only + start.second_only,
           sum.neither + start.neither};
  }
  const double difference = coins.away - coins.home;
  return {holds(repeatedRateInterval(counts), coins.away),
          holds(repeatedDifference(starts).interval, difference),
          holds(repeatedRatioInterval(starts), coins.factor()),
          holds(split.starts.interval, coins.betweenStarts()),
          holds(split.repeats.interval, coins.withinStarts()),
          holds(wilsonInterval(sum.both + sum.second_only, sum.pairs()), coins.away),
          holds(tangoInterval(sum), difference),
          holds(tangInterval(sum), coins.factor())};
}

std::vector<Coins> allCoins() {
  std::vector<Coins> all;
  for (const bool shared : {true, false}) {
    for (const double concentration : {0.2, 1.0, 20.0}) {
      all.push_back({0.6, 0.4, concentration, shared});
    }
    all.push_back({0.6, 0.05, 1.0, shared});
    all.push_back({0.95, 0.9, 1.0, shared});
    all.push_back({0.6, 0.4, 1.0, shared, true});
  }
  return all;
}

std::vector<std::string> repeatColumns(const std::string& what) {
  std::vector<std::string> columns = {what, "population"};
  for (const RepeatShape& shape : kRepeatShapes) {
    columns.push_back(std::to_string(shape.starts) + " x " + std::to_string(shape.repeats));
  }
  return columns;
}

/// Divergence of an episode: that of its start, times noise of mean 1.
std::vector<double> meansOfStarts(const Population& starts, double noise, const RepeatShape& shape, Random& random) {
  std::vector<double> means(static_cast<std::size_t>(shape.starts), 0.0);
  for (double& mean : means) {
    const double of_start = starts.draw(random);
    for (int repeat = 0; repeat < shape.repeats; ++repeat) {
      mean += of_start * std::exp(noise * normal(random) - 0.5 * noise * noise) / shape.repeats;
    }
  }
  return means;
}

}  // namespace

void repeats(Simulation& simulation) {
  const std::vector<Coins> coins = allCoins();
  using Shares = std::array<Proportion, kRepeatFigures.size() + kOfEpisodes.size()>;
  std::vector<std::array<Shares, kRepeatShapes.size()>> shares(coins.size());
  for (std::size_t i = 0; i < coins.size(); ++i) {
    for (std::size_t j = 0; j < kRepeatShapes.size(); ++j) {
      shares[i].at(j) = simulation.ask<std::tuple_size_v<Shares>>(
          [&](Random& random) { return ask(coins[i], kRepeatShapes.at(j), random); });
    }
  }
  const auto print = [&](const std::string& name, std::size_t question) {
    for (std::size_t i = 0; i < coins.size(); ++i) {
      std::vector<std::string> cells = {name, coins[i].name()};
      for (const Shares& of_shape : shares[i]) {
        cells.push_back(coverageCell(of_shape.at(question)));
      }
      printRow(cells);
    }
  };
  printHead("Share of repetitions in which the interval over starts x repeats holds the truth [%], nominal 95",
            repeatColumns("interval"));
  for (std::size_t question = 0; question < kRepeatFigures.size(); ++question) {
    print(kRepeatFigures.at(question), question);
  }
  for (const Population& population : {lognormal("position, lognormal", kPosition)}) {
    for (const double noise : {0.2, 1.0}) {
      std::vector<std::string> cells = {"mean divergence, Gaffke of the starts' means",
                                        population.name + ", noise " + fixedText(noise, 1)};
      for (const RepeatShape& shape : kRepeatShapes) {
        cells.push_back(coverageCell(simulation.ask([&](Random& random) {
          return holds(tailMeanInterval(meansOfStarts(population, noise, shape, random), kNullPosition),
                       population.mean);
        })));
      }
      printRow(cells);
    }
  }
  printHead("The same of intervals that take repeats for independent episodes, which is wrong [%]",
            repeatColumns("interval"));
  for (std::size_t question = 0; question < kOfEpisodes.size(); ++question) {
    print(kOfEpisodes.at(question), kRepeatFigures.size() + question);
  }
  printHead("Share of repetitions in which a test by start finds a difference that is not there [%], nominal 5",
            repeatColumns("test"));
  for (const Coins& even : coins) {
    std::vector<std::string> cells = {"McNemar by start", even.name() + ", better by turns"};
    for (const RepeatShape& shape : kRepeatShapes) {
      cells.push_back(errorCell(simulation.ask([&](Random& random) -> std::optional<bool> {
        const std::optional<double> p = repeatedDifference(play(even, shape, true, random)).p;
        return p ? std::optional(*p <= kErrorRate) : std::nullopt;
      })));
    }
    printRow(cells);
  }
}

}  // namespace sim2sim
