// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/crossed.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include "refused.hpp"
#include "sim2sim_statistics/intervals.hpp"

namespace sim2sim {
namespace {

using Grid = std::vector<std::vector<double>>;

std::mt19937_64 tableNumber(std::uint64_t seed) { return std::mt19937_64(seed); }

Grid gridOf(int rows, int columns, const std::function<double(int, int)>& value) {
  Grid grid;
  for (int row = 0; row < rows; ++row) {
    grid.emplace_back();
    for (int column = 0; column < columns; ++column) {
      grid.back().push_back(value(row, column));
    }
  }
  return grid;
}

/// Two tables without a pattern, all values above 0; the columns of the first matter, those of the second do not.
Grid unevenGrid() {
  return gridOf(6, 20, [](int r, int c) { return (7 * r * r + 3 * c + r * c * c) % 11 / 10.0 + 0.3 * r + 0.05 * c; });
}
Grid otherGrid() {
  return gridOf(6, 20, [](int r, int c) { return (5 * r + 2 * c * c + 3 * r * c) % 13 / 10.0 + 1.0 + 0.1 * r; });
}

Grid rescaled(const Grid& grid, double factor, double offset) {
  return gridOf(static_cast<int>(grid.size()), static_cast<int>(grid[0].size()), [&](int r, int c) {
    return factor * grid[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)] + offset;
  });
}

/// Grid without its last rows.
Grid firstRows(Grid grid, std::size_t rows) {
  grid.resize(rows);
  return grid;
}

void expectFigure(const Estimate& estimate, double value, double low, double high, double tolerance = 1e-12) {
  EXPECT_NEAR(estimate.value, value, tolerance);
  ASSERT_TRUE(estimate.interval);
  EXPECT_NEAR(estimate.interval->low, low, tolerance);
  EXPECT_NEAR(estimate.interval->high, high, tolerance);
}

/// By hand: mean 3, means of rows 1.5 and 4.5, of columns 2 and 4, residuals of 0.5.
TEST(Crossed, MeanSquaresOfASmallTable) {
  const CrossedTable table({{1.0, 2.0}, {3.0, 6.0}});
  EXPECT_EQ(table.mean(), 3.0);
  EXPECT_EQ(table.rowMeans(), (std::vector<double>{1.5, 4.5}));
  EXPECT_EQ(table.columnMeans(), (std::vector<double>{2.0, 4.0}));
  const MeanSquares squares = meanSquares(table);
  EXPECT_DOUBLE_EQ(squares.rows, 9.0);
  EXPECT_DOUBLE_EQ(squares.columns, 4.0);
  EXPECT_DOUBLE_EQ(squares.residual, 1.0);
  const VarianceComponents components = varianceComponents(table);
  EXPECT_DOUBLE_EQ(components.row, 4.0);
  EXPECT_DOUBLE_EQ(components.column, 1.5);
  EXPECT_DOUBLE_EQ(components.rest, 1.0);
}

/// Rows and columns have equal means: all variance is the rest, and the estimates of the others are negative.
TEST(Crossed, ComponentsAreAtLeastZero) {
  const CrossedTable table({{0.0, 1.0}, {1.0, 0.0}});
  const VarianceComponents components = varianceComponents(table);
  EXPECT_EQ(components.row, 0.0);
  EXPECT_EQ(components.column, 0.0);
  EXPECT_DOUBLE_EQ(components.rest, 1.0);
}

/// Planted variances of the effects come out, within four standard errors or so.
TEST(Crossed, ComponentsFindPlantedVariances) {
  std::mt19937_64 random = tableNumber(7);
  std::normal_distribution<double> normal;
  std::vector<double> columns(400);
  std::generate(columns.begin(), columns.end(), [&] { return 2.0 * normal(random); });
  Grid grid;
  for (int row = 0; row < 400; ++row) {
    const double of_row = 3.0 * normal(random);
    grid.emplace_back();
    for (const double of_column : columns) {
      grid.back().push_back(5.0 + of_row + of_column + normal(random));
    }
  }
  const VarianceComponents components = varianceComponents(CrossedTable(grid));
  EXPECT_NEAR(components.row, 9.0, 2.5);
  EXPECT_NEAR(components.column, 4.0, 1.1);
  EXPECT_NEAR(components.rest, 1.0, 0.015);
}

/// Computed with numpy 1.24 and scipy 1.10 (special.betaincinv, optimize.brentq) from the formulas.
TEST(Crossed, MatchesAnIndependentImplementation) {
  const MeanSquares squares = meanSquares(CrossedTable(unevenGrid()));
  EXPECT_NEAR(squares.rows, 7.071533333333337, 1e-12);
  EXPECT_NEAR(squares.columns, 0.645157894736842, 1e-12);
  EXPECT_NEAR(squares.residual, 0.10535789473684211, 1e-12);
  expectFigure(crossedMean(CrossedTable(unevenGrid())), 1.6933333333333336, 1.071344194858661, 2.315322471808006);
  expectFigure(crossedMean(CrossedTable(otherGrid())), 1.8575, 1.8575 - 0.22534171572304296,
               1.8575 + 0.22534171572304296);
  expectFigure(crossedRatio(CrossedTable(unevenGrid()), CrossedTable(otherGrid())), 0.91161956034096,
               0.6537041010997111, 1.1163760938690812);
}

/// Columns that do nothing leave a sample of rows.
TEST(CrossedMean, IsStudentsTOfTheRowsIfColumnsDoNothing) {
  const std::vector<double> rows = {0.4, 0.7, 0.5, 0.9, 0.6};
  const CrossedTable alternating(
      gridOf(5, 30, [&](int r, int c) { return rows[static_cast<std::size_t>(r)] + ((r + c) % 2 == 0 ? 0.1 : -0.1); }));
  const double half_width = quantile(boost::math::students_t(4.0), 0.975) * standardDeviation(rows) / std::sqrt(5.0);
  expectFigure(crossedMean(alternating), 0.62, 0.62 - half_width, 0.62 + half_width);
}

TEST(CrossedMean, IsCutOffAtItsLimits) {
  const CrossedTable table(unevenGrid());
  expectFigure(crossedMean(table, {1.2, 2.0}), table.mean(), 1.2, 2.0);
  expectFigure(crossedMean(table, {0.0, 9.0}), table.mean(), 1.071344194858661, 2.315322471808006);
}

TEST(Crossed, DoesNotDependOnTheOrderOfRowsAndColumns) {
  Grid first = unevenGrid();
  Grid second = otherGrid();
  const Estimate ratio = crossedRatio(CrossedTable(first), CrossedTable(second));
  for (Grid* grid : {&first, &second}) {
    std::reverse(grid->begin(), grid->end());
    for (std::vector<double>& row : *grid) {
      std::rotate(row.begin(), row.begin() + 7, row.end());
    }
  }
  expectFigure(crossedMean(CrossedTable(first)), 1.6933333333333336, 1.071344194858661, 2.315322471808006);
  expectFigure(crossedRatio(CrossedTable(first), CrossedTable(second)), ratio.value, ratio.interval->low,
               ratio.interval->high);
}

TEST(Crossed, FollowsScaleAndOffset) {
  expectFigure(crossedMean(CrossedTable(rescaled(unevenGrid(), -2.0, 1.0))), 1.0 - 2.0 * 1.6933333333333336,
               1.0 - 2.0 * 2.315322471808006, 1.0 - 2.0 * 1.071344194858661);
  expectFigure(crossedRatio(CrossedTable(rescaled(unevenGrid(), 3.0, 0.0)), CrossedTable(otherGrid())),
               3.0 * 0.91161956034096, 3.0 * 0.6537041010997111, 3.0 * 1.1163760938690812);
}

TEST(CrossedRatio, IsTheInverseOfTheInverseRatio) {
  const CrossedTable first(unevenGrid());
  const CrossedTable second(otherGrid());
  const Estimate ratio = crossedRatio(first, second);
  const Estimate inverse = crossedRatio(second, first);
  expectFigure(inverse, 1.0 / ratio.value, 1.0 / ratio.interval->high, 1.0 / ratio.interval->low);
}

/// The interval of the paired difference is that of the mean of a - b; a shift that both share drops out.
TEST(Crossed, PairedDifferenceIsAMean) {
  const CrossedTable first(unevenGrid());
  const CrossedTable second(rescaled(unevenGrid(), 1.0, 0.25));
  EXPECT_NEAR(second.plus(-1.0, first).mean(), 0.25, 1e-15);
  const Estimate difference = crossedMean(second.plus(-1.0, first));
  EXPECT_FALSE(difference.interval);  // nothing varies
  EXPECT_TRUE(crossedMean(second.plus(-0.5, first)).interval);
}

TEST(Crossed, HasNoIntervalFromTooFew) {
  const Grid grid = unevenGrid();
  EXPECT_TRUE(crossedMean(CrossedTable(firstRows(grid, 5))).interval);
  EXPECT_FALSE(crossedMean(CrossedTable(firstRows(grid, 4))).interval);
  EXPECT_FALSE(std::isnan(crossedMean(CrossedTable(firstRows(grid, 4))).value));
  EXPECT_TRUE(crossedRatio(CrossedTable(firstRows(grid, 5)), CrossedTable(firstRows(otherGrid(), 5))).interval);
  EXPECT_FALSE(crossedRatio(CrossedTable(firstRows(grid, 4)), CrossedTable(firstRows(otherGrid(), 4))).interval);
  Grid narrow = grid;
  for (std::vector<double>& row : narrow) {
    row.resize(19);
  }
  EXPECT_FALSE(crossedMean(CrossedTable(narrow)).interval);
}

TEST(CrossedRatio, HasNoneWithoutADenominator) {
  const CrossedTable values(unevenGrid());
  const CrossedTable zeros(rescaled(unevenGrid(), 0.0, 0.0));
  EXPECT_TRUE(std::isnan(crossedRatio(values, zeros).value));
  EXPECT_FALSE(crossedRatio(values, zeros).interval);
  EXPECT_EQ(crossedRatio(zeros, values).value, 0.0);
  EXPECT_FALSE(crossedRatio(zeros, values).interval);
  EXPECT_FALSE(crossedRatio(values, values).interval);  // no ratio but 1 was seen
  // One policy of six makes the denominator: its mean may be 0.
  const CrossedTable one(gridOf(6, 20, [](int r, int c) { return r == 0 && c % 2 == 0 ? 1.0 : 0.0; }));
  EXPECT_GT(crossedRatio(values, one).value, 0.0);
  EXPECT_FALSE(crossedRatio(values, one).interval);
}

/// A denominator that does not vary makes the ratio a mean.
TEST(CrossedRatio, IsAMeanOverAConstant) {
  const CrossedTable constant(rescaled(unevenGrid(), 0.0, 2.0));
  expectFigure(crossedRatio(CrossedTable(unevenGrid()), constant), 1.6933333333333336 / 2.0, 1.071344194858661 / 2.0,
               2.315322471808006 / 2.0);
}

/// Success with a planted spread between five policies: intervals over policies and starts hold the mean in about 95 %,
/// those that take all episodes for independent in far fewer.
TEST(CrossedMean, HoldsAPlantedMean) {
  std::mt19937_64 random = tableNumber(11);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  constexpr int kRuns = 600;
  int held = 0;
  int held_by_wilson = 0;
  for (int run = 0; run < kRuns; ++run) {
    Grid grid;
    int successes = 0;
    for (int row = 0; row < 5; ++row) {
      const double p = 0.5 + 0.1 * normal(random);
      grid.emplace_back();
      for (int column = 0; column < 100; ++column) {
        grid.back().push_back(uniform(random) < p ? 1.0 : 0.0);
        successes += grid.back().back() > 0.0 ? 1 : 0;
      }
    }
    const Interval interval = crossedMean(CrossedTable(grid)).interval.value();
    const Interval naive = wilsonInterval(successes, 500);
    held += interval.low <= 0.5 && 0.5 <= interval.high ? 1 : 0;
    held_by_wilson += naive.low <= 0.5 && 0.5 <= naive.high ? 1 : 0;
  }
  EXPECT_GE(held, 0.93 * kRuns);
  EXPECT_LE(held, 0.98 * kRuns);
  EXPECT_LE(held_by_wilson, 0.75 * kRuns);
}

/// Rows of one value each.
CrossedTable constantRows(const std::vector<double>& values, std::size_t columns) {
  Grid grid;
  for (const double value : values) {
    grid.emplace_back(columns, value);
  }
  return CrossedTable(grid);
}

/// Where starts make no difference, groups of policies differ as two samples do: Welch's test of the row means. The
/// numbers are SciPy 1.10's.
TEST(CrossedDifference, OfGroupsIsWelchsWithoutEffectsOfColumns) {
  const CrossedTable more = constantRows({0.5, 0.6, 0.7, 0.55, 0.62}, 30);
  const CrossedTable less = constantRows({0.4, 0.45, 0.61, 0.38, 0.5, 0.52}, 30);
  const Difference difference = crossedDifference(more, less);
  EXPECT_NEAR(difference.value, 0.11733333333333346, 1e-12);
  EXPECT_NEAR(difference.interval.value().low, 0.0077810662833519145, 1e-9);
  EXPECT_NEAR(difference.interval->high, 0.226885600383315, 1e-9);
  EXPECT_NEAR(difference.p.value(), 0.03844790886047133, 1e-9);
  const Difference reverse = crossedDifference(less, more);
  EXPECT_NEAR(reverse.interval.value().low, -difference.interval->high, 1e-12);
  EXPECT_NEAR(reverse.p.value(), *difference.p, 1e-12);
}

TEST(CrossedDifference, OfOneTableIsTheIntervalOfItsMean) {
  Grid grid;
  for (int row = 0; row < 6; ++row) {
    grid.emplace_back();
    for (int column = 0; column < 25; ++column) {
      grid.back().push_back(0.1 * row + 0.02 * ((7 * row + 3 * column) % 11) - 0.2);
    }
  }
  const CrossedTable table(grid);
  const Difference difference = crossedDifference(table);
  const Estimate mean = crossedMean(table);
  EXPECT_EQ(difference.value, mean.value);
  EXPECT_EQ(difference.interval.value().low, mean.interval.value().low);
  EXPECT_EQ(difference.interval->high, mean.interval->high);
  EXPECT_GT(difference.p.value(), 0.05) << "its interval holds 0";
  const CrossedTable shifted = table.plus(-difference.interval->low, constantRows(std::vector<double>(6, 1.0), 25));
  EXPECT_NEAR(crossedDifference(shifted).p.value(), 0.05, 1e-9) << "its interval ends at 0";
}

/// Starts that one simulator's policies find harder: they are drawn, too, so they count.
TEST(CrossedDifference, CountsStartsThatDivideTheGroups) {
  Grid flat(5, std::vector<double>(40, 0.5));
  Grid divided = flat;
  for (std::size_t row = 0; row < flat.size(); ++row) {
    for (std::size_t column = 0; column < 40; ++column) {
      flat[row][column] += 0.01 * static_cast<double>(row);
      divided[row][column] += 0.01 * static_cast<double>(row) + (column % 2 == 0 ? 0.2 : -0.2);
    }
  }
  const CrossedTable base(flat);
  const Difference alike = crossedDifference(base, base);
  const Difference apart = crossedDifference(CrossedTable(divided), base);
  EXPECT_NEAR(apart.value, alike.value, 1e-12);
  // t of 8 degrees of freedom times 0.01; t of 44.9 times sqrt(1e-4 + 0.04 / 39), by SciPy 1.10.
  EXPECT_NEAR(alike.interval.value().high, 0.023060041350333706, 1e-9);
  EXPECT_NEAR(apart.interval.value().high, 0.06757868027509065, 1e-9);
}

TEST(CrossedDifference, HasNoIntervalOfFewPoliciesOrWithoutSpread) {
  const CrossedTable many = constantRows({0.5, 0.6, 0.7, 0.55, 0.62}, 30);
  EXPECT_FALSE(crossedDifference(many, constantRows({0.1, 0.2, 0.3, 0.4}, 30)).interval.has_value());
  EXPECT_FALSE(crossedDifference(constantRows({0.1, 0.2, 0.3, 0.4, 0.5}, 19)).p.has_value());
  EXPECT_FALSE(crossedDifference(constantRows({0.1, 0.1, 0.1, 0.1, 0.1}, 30)).interval.has_value());
  EXPECT_EQ(crossedDifference(many, constantRows({0.1, 0.2}, 30)).value,
            many.mean() - constantRows({0.1, 0.2}, 30).mean());
  expectRefused(
      [&] {
        crossedDifference(many, constantRows({0.1, 0.2}, 29));
      },
      "number of columns 29: must be that of the first table, 30");
}

TEST(Crossed, RefusesWhatIsNoTable) {
  expectRefused([] { CrossedTable({}); }, "number of rows 0: must be at least 1");
  expectRefused([] { CrossedTable({{}, {}}); }, "number of columns 0: must be at least 1");
  expectRefused([] { CrossedTable({{1.0, 2.0}, {1.0}}); }, "length of a row 1: must be that of the first row, 2");
  expectRefused(
      [] {
        CrossedTable({{1.0, std::numeric_limits<double>::infinity()}});
      },
      "value inf: must be a finite number");
  expectRefused([] { CrossedTable(Grid{{std::nan("")}}); }, "value nan: must be a finite number");
  const CrossedTable row({{1.0, 2.0}});
  const CrossedTable column({{1.0}, {2.0}});
  expectRefused([&] { meanSquares(row); }, "number of rows 1: must be at least 2");
  expectRefused([&] { varianceComponents(column); }, "number of columns 1: must be at least 2");
  expectRefused([&] { static_cast<void>(row.plus(1.0, column)); },
                "number of rows 2: must be that of the first table, 1");
  expectRefused([&] { crossedRatio(row, CrossedTable(Grid{{1.0}})); },
                "number of columns 1: must be that of the first table, 2");
  expectRefused(
      [&] {
        crossedRatio(row, CrossedTable({{1.0, -0.5}}));
      },
      "value -0.5: must be at least 0 in a ratio of means");
}

}  // namespace
}  // namespace sim2sim
