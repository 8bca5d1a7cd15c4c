// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/spread.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "refused.hpp"

namespace sim2sim {
namespace {

using Grid = std::vector<std::vector<double>>;

const std::vector<std::size_t> kGroups = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 3, 3, 3, 3, 3};
constexpr std::array kGroupEffects = {-0.3, 0.0, 0.1, 0.2};
constexpr std::array kSimulatorEffects = {0.4, -0.1, -0.3};
/// By group and simulator; rows and columns add up to 0.
constexpr std::array<std::array<double, 3>, 4> kTogether = {
    {{0.2, -0.1, -0.1}, {-0.2, 0.1, 0.1}, {0.1, 0.1, -0.2}, {-0.1, -0.1, 0.2}}};

/// Standard deviations of what is drawn.
struct Planted {
  double policy = 0.0;
  double policy_simulator = 0.0;
  double start = 0.0;            ///< of a start, alike for all policies and simulators
  double start_simulator = 0.0;  ///< of a start in one simulator, alike for all policies
  double chance = 0.0;
};

std::vector<CrossedTable> tablesOf(const Planted& planted, std::uint64_t seed, std::size_t starts) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  const auto drawn = [&](double deviation) { return deviation * normal(generator); };
  std::vector<double> of_start(starts);
  for (double& effect : of_start) {
    effect = drawn(planted.start);
  }
  std::vector<double> of_policy(kGroups.size());
  for (double& effect : of_policy) {
    effect = drawn(planted.policy);
  }
  std::vector<CrossedTable> tables;
  for (std::size_t simulator = 0; simulator < kSimulatorEffects.size(); ++simulator) {
    std::vector<double> of_start_here(starts);
    for (std::size_t start = 0; start < starts; ++start) {
      of_start_here[start] = of_start[start] + drawn(planted.start_simulator);
    }
    Grid grid;
    for (std::size_t policy = 0; policy < kGroups.size(); ++policy) {
      const double cell = kGroupEffects.at(kGroups[policy]) + kSimulatorEffects.at(simulator) +
                          kTogether.at(kGroups[policy]).at(simulator) + of_policy[policy] +
                          drawn(planted.policy_simulator);
      grid.emplace_back();
      for (std::size_t start = 0; start < starts; ++start) {
        grid.back().push_back(cell + of_start_here[start] + drawn(planted.chance));
      }
    }
    tables.emplace_back(grid);
  }
  return tables;
}

// Means of the squares of the planted effects.
constexpr double kGroupVariance = (0.09 + 0.01 + 0.04) / 4.0;
constexpr double kSimulatorVariance = (0.16 + 0.01 + 0.09) / 3.0;
constexpr double kTogetherVariance = 4.0 * 0.06 / 12.0;

TEST(Spread, FindsEffectsThatNothingHides) {
  const Spread spread = spreadOf(tablesOf({}, 0, 5), kGroups);
  EXPECT_NEAR(spread.group, kGroupVariance, 1e-12);
  EXPECT_NEAR(spread.simulator, kSimulatorVariance, 1e-12);
  EXPECT_NEAR(spread.group_simulator, kTogetherVariance, 1e-12);
  EXPECT_NEAR(spread.policy, 0.0, 1e-12);
  EXPECT_NEAR(spread.policy_simulator, 0.0, 1e-12);
  EXPECT_NEAR(spread.starts, 0.0, 1e-12);
}

/// Starts that all policies and simulators share cannot make cells differ: they must not pass for an effect.
TEST(Spread, FindsPlantedVariancesInNoise) {
  const Planted planted{0.1, 0.08, 0.5, 0.4, 0.6};
  constexpr int kTables = 400;
  constexpr std::size_t kStarts = 40;
  const std::array truth = {kGroupVariance,      kSimulatorVariance, kTogetherVariance,
                            0.01 + 0.0064 / 3.0, 0.0064 * 2.0 / 3.0, (0.25 + 0.16 + 0.36) / kStarts};
  std::array<double, truth.size()> sum{};
  std::array<double, truth.size()> square{};
  for (int table = 0; table < kTables; ++table) {
    const Spread found = spreadOf(tablesOf(planted, static_cast<std::uint64_t>(table) + 1, kStarts), kGroups);
    const std::array values = {found.group,  found.simulator,        found.group_simulator,
                               found.policy, found.policy_simulator, found.starts};
    for (std::size_t i = 0; i < values.size(); ++i) {
      sum.at(i) += values.at(i) / kTables;
      square.at(i) += values.at(i) * values.at(i) / kTables;
    }
  }
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double standard_error = std::sqrt((square.at(i) - sum.at(i) * sum.at(i)) / kTables);
    EXPECT_LT(standard_error, 0.1 * truth.at(i)) << "source " << i << ": only then can this test fail";
    EXPECT_NEAR(sum.at(i), truth.at(i), 4.0 * standard_error) << "source " << i;
  }
}

TEST(Spread, RefusesWhatHasNoSpread) {
  const std::vector<CrossedTable> tables = tablesOf({}, 0, 5);
  const std::vector<std::size_t> one(kGroups.size(), 0);
  expectRefused([&] { return spreadOf({tables.front()}, kGroups); }, "number of simulators 1: must be at least 2");
  expectRefused([&] { return spreadOf(tables, {0, 1}); }, "number of policies 23: must be that of the groups' list");
  expectRefused([&] { return spreadOf(tables, one); },
                "groups: must be at least 2, numbered from 0 on, and one of them have 2 policies");
  expectRefused([&] { return spreadOf(tablesOf({}, 0, 1), kGroups); }, "number of starts 1: must be at least 2");
}

}  // namespace
}  // namespace sim2sim
