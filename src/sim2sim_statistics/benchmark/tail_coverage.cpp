// SPDX-License-Identifier: BSD-3-Clause
#include "tail_coverage.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "coverage_tables.hpp"
#include "sim2sim_statistics/common.hpp"
#include "sim2sim_statistics/intervals.hpp"
#include "sim2sim_statistics/tails.hpp"

namespace sim2sim {
namespace {

const std::vector<int> kTailSizes = {10, 20, 50, 200, 1000};

/// What diverges from MuJoCo in open loop, in the order of the data's columns: positions, then angles. `kNearest` is
/// the faithful engine with the switch `narrow_phase` off, which differs as little as variants of a simulator do.
enum Source { kNull, kFaithful, kFloor, kNearest, kChipmunk, kTwoMass, kSources };
constexpr std::array kNames = {"null model",     "faithful engine", "floor (1e-6 m)",
                               "nearest points", "Chipmunk",        "two-mass engine"};

constexpr double kMicro = 1e-6;

using Episode = std::array<double, 2 * kSources>;

/// [um, urad] Mean divergences of the shipped policy's first episodes; data/make_divergences.py makes them.
const std::vector<Episode> kEpisodes = {
#include "data/divergences.inc"
};

struct Component {
  const char* name;
  std::size_t offset;  ///< of its columns
  double limit;        ///< [m or rad] of a divergence
};
constexpr std::array kComponents = {Component{"position", 0, std::numeric_limits<double>::infinity()},
                                    Component{"angle", kSources, kPi}};

/// Episodes by their places, with replacement.
using Places = std::vector<std::size_t>;

Places drawn(int n, Random& random) {
  std::uniform_int_distribution<std::size_t> place(0, kEpisodes.size() - 1);
  Places places(n);
  std::generate(places.begin(), places.end(), [&] { return place(random); });
  return places;
}

Places all() {
  Places places(kEpisodes.size());
  std::iota(places.begin(), places.end(), std::size_t{0});
  return places;
}

std::vector<double> divergences(const Places& places, const Component& component, Source source) {
  std::vector<double> samples(places.size());
  std::transform(places.begin(), places.end(), samples.begin(),
                 [&](std::size_t place) { return kMicro * kEpisodes.at(place).at(component.offset + source); });
  return samples;
}

std::vector<double> differences(const Places& places, const Component& component, Source more, Source less) {
  std::vector<double> samples = divergences(places, component, more);
  const std::vector<double> subtracted = divergences(places, component, less);
  std::transform(samples.begin(), samples.end(), subtracted.begin(), samples.begin(), std::minus<>());
  return samples;
}

double meanDivergence(const Places& places, const Component& component, Source source) {
  return averageOf(divergences(places, component, source));
}

/// How far a tee that never moves is from the reference, in the mean of these episodes.
double extremeOf(const Places& places, const Component& component) { return meanDivergence(places, component, kNull); }

using MaybeInterval = std::optional<Interval>;

/// A line of the tables: a method, what it is about, and the truth.
struct Line {
  std::string method;
  std::string of;
  double truth;
  std::function<MaybeInterval(const Places&)> interval;
};

/// "[0.1, 11]", as multiples of the truth.
std::string medianInterval(const Line& line, int n) {
  constexpr int kRepetitions = 201;
  constexpr int kDigits = 2;
  Random random(static_cast<Random::result_type>(n));
  std::vector<double> low;
  std::vector<double> high;
  for (int i = 0; i < kRepetitions; ++i) {
    if (const MaybeInterval interval = line.interval(drawn(n, random))) {
      low.push_back(interval->low / line.truth);
      high.push_back(interval->high / line.truth);
    }
  }
  if (low.empty()) {
    return "none";
  }
  const auto middle = [](std::vector<double>& values) {
    std::sort(values.begin(), values.end());
    return significantText(values[values.size() / 2], kDigits);
  };
  return "[" + middle(low) + ", " + middle(high) + "]";
}

void print(Simulation& simulation, const std::string& title, const std::vector<Line>& lines) {
  printHead("Share of repetitions in which the interval holds " + title + " [%], nominal 95",
            withSizes(kTailSizes, {"interval", "population"}));
  for (const Line& line : lines) {
    printCoverage(simulation, kTailSizes, line.method, line.of, line.truth,
                  [&](int n, Random& random) { return line.interval(drawn(n, random)); });
  }
  printHead("Median interval of " + title + ", in multiples of the truth",
            withSizes(kTailSizes, {"interval", "population"}));
  for (const Line& line : lines) {
    printSizes(kTailSizes, line.method, line.of, [&](int n) { return medianInterval(line, n); });
  }
}

std::vector<Line> means() {
  std::vector<Line> lines;
  for (const Component& component : kComponents) {
    for (const Source source : {kFaithful, kFloor, kNearest, kChipmunk, kTwoMass}) {
      const std::string of = std::string(component.name) + ", " + kNames.at(source);
      const double truth = meanDivergence(all(), component, source);
      lines.push_back({"mean, log-t", of, truth, [=](const Places& places) {
                         return meanOf(divergences(places, component, source), component.limit).interval;
                       }});
      lines.push_back({"mean, Gaffke", of, truth, [=](const Places& places) {
                         return tailMeanInterval(divergences(places, component, source), extremeOf(places, component));
                       }});
    }
  }
  return lines;
}

struct Pair {
  Source first;
  Source second;
};

std::vector<Line> ratios() {
  std::vector<Line> lines;
  for (const Component& component : kComponents) {
    for (const Pair& pair : {Pair{kTwoMass, kFloor}, Pair{kChipmunk, kFloor}, Pair{kFaithful, kFloor},
                             Pair{kTwoMass, kNearest}, Pair{kChipmunk, kNearest}, Pair{kFaithful, kNearest}}) {
      lines.push_back({"ratio, Gaffke",
                       std::string(component.name) + ", " + kNames.at(pair.first) + " over " + kNames.at(pair.second),
                       meanDivergence(all(), component, pair.first) / meanDivergence(all(), component, pair.second),
                       [=](const Places& places) {
                         return tailRatioInterval(divergences(places, component, pair.first),
                                                  divergences(places, component, pair.second),
                                                  extremeOf(places, component));
                       }});
    }
  }
  for (const Component& component : kComponents) {
    for (const Source source : {kTwoMass, kChipmunk, kFaithful}) {
      const double largest =
          std::max(meanDivergence(all(), component, kFloor), meanDivergence(all(), component, kNearest));
      lines.push_back({"ratio to the largest, Gaffke",
                       std::string(component.name) + ", " + kNames.at(source) + " over floor and nearest points",
                       meanDivergence(all(), component, source) / largest, [=](const Places& places) {
                         return tailRatioToLargest(
                             divergences(places, component, source),
                             {divergences(places, component, kFloor), divergences(places, component, kNearest)},
                             extremeOf(places, component));
                       }});
    }
  }
  return lines;
}

std::vector<Line> pairedDifferences() {
  std::vector<Line> lines;
  for (const Component& component : kComponents) {
    for (const Pair& pair : {Pair{kTwoMass, kNull}, Pair{kTwoMass, kChipmunk}, Pair{kChipmunk, kNearest},
                             Pair{kNearest, kFaithful}, Pair{kFaithful, kFloor}}) {
      const std::string of =
          std::string(component.name) + ", " + kNames.at(pair.first) + " - " + kNames.at(pair.second);
      const double truth = meanDivergence(all(), component, pair.first) - meanDivergence(all(), component, pair.second);
      lines.push_back({"difference, t", of, truth, [=](const Places& places) {
                         return meanDifference(differences(places, component, pair.first, pair.second)).interval;
                       }});
      lines.push_back({"difference, Gaffke", of, truth, [=](const Places& places) {
                         return tailDifference(differences(places, component, pair.first, pair.second),
                                               extremeOf(places, component))
                             .interval;
                       }});
      lines.push_back({"difference, as printed", of, truth, [=](const Places& places) {
                         return pairedDifference(differences(places, component, pair.first, pair.second),
                                                 extremeOf(places, component))
                             .interval;
                       }});
    }
  }
  return lines;
}

std::vector<Line> medians() {
  std::vector<Line> lines;
  for (const Component& component : kComponents) {
    for (const Source source : {kFaithful, kFloor, kNearest, kChipmunk, kTwoMass}) {
      lines.push_back({"median, order statistics", std::string(component.name) + ", " + kNames.at(source),
                       medianOf(divergences(all(), component, source)).value, [=](const Places& places) {
                         return medianOf(divergences(places, component, source)).interval;
                       }});
    }
  }
  return lines;
}

}  // namespace

std::vector<Population> measuredPositions() {
  std::vector<Population> populations;
  for (const Source source : {kTwoMass, kChipmunk, kNearest}) {
    populations.push_back(
        resampled(kNames.at(source), divergences(all(), kComponents.front(), source), kComponents.front().limit));
  }
  return populations;
}

void tails(Simulation& simulation) {
  print(simulation, "the mean divergence", means());
  print(simulation, "the ratio of mean divergences", ratios());
  print(simulation, "the mean difference of divergences", pairedDifferences());
  print(simulation, "the median divergence", medians());
}

}  // namespace sim2sim
