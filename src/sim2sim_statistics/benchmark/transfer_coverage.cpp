// SPDX-License-Identifier: BSD-3-Clause
#include "transfer_coverage.hpp"

#include <array>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "coverage_tables.hpp"
#include "known_truths.hpp"
#include "sim2sim_statistics/repeats.hpp"
#include "sim2sim_statistics/sequential.hpp"

namespace sim2sim {
namespace {

/// Starts of a run, and how often each is played.
struct PairDesign {
  int starts;
  int repeats;

  std::string name() const { return std::to_string(starts) + " x " + std::to_string(repeats); }
};

constexpr std::array kPairDesigns = {PairDesign{10, 1},   PairDesign{20, 1}, PairDesign{50, 1}, PairDesign{200, 1},
                                     PairDesign{1000, 1}, PairDesign{25, 5}, PairDesign{50, 10}};

/// Success rates of a policy in the reference and in the engine.
struct PolicyRates {
  double home;
  double away;

  double transfer() const { return away / home; }
  std::string name() const { return fixedText(home, 2) + " to " + fixedText(away, 2); }
};

/// Two policies. A rollout succeeds if a normal number is low, of which the start has a share `difficulty`, and luck
/// the rest.
struct TwoPolicies {
  PolicyRates first;
  PolicyRates second;
  double difficulty;

  double difference() const { return second.transfer() - first.transfer(); }
  std::string name() const {
    return first.name() + ", " + second.name() + ", share of the start " + fixedText(difficulty, 1);
  }
};

constexpr std::array kTwoPolicies = {
    TwoPolicies{{0.62, 0.20}, {0.62, 0.20}, 0.0},  TwoPolicies{{0.62, 0.20}, {0.62, 0.20}, 0.6},
    TwoPolicies{{0.60, 0.51}, {0.75, 0.71}, 0.3},  TwoPolicies{{0.60, 0.51}, {0.75, 0.71}, 0.8},
    TwoPolicies{{0.90, 0.85}, {0.90, 0.85}, 0.5},  TwoPolicies{{0.40, 0.50}, {0.55, 0.30}, 0.5},
    TwoPolicies{{0.60, 0.05}, {0.60, 0.05}, 0.5},  TwoPolicies{{0.30, 0.20}, {0.90, 0.60}, 0.5},
    TwoPolicies{{0.95, 0.95}, {0.80, 0.80}, 0.95},
};

/// Tables of both policies by start.
struct Played {
  std::vector<PairTable> first;
  std::vector<PairTable> second;
};

Played playBoth(const TwoPolicies& policies, const PairDesign& design, Random& random) {
  const boost::math::normal normals;
  const std::array bounds = {quantile(normals, policies.first.home), quantile(normals, policies.first.away),
                             quantile(normals, policies.second.home), quantile(normals, policies.second.away)};
  const auto starts = static_cast<std::size_t>(design.starts);
  Played played{std::vector<PairTable>(starts), std::vector<PairTable>(starts)};
  for (std::size_t start = 0; start < starts; ++start) {
    const double of_start = std::sqrt(policies.difficulty) * normal(random);
    const auto succeeds = [&](double bound) {
      return of_start + std::sqrt(1.0 - policies.difficulty) * normal(random) < bound;
    };
    for (int repeat = 0; repeat < design.repeats; ++repeat) {
      const bool home = succeeds(bounds[0]);
      played.first[start].add(home, succeeds(bounds[1]));
      const bool other_home = succeeds(bounds[2]);
      played.second[start].add(other_home, succeeds(bounds[3]));
    }
  }
  return played;
}

/// Whether the interval holds the truth, and whether the test excludes it; of a difference that is not 0 no test.
Answers<2> askBoth(const TwoPolicies& policies, const PairDesign& design, Random& random) {
  const Played played = playBoth(policies, design, random);
  const Difference found = differenceOfRatios(played.first, played.second);
  const bool are_equal = std::abs(policies.difference()) < kSame;
  return {holds(found.interval, policies.difference()),
          are_equal && found.p ? std::optional(*found.p <= kErrorRate) : std::nullopt};
}

}  // namespace

void transferDifferences(Simulation& simulation) {
  std::array<std::array<std::array<Proportion, 2>, kPairDesigns.size()>, kTwoPolicies.size()> shares;
  for (std::size_t i = 0; i < kTwoPolicies.size(); ++i) {
    for (std::size_t j = 0; j < kPairDesigns.size(); ++j) {
      shares.at(i).at(j) =
          simulation.ask<2>([&](Random& random) { return askBoth(kTwoPolicies.at(i), kPairDesigns.at(j), random); });
    }
  }
  std::vector<std::string> columns = {"figure", "policies"};
  for (const PairDesign& design : kPairDesigns) {
    columns.push_back(design.name());
  }
  const auto print = [&](const std::string& title, const std::string& figure, std::size_t question, auto cell) {
    printHead(title, columns);
    for (std::size_t i = 0; i < kTwoPolicies.size(); ++i) {
      std::vector<std::string> cells = {figure, kTwoPolicies.at(i).name()};
      for (const auto& of_design : shares.at(i)) {
        cells.push_back(cell(of_design.at(question)));
      }
      if (question == 0 || std::abs(kTwoPolicies.at(i).difference()) < kSame) {
        printRow(cells);
      }
    }
  };
  print("Share of repetitions in which the interval of the difference of two transfers holds it [%], nominal 95",
        "difference of transfers", 0, coverageCell);
  print("Share of repetitions in which a test finds a difference of two transfers that is not there [%], nominal 5",
        "difference of transfers", 1, errorCell);
}

}  // namespace sim2sim
