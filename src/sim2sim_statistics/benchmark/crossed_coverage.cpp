// SPDX-License-Identifier: BSD-3-Clause
#include "crossed_coverage.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "coverage_tables.hpp"
#include "known_truths.hpp"
#include "sim2sim_statistics/crossed.hpp"
#include "sim2sim_statistics/tails.hpp"
#include "tail_coverage.hpp"

namespace sim2sim {
namespace {

/// Policies (rows) and initial states (columns) of a run.
struct CrossedShape {
  std::size_t policies;
  std::size_t starts;
};

constexpr std::array kCrossedShapes = {CrossedShape{5, 20},   CrossedShape{5, 100},  CrossedShape{5, 1000},
                                       CrossedShape{8, 100},  CrossedShape{8, 1000}, CrossedShape{20, 100},
                                       CrossedShape{20, 1000}};

/// Success in two simulators: the probability of each episode is the rate of the simulator plus the effects.
struct Design {
  std::string name;
  double home;         ///< success rate in the reference
  double away;         ///< success rate in the other simulator
  double policy;       ///< standard deviation of the policies' effects; those in the two simulators correlate by 0.5
  double start;        ///< likewise of the initial states' effects
  double interaction;  ///< size of the effect of each policy on each initial state, up or down, in both simulators
  bool skewed;         ///< effects of the policies are exponential instead of normal
};

/// Largest effect in standard deviations, so that probabilities stay from 0 to 1.
constexpr double kCut = 2.5;

double cutNormal(Random& random) {
  double z = normal(random);
  while (std::abs(z) > kCut) {
    z = normal(random);
  }
  return z;
}

/// Effects of one policy or initial state in the two simulators, of mean 0.
std::array<double, 2> effects(double deviation, bool skewed, Random& random) {
  constexpr double kCorrelation = 0.5;
  if (skewed) {
    const double common = -std::log(1.0 - uniform(random));
    return {deviation * (common - 1.0), deviation * (common - 1.0)};
  }
  const double first = cutNormal(random);
  const double second = kCorrelation * first + std::sqrt(1.0 - kCorrelation * kCorrelation) * cutNormal(random);
  return {deviation * first, deviation * second};
}

using Rows = std::vector<std::vector<double>>;

constexpr double kFurther = 0.1;  ///< share by which the success of the other recipe is lower

/// Successes of further policies from the same initial states, in the other simulator, by another recipe: their rate is
/// lower by a share of kFurther.
Rows otherRecipe(const Design& design, const std::vector<std::array<double, 2>>& of_starts, std::size_t policies,
                 Random& random) {
  Rows rows(policies);
  for (std::vector<double>& row : rows) {
    const double of_policy = effects(design.policy, design.skewed, random)[1];
    for (const std::array<double, 2>& of_start : of_starts) {
      row.push_back(uniform(random) < (1.0 - kFurther) * design.away + of_policy + of_start[0] ? 1.0 : 0.0);
    }
  }
  return rows;
}

Answers<4> ask(const Design& design, const CrossedShape& shape, Random& random) {
  std::vector<std::array<double, 2>> of_starts(shape.starts);
  std::generate(of_starts.begin(), of_starts.end(), [&] { return effects(design.start, false, random); });
  Rows home(shape.policies, std::vector<double>(shape.starts));
  Rows away = home;
  for (std::size_t policy = 0; policy < shape.policies; ++policy) {
    const std::array<double, 2> of_policy = effects(design.policy, design.skewed, random);
    for (std::size_t start = 0; start < shape.starts; ++start) {
      const double both = uniform(random) < 0.5 ? design.interaction : -design.interaction;
      const double at_home = design.home + of_policy[0] + of_starts[start][0] + both;
      const double at_away = design.away + of_policy[1] + of_starts[start][1] + both;
      home[policy][start] = uniform(random) < at_home ? 1.0 : 0.0;
      away[policy][start] = uniform(random) < at_away ? 1.0 : 0.0;
    }
  }
  const CrossedTable at_home(home);
  const CrossedTable at_away(away);
  const CrossedTable of_others(otherRecipe(design, of_starts, shape.policies, random));
  return {holds(crossedMean(at_away, {0.0, 1.0}).interval, design.away),
          holds(crossedMean(at_away.plus(-1.0, at_home)).interval, design.away - design.home),
          holds(crossedRatio(at_away, at_home).interval, design.away / design.home),
          holds(crossedDifference(at_away, of_others).interval, kFurther * design.away)};
}

std::vector<Design> designs() {
  std::vector<Design> all;
  for (const double policy : {0.02, 0.05, 0.1}) {
    for (const double interaction : {0.0, 0.1}) {
      const std::string name = "policies " + fixedText(policy, 2) + (interaction > 0.0 ? ", interaction" : "");
      all.push_back({name, 0.6, 0.45, policy, 0.05, interaction, false});
    }
  }
  all.push_back({"policies 0.02, rare success", 0.6, 0.1, 0.02, 0.015, 0.0, false});
  all.push_back({"no difference between policies", 0.6, 0.45, 0.0, 0.1, 0.0, false});
  all.push_back({"policies 0.05, skewed", 0.6, 0.3, 0.05, 0.05, 0.0, true});
  return all;
}

/// Divergence of replays: that of a start, times the effects of the policy and of the two together, each of mean 1.
struct DivergenceDesign {
  Population starts;
  double policy;  ///< standard deviation of the logarithm of the policies' effects
  double chance;  ///< likewise of what is left
};

/// Lognormal effect of mean 1.
double factor(double sigma, Random& random) { return std::exp(sigma * normal(random) - 0.5 * sigma * sigma); }

/// Divergences of further policies of a recipe, whose mean is `mean` times that of the starts.
Rows divergencesOf(const DivergenceDesign& design, const std::vector<double>& of_starts, std::size_t policies,
                   double mean, Random& random) {
  Rows rows(policies);
  for (std::vector<double>& row : rows) {
    const double of_policy = mean * factor(design.policy, random);
    for (const double of_start : of_starts) {
      row.push_back(of_start * of_policy * factor(design.chance, random));
    }
  }
  return rows;
}

/// Answers on the mean of a recipe, and on its difference from another one with as many policies or three fewer; none
/// where few starts carry a mean, for then `matrix` has no interval.
Answers<3> ask(const DivergenceDesign& design, const CrossedShape& shape, Random& random) {
  const std::vector<double> of_starts = drawn(design.starts.draw, static_cast<int>(shape.starts), random);
  const CrossedTable more(divergencesOf(design, of_starts, shape.policies, 1.0, random));
  const auto less = [&](std::size_t policies) {
    return CrossedTable(divergencesOf(design, of_starts, policies, 1.0 - kFurther, random));
  };
  const CrossedTable as_many = less(shape.policies);
  const CrossedTable fewer = less(std::max(kFewestRows, shape.policies - 3));
  const auto are_even = [](const CrossedTable& table) { return !isCarriedByFew(table.columnMeans(), 0.0); };
  const auto answer = [](bool is_made, const std::optional<Interval>& interval, double truth) {
    return is_made ? holds(interval, truth) : std::nullopt;
  };
  const double mean = design.starts.mean;
  const bool is_even = are_even(more);
  return {answer(is_even, crossedMean(more, {0.0, std::numeric_limits<double>::infinity()}).interval, mean),
          answer(is_even && are_even(as_many), crossedDifference(more, as_many).interval, kFurther * mean),
          answer(is_even && are_even(fewer), crossedDifference(more, fewer).interval, kFurther * mean)};
}

std::vector<DivergenceDesign> divergenceDesigns() {
  std::vector<DivergenceDesign> all;
  for (const Population& starts : measuredPositions()) {
    for (const double policy : {0.02, 0.1}) {
      all.push_back({starts, policy, 0.5});
    }
  }
  return all;
}

std::vector<std::string> shapeColumns() {
  std::vector<std::string> columns = {"interval", "population"};
  for (const CrossedShape& shape : kCrossedShapes) {
    columns.push_back(std::to_string(shape.policies) + " x " + std::to_string(shape.starts));
  }
  return columns;
}

void crossedDivergences(Simulation& simulation) {
  printHead("The same of divergences [%]; none where few starts carry the mean in all repetitions", shapeColumns());
  const std::vector<DivergenceDesign> all = divergenceDesigns();
  std::vector<std::array<std::array<Proportion, 3>, kCrossedShapes.size()>> shares(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = 0; j < kCrossedShapes.size(); ++j) {
      shares[i].at(j) = simulation.ask<3>([&](Random& random) { return ask(all[i], kCrossedShapes.at(j), random); });
    }
  }
  const std::array names = {"mean", "difference of recipes", "the same, three policies fewer"};
  for (std::size_t question = 0; question < names.size(); ++question) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      std::vector<std::string> cells = {names.at(question),
                                        all[i].starts.name + ", policies " + fixedText(all[i].policy, 2)};
      for (const auto& of_shape : shares[i]) {
        cells.push_back(coverageCell(of_shape.at(question)));
      }
      printRow(cells);
    }
  }
}

}  // namespace

void crossed(Simulation& simulation) {
  const std::vector<std::string> columns = shapeColumns();
  const std::vector<Design> all = designs();
  std::vector<std::array<std::array<Proportion, 4>, kCrossedShapes.size()>> shares(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = 0; j < kCrossedShapes.size(); ++j) {
      shares[i].at(j) = simulation.ask<4>([&](Random& random) { return ask(all[i], kCrossedShapes.at(j), random); });
    }
  }
  printHead("Share of repetitions in which the interval over policies and starts holds the truth [%], nominal 95",
            columns);
  const std::array names = {"success rate", "difference of success", "ratio of success", "difference of recipes"};
  for (std::size_t question = 0; question < names.size(); ++question) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      std::vector<std::string> cells = {names.at(question), all[i].name};
      for (const auto& of_shape : shares[i]) {
        cells.push_back(coverageCell(of_shape.at(question)));
      }
      printRow(cells);
    }
  }
  crossedDivergences(simulation);
}

}  // namespace sim2sim
