// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/equivalence.hpp"

#include <gmock/gmock.h>

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_01.hpp>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <utility>

#include "sim2sim_statistics/pairs.hpp"

namespace sim2sim {
namespace {

constexpr double kBeyond = std::numeric_limits<double>::infinity();

TEST(EquivalentSizes, AreWhereNothingIsLeft) {
  const EquivalentSize found =
      equivalentSize({{0.0, 0.4, {0.3, 0.5}}, {1.0, 0.2, {0.1, 0.3}}, {2.0, -0.2, {-0.3, -0.1}}});
  EXPECT_DOUBLE_EQ(found.value, 1.5);
  EXPECT_EQ(found.interval.low, 1.0);
  EXPECT_EQ(found.interval.high, 2.0);
}

TEST(EquivalentSizes, MayLieBeyondWhatWasTried) {
  const EquivalentSize found = equivalentSize({{0.0, 0.4, {0.3, 0.5}}, {1.0, 0.1, {-0.1, 0.3}}});
  EXPECT_EQ(found.value, kBeyond);
  EXPECT_EQ(found.interval.low, 0.0);
  EXPECT_EQ(found.interval.high, kBeyond);
  EXPECT_EQ(equivalentSize({{0.0, 0.4, {0.3, 0.5}}, {1.0, 0.2, {0.1, 0.3}}}).interval.low, kBeyond);
}

TEST(EquivalentSizes, AreTheSmallestIfNothingIsLost) {
  const EquivalentSize found = equivalentSize({{0.0, -0.1, {-0.2, 0.1}}, {1.0, -0.2, {-0.3, -0.1}}});
  EXPECT_EQ(found.value, 0.0);
  EXPECT_EQ(found.interval.low, 0.0);
  EXPECT_EQ(found.interval.high, 1.0);
  EXPECT_EQ(equivalentSize({{0.0, -0.2, {-0.3, -0.1}}, {1.0, -0.2, {-0.3, -0.1}}}).interval.high, 0.0);
}

TEST(EquivalentSizes, HaveAnIntervalWithAllThatIsNotExcluded) {
  // The surplus falls, rises again and falls: the interval spans all sizes at which nothing may be left.
  const EquivalentSize found = equivalentSize(
      {{0.0, 0.2, {0.1, 0.3}}, {1.0, -0.1, {-0.2, 0.1}}, {2.0, 0.1, {-0.1, 0.2}}, {3.0, -0.3, {-0.4, -0.2}}});
  EXPECT_NEAR(found.value, 2.0 / 3.0, 1e-12);
  EXPECT_EQ(found.interval.low, 0.0);
  EXPECT_EQ(found.interval.high, 3.0);
}

TEST(EquivalentSizes, RefuseWhatIsNoRange) {
  EXPECT_THROW(equivalentSize({{0.0, 0.4, {0.3, 0.5}}}), std::domain_error);
  EXPECT_THROW(equivalentSize({{1.0, 0.4, {0.3, 0.5}}, {1.0, 0.2, {0.1, 0.3}}}), std::domain_error);
}

/// Probability of success with an error of this size, in a start of this difficulty. A steep curve falls between two
/// sizes that are tried, where a line says little.
double successWith(double size, double difficulty, double steepness) {
  return 1.0 / (1.0 + std::exp(steepness * (size - 1.5) + difficulty));
}

class PlantedSize : public ::testing::TestWithParam<std::pair<double, double>> {};

TEST_P(PlantedSize, IsCovered) {
  const auto [steepness, planted] = GetParam();
  constexpr int kRuns = 400;
  constexpr int kStarts = 100;
  boost::random::mt19937 random(20261126);
  boost::random::uniform_01<double> uniform;
  int covered = 0;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<PairTable> tables(5);
    for (int start = 0; start < kStarts; ++start) {
      const double difficulty = 4.0 * uniform(random) - 2.0;
      const auto succeeds = [&, slope = steepness](double size) {
        return uniform(random) < successWith(size, difficulty, slope);
      };
      const bool in_engine = succeeds(planted);
      for (std::size_t size = 0; size < tables.size(); ++size) {
        tables[size].add(in_engine, succeeds(static_cast<double>(size)));
      }
    }
    std::vector<Surplus> surplus;
    for (std::size_t size = 0; size < tables.size(); ++size) {
      surplus.push_back({static_cast<double>(size), tables[size].difference(), tangoInterval(tables[size]).value()});
    }
    const EquivalentSize found = equivalentSize(surplus);
    covered += found.interval.low <= planted && planted <= found.interval.high ? 1 : 0;
    EXPECT_LE(found.interval.low, found.value);
    EXPECT_LE(found.value, found.interval.high);
    EXPECT_LE(found.interval.high - found.interval.low, 3.0) << "a wide interval would say little";
  }
  EXPECT_GE(covered, 368);  // 95 % less three standard errors
}

INSTANTIATE_TEST_SUITE_P(OnGentleAndSteepCurves, PlantedSize,
                         ::testing::Values(std::pair{1.2, 2.0}, std::pair{1.2, 1.5}, std::pair{4.0, 1.6},
                                           std::pair{10.0, 1.4}, std::pair{10.0, 1.0}));

}  // namespace
}  // namespace sim2sim
