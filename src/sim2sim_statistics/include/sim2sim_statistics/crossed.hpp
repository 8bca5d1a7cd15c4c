// SPDX-License-Identifier: BSD-3-Clause
/// Means and ratios over a crossed two-way design: policies trained with different seeds (rows) play episodes from the
/// same initial states (columns), and both are samples. The intervals are about a new training and a new initial state,
/// not about these rows or these columns alone.
///
/// Model: y(r, c) = mean + row(r) + column(c) + rest(r, c), three independent effects of mean 0. The variance of the
/// table's mean is estimated from the mean squares, (rows + columns - residual) / (R C), at least rows / (R C); its
/// degrees of freedom are Satterthwaite's. With few rows the rows dominate, and Student's t has about R - 1 degrees.
/// Sources: S. R. Searle, G. Casella and C. E. McCulloch, "Variance Components" (1992), chapter 4; F. E. Satterthwaite,
/// "An Approximate Distribution of Estimates of Variance Components" (Biometrics Bulletin, 1946).
///
/// The measured coverage is in docs/statistics.md. Functions throw std::domain_error, with value and rule, for input
/// out of range.
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "sim2sim_statistics/intervals.hpp"

namespace sim2sim {

/// Fewest rows for an interval. With 5 rows the intervals cover the truth in 94 to 97 % of simulated runs (nominal:
/// 95 %) if the effects of the rows are normal, in 90 % if they are exponential. Fewer were not simulated.
constexpr std::size_t kFewestRows = 5;

/// Fewest columns for an interval. Fewer were not simulated.
constexpr std::size_t kFewestColumns = 20;

/// Values of a crossed design, in any unit.
class CrossedTable {
 public:
  /// Table of at least one row and one column. Rows must have the same length, values must be finite.
  explicit CrossedTable(const std::vector<std::vector<double>>& rows);

  std::size_t rows() const { return rows_; }
  std::size_t columns() const { return columns_; }
  double at(std::size_t row, std::size_t column) const { return values_.at(row * columns_ + column); }
  double mean() const;                      ///< of all values
  std::vector<double> rowMeans() const;     ///< by row, over its columns
  std::vector<double> columnMeans() const;  ///< by column, over its rows

  /// This table + `weight` * `other`, value by value. With a weight of -1 its mean is that of the paired differences.
  CrossedTable plus(double weight, const CrossedTable& other) const;

 private:
  std::size_t rows_;
  std::size_t columns_;
  std::vector<double> values_;  ///< row by row
};

/// Mean squares of the analysis of variance, in the square of the table's unit.
struct MeanSquares {
  double rows;      ///< R - 1 degrees of freedom
  double columns;   ///< C - 1
  double residual;  ///< (R - 1)(C - 1)
};

/// Mean squares of a table with at least 2 rows and 2 columns.
MeanSquares meanSquares(const CrossedTable& table);

/// Variances of the three effects, in the square of the table's unit. One whose estimate is negative is 0.
struct VarianceComponents {
  double row;     ///< between policies, over all initial states
  double column;  ///< between initial states, over all policies
  double rest;    ///< interaction of the two, and chance
};

/// Variance components of a table with at least 2 rows and 2 columns, by the analysis of variance.
VarianceComponents varianceComponents(const CrossedTable& table);

/// Mean of a table, with its interval by Student's t, cut off at `limits`. No interval below kFewestRows or
/// kFewestColumns, and none if the estimated standard error is at most kSame, for then nothing varies.
Estimate crossedMean(const CrossedTable& table, const Interval& limits = {-std::numeric_limits<double>::infinity(),
                                                                          std::numeric_limits<double>::infinity()});

/// Ratio of the means of two tables of quantities that are never negative, over the same rows and columns: the success
/// in one simulator over that in another. NaN if the mean of the denominators is 0.
///
/// The interval holds every ratio that the interval of the mean of numerators - ratio * denominators does not rule out.
/// None where crossedMean() has none of that mean, if a mean is 0, and if the denominators' own interval holds 0: then
/// no ratio is too large.
/// Source: E. C. Fieller, "Some Problems in Interval Estimation" (JRSS B, 1954).
Estimate crossedRatio(const CrossedTable& numerators, const CrossedTable& denominators);

/// Mean of a table against 0, with Student's t as crossedMean() has it. For policies of two kinds that belong together
/// row by row, such as two epochs of the same trainings, the table is that of the differences (CrossedTable::plus()).
Difference crossedDifference(const CrossedTable& differences);

/// Difference of the means of two tables over the same columns, more - less: two groups of policies that were trained
/// independently of each other, such as two recipes, from the same initial states. The rows may differ in number.
///
/// The variance is that of the rows of each table, rows / (R C), and that of the differences of the column means
/// beyond the residuals, at least 0; its degrees of freedom are Satterthwaite's, at least those of the smaller group.
/// No interval and no p where crossedMean() has none of one of the tables.
Difference crossedDifference(const CrossedTable& more, const CrossedTable& less);

}  // namespace sim2sim
