// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/equivalence.hpp"

#include <gmock/gmock.h>

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_01.hpp>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

#include "sim2sim_statistics/pairs.hpp"

namespace sim2sim {
namespace {

constexpr double kBeyond = std::numeric_limits<double>::infinity();

TEST(EquivalentSizes, AreWhereNothingIsLeft) {
  const EquivalentSize found =
      equivalentSize({{0.0, 0.4, {0.3, 0.5}}, {1.0, 0.2, {0.1, 0.3}}, {2.0, -0.2, {-0.3, -0.1}}});
  EXPECT_DOUBLE_EQ(found.value, 1.5);
  EXPECT_DOUBLE_EQ(found.interval.low, 1.25);
  EXPECT_DOUBLE_EQ(found.interval.high, 1.75);
}

TEST(EquivalentSizes, MayLieBeyondWhatWasTried) {
  const EquivalentSize found = equivalentSize({{0.0, 0.4, {0.3, 0.5}}, {1.0, 0.1, {-0.1, 0.3}}});
  EXPECT_EQ(found.value, kBeyond);
  EXPECT_DOUBLE_EQ(found.interval.low, 0.75);
  EXPECT_EQ(found.interval.high, kBeyond);
}

TEST(EquivalentSizes, AreTheSmallestIfNothingIsLost) {
  const EquivalentSize found = equivalentSize({{0.0, -0.1, {-0.2, 0.1}}, {1.0, -0.2, {-0.3, -0.1}}});
  EXPECT_EQ(found.value, 0.0);
  EXPECT_EQ(found.interval.low, 0.0);
  EXPECT_DOUBLE_EQ(found.interval.high, 0.5);
  EXPECT_EQ(equivalentSize({{0.0, -0.2, {-0.3, -0.1}}, {1.0, -0.2, {-0.3, -0.1}}}).interval.high, 0.0);
}

TEST(EquivalentSizes, HaveAnIntervalWithAllThatIsNotExcluded) {
  // The surplus falls, rises again and falls: the interval spans all sizes at which nothing may be left.
  const EquivalentSize found = equivalentSize(
      {{0.0, 0.2, {0.1, 0.3}}, {1.0, -0.1, {-0.2, 0.1}}, {2.0, 0.1, {-0.1, 0.2}}, {3.0, -0.3, {-0.4, -0.2}}});
  EXPECT_NEAR(found.value, 2.0 / 3.0, 1e-12);
  EXPECT_NEAR(found.interval.low, 1.0 / 3.0, 1e-12);
  EXPECT_DOUBLE_EQ(found.interval.high, 2.5);
}

TEST(EquivalentSizes, RefuseWhatIsNoRange) {
  EXPECT_THROW(equivalentSize({{0.0, 0.4, {0.3, 0.5}}}), std::domain_error);
  EXPECT_THROW(equivalentSize({{1.0, 0.4, {0.3, 0.5}}, {1.0, 0.2, {0.1, 0.3}}}), std::domain_error);
}

/// Probability of success with an error of this size, in a start of this difficulty.
double successWith(double size, double difficulty) { return 1.0 / (1.0 + std::exp(1.2 * (size + difficulty - 1.5))); }

TEST(EquivalentSizes, CoverAPlantedSize) {
  constexpr int kRuns = 400;
  constexpr int kStarts = 100;
  constexpr double kPlanted = 2.0;
  boost::random::mt19937 random(20261126);
  boost::random::uniform_01<double> uniform;
  int covered = 0;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<PairTable> tables(5);
    for (int start = 0; start < kStarts; ++start) {
      const double difficulty = 4.0 * uniform(random) - 2.0;
      const auto succeeds = [&](double size) { return uniform(random) < successWith(size, difficulty); };
      const bool in_engine = succeeds(kPlanted);
      for (std::size_t size = 0; size < tables.size(); ++size) {
        tables[size].add(in_engine, succeeds(static_cast<double>(size)));
      }
    }
    std::vector<Surplus> surplus;
    for (std::size_t size = 0; size < tables.size(); ++size) {
      surplus.push_back({static_cast<double>(size), tables[size].difference(), tangoInterval(tables[size]).value()});
    }
    const EquivalentSize found = equivalentSize(surplus);
    covered += found.interval.low <= kPlanted && kPlanted <= found.interval.high ? 1 : 0;
    EXPECT_LE(found.interval.low, found.value);
    EXPECT_LE(found.value, found.interval.high);
  }
  EXPECT_GE(covered, 368);  // 95 % less three standard errors
  EXPECT_LE(covered, 393);  // and not much more: a wide interval would say little
}

}  // namespace
}  // namespace sim2sim
