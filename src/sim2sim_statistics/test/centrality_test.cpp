// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/centrality.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <random>
#include <vector>

#include "sim2sim_statistics/intervals.hpp"

namespace sim2sim {
namespace {

using Rows = std::vector<std::vector<double>>;

std::mt19937_64 centralityDraw(std::uint64_t seed) { return std::mt19937_64(seed); }

/// Rows with these means and noise of their own, and a large part of each column that all rows share.
Rows noisyRows(const std::vector<double>& means, int columns, std::mt19937_64& random) {
  std::exponential_distribution<double> own(1.0);
  std::exponential_distribution<double> shared(0.1);
  Rows rows(means.size());
  for (int column = 0; column < columns; ++column) {
    const double common = shared(random);
    for (std::size_t row = 0; row < means.size(); ++row) {
      rows[row].push_back(means[row] - 1.0 + own(random) + common);
    }
  }
  return rows;
}

TEST(CentralityShares, FindThePlantedMiddleAndEdge) {
  std::mt19937_64 random = centralityDraw(1);
  const auto shares = centralityOf(CrossedTable(noisyRows({3.0, 1.0, 5.0}, 50, random)));
  ASSERT_TRUE(shares);
  EXPECT_GT((*shares)[1].most, 0.999);
  EXPECT_GT((*shares)[2].least, 0.999);
  EXPECT_LT((*shares)[0].most + (*shares)[0].least, 0.001);
}

TEST(CentralityShares, AddUpToOneAndTiesShareAlike) {
  std::mt19937_64 random = centralityDraw(2);
  Rows rows = noisyRows({1.0, 1.1}, 20, random);
  rows.push_back(rows[0]);
  const auto shares = centralityOf(CrossedTable(rows));
  ASSERT_TRUE(shares);
  EXPECT_EQ((*shares)[0].most, (*shares)[2].most);
  EXPECT_EQ((*shares)[0].least, (*shares)[2].least);
  EXPECT_NEAR((*shares)[0].most + (*shares)[1].most + (*shares)[2].most, 1.0, 1e-9);
  EXPECT_NEAR((*shares)[0].least + (*shares)[1].least + (*shares)[2].least, 1.0, 1e-9);
}

/// Two rows that are alike in truth: a share beyond either end of 95 % is an error, in about 5 % of tables.
TEST(CentralityShares, AreSureOfOneOfTwoEqualsInFewTables) {
  constexpr int kTables = 400;
  std::mt19937_64 random = centralityDraw(3);
  int sure = 0;
  for (int table = 0; table < kTables; ++table) {
    const double share = centralityOf(CrossedTable(noisyRows({1.0, 1.0}, 50, random)))->front().most;
    sure += share < 0.025 || share > 0.975 ? 1 : 0;
  }
  EXPECT_GT(sure, kTables * 2 / 100);
  EXPECT_LT(sure, kTables * 9 / 100);
}

TEST(CentralityShares, HaveTheirSeedsBitsAndNeedEpisodes) {
  std::mt19937_64 random = centralityDraw(4);
  const CrossedTable table(noisyRows({1.0, 1.1}, kFewestEpisodes, random));
  EXPECT_EQ(centralityOf(table)->front().most, centralityOf(table, kCentralitySeed)->front().most);
  EXPECT_NEAR(centralityOf(table)->front().most, centralityOf(table, kCentralitySeed + 1)->front().most, 0.06);
  EXPECT_FALSE(centralityOf(CrossedTable(noisyRows({1.0, 1.1}, kFewestEpisodes - 1, random))));
}

}  // namespace
}  // namespace sim2sim
