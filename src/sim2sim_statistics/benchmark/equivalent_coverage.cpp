// SPDX-License-Identifier: BSD-3-Clause
#include "equivalent_coverage.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "coverage_tables.hpp"
#include "known_truths.hpp"
#include "sim2sim_statistics/equivalence.hpp"
#include "sim2sim_statistics/pairs.hpp"

namespace sim2sim {
namespace {

const std::vector<int> kStarts = {20, 50, 200, 400};
constexpr std::array kTried = {0.0, 1.0, 2.0, 4.0, 8.0};  // sizes of the error, in control steps
constexpr double kHalfSize = 2.5;                         // size at which half of the success of an easy start is lost

/// Planted size, on a curve of success that falls so steeply.
struct Planted {
  double size;
  double steepness;
};

/// Probability of success with an error of this size, in a start of this difficulty.
double successWith(double size, double difficulty, double steepness) {
  return 1.0 / (1.0 + std::exp(steepness * (size - kHalfSize) + difficulty));
}

/// Interval of the size of an engine that is the reference with the error `planted`. With `same_luck` a start
/// that succeeds with a large error succeeds with every smaller one, as in simulators without noise.
std::optional<Interval> intervalOf(const Planted& planted, bool same_luck, int starts, Random& random) {
  std::array<PairTable, kTried.size()> tables;
  for (int start = 0; start < starts; ++start) {
    const double difficulty = 2.0 * normal(random);
    const double luck = uniform(random);
    const auto succeeds = [&](double size) {
      return (same_luck ? luck : uniform(random)) < successWith(size, difficulty, planted.steepness);
    };
    const bool in_engine = succeeds(planted.size);
    for (std::size_t i = 0; i < kTried.size(); ++i) {
      tables[i].add(in_engine, succeeds(kTried[i]));
    }
  }
  std::vector<Surplus> surplus;
  for (std::size_t i = 0; i < kTried.size(); ++i) {
    surplus.push_back({kTried[i], tables[i].difference(), tangoInterval(tables[i]).value()});
  }
  return equivalentSize(surplus).interval;
}

}  // namespace

void equivalents(Simulation& simulation) {
  printHead("Share of repetitions in which the interval of an equivalent error holds its size [%], nominal 95",
            withSizes(kStarts, {"size (steepness)", "luck of a start"}));
  for (const Planted planted : {Planted{1.0, 1.0}, {1.5, 1.0}, {2.0, 1.0}, {3.0, 1.0}, {2.4, 4.0}, {2.4, 10.0}}) {
    const std::string what = fixedText(planted.size, 1) + " (" + fixedText(planted.steepness, 0) + ")";
    for (const bool same_luck : {true, false}) {
      printCoverage(simulation, kStarts, what, same_luck ? "the same" : "independent", planted.size,
                    [&](int n, Random& random) { return intervalOf(planted, same_luck, n, random); });
    }
  }
}

}  // namespace sim2sim
