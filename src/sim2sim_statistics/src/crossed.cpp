// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/crossed.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "sim2sim_statistics/common.hpp"

namespace sim2sim {
namespace {

void requireNonNegative(const CrossedTable& table) {
  for (std::size_t row = 0; row < table.rows(); ++row) {
    for (std::size_t column = 0; column < table.columns(); ++column) {
      if (table.at(row, column) < 0.0) {
        refuse("value", table.at(row, column), "at least 0 in a ratio of means");
      }
    }
  }
}

void requireSameShape(const CrossedTable& table, const CrossedTable& first) {
  if (table.rows() != first.rows()) {
    refuse("number of rows", table.rows(), "that of the first table, " + std::to_string(first.rows()));
  }
  if (table.columns() != first.columns()) {
    refuse("number of columns", table.columns(), "that of the first table, " + std::to_string(first.columns()));
  }
}

double squaredDeviations(const std::vector<double>& values, double mean) {
  double sum = 0.0;
  for (const double value : values) {
    sum += (value - mean) * (value - mean);
  }
  return sum;
}

/// Estimated error of a table's mean.
struct MeanError {
  double standard_error;
  double degrees_of_freedom;

  double halfWidth() const {
    const boost::math::students_t t(degrees_of_freedom);
    return quantile(t, 0.5 * (1.0 + kConfidence)) * standard_error;
  }

  /// Two-sided p-value of the hypothesis that the mean is 0.
  double p(double mean) const {
    const boost::math::students_t t(degrees_of_freedom);
    return 2.0 * cdf(complement(t, std::abs(mean) / standard_error));
  }
};

Difference differenceOf(double mean, const std::optional<MeanError>& error) {
  if (!error) {
    return {mean, std::nullopt, std::nullopt};
  }
  const double half_width = error->halfWidth();
  return {mean, Interval{mean - half_width, mean + half_width}, error->p(mean)};
}

/// Sum of independent mean squares with weights, and its degrees of freedom after Satterthwaite.
class WeightedSquares {
 public:
  void add(double weight, double square, double degrees_of_freedom) {
    const double part = weight * square;
    sum_ += part;
    spread_ += part * part / degrees_of_freedom;
  }

  void add(const WeightedSquares& other) {
    sum_ += other.sum_;
    spread_ += other.spread_;
  }

  double sum() const { return sum_; }
  double degreesOfFreedom() const { return sum_ * sum_ / spread_; }

 private:
  double sum_ = 0.0;
  double spread_ = 0.0;
};

/// Error of the difference of the means of two tables over the same columns; none if there is no spread.
std::optional<MeanError> errorOfGroups(const CrossedTable& more, const CrossedTable& less) {
  WeightedSquares rows;
  WeightedSquares residuals;  // they are in the differences of the columns once more
  double fewest = std::numeric_limits<double>::infinity();
  const auto columns = static_cast<double>(more.columns());
  for (const CrossedTable* table : {&more, &less}) {
    const MeanSquares squares = meanSquares(*table);
    const auto number = static_cast<double>(table->rows());
    rows.add(1.0 / (number * columns), squares.rows, number - 1.0);
    residuals.add(-1.0 / (number * columns), squares.residual, (number - 1.0) * (columns - 1.0));
    fewest = std::min(fewest, number - 1.0);
  }
  std::vector<double> differences = more.columnMeans();
  const std::vector<double> less_means = less.columnMeans();
  for (std::size_t i = 0; i < differences.size(); ++i) {
    differences[i] -= less_means[i];
  }
  const double mean = averageOf(differences);
  const double of_columns = squaredDeviations(differences, mean) / (columns - 1.0);
  WeightedSquares all = rows;
  if (of_columns / columns + residuals.sum() > 0.0) {
    all.add(1.0 / columns, of_columns, columns - 1.0);
    all.add(residuals);
  }
  const double standard_error = std::sqrt(std::max(0.0, all.sum()));
  if (standard_error <= kSame) {
    return std::nullopt;
  }
  return MeanError{standard_error, std::max(fewest, all.degreesOfFreedom())};
}

/// Error of the mean of a table with these mean squares; none if there is no spread.
std::optional<MeanError> errorOf(const MeanSquares& squares, std::size_t number_of_rows,
                                 std::size_t number_of_columns) {
  const auto rows = static_cast<double>(number_of_rows);
  const auto columns = static_cast<double>(number_of_columns);
  const bool columns_count = squares.columns > squares.residual;
  double sum = squares.rows;
  double spread = squares.rows * squares.rows / (rows - 1.0);  // half the variance of the sum
  if (columns_count) {
    sum += squares.columns - squares.residual;
    spread += squares.columns * squares.columns / (columns - 1.0) +
              squares.residual * squares.residual / ((rows - 1.0) * (columns - 1.0));
  }
  const double standard_error = std::sqrt(std::max(0.0, sum) / (rows * columns));
  if (standard_error <= kSame) {
    return std::nullopt;
  }
  return MeanError{standard_error, std::max(rows - 1.0, sum * sum / spread)};
}

bool isTooSmall(const CrossedTable& table) { return table.rows() < kFewestRows || table.columns() < kFewestColumns; }

/// Error of the mean of numerators - ratio * denominators, for any ratio.
class DifferenceError {
 public:
  DifferenceError(const CrossedTable& numerators, const CrossedTable& denominators)
      : rows_(numerators.rows()),
        columns_(numerators.columns()),
        numerators_(meanSquares(numerators)),
        denominators_(meanSquares(denominators)),
        sums_(meanSquares(numerators.plus(1.0, denominators))) {}

  std::optional<MeanError> at(double ratio) const { return errorOf(of(1.0, -ratio), rows_, columns_); }
  std::optional<MeanError> ofDenominators() const { return errorOf(denominators_, rows_, columns_); }

 private:
  /// Mean squares of a * numerators + b * denominators.
  MeanSquares of(double a, double b) const {
    const auto combined = [&](double MeanSquares::*part) {
      const double products = 0.5 * (sums_.*part - numerators_.*part - denominators_.*part);
      return std::max(0.0, a * a * numerators_.*part + 2.0 * a * b * products + b * b * denominators_.*part);
    };
    return {combined(&MeanSquares::rows), combined(&MeanSquares::columns), combined(&MeanSquares::residual)};
  }

  std::size_t rows_;
  std::size_t columns_;
  MeanSquares numerators_;
  MeanSquares denominators_;
  MeanSquares sums_;  ///< of the table numerators + denominators
};

}  // namespace

CrossedTable::CrossedTable(const std::vector<std::vector<double>>& rows)
    : rows_(rows.size()), columns_(rows.empty() ? 0 : rows.front().size()) {
  if (rows_ == 0) {
    refuse("number of rows", rows_, "at least 1");
  }
  if (columns_ == 0) {
    refuse("number of columns", columns_, "at least 1");
  }
  values_.reserve(rows_ * columns_);
  for (const std::vector<double>& row : rows) {
    if (row.size() != columns_) {
      refuse("length of a row", row.size(), "that of the first row, " + std::to_string(columns_));
    }
    for (const double value : row) {
      if (!std::isfinite(value)) {
        refuse("value", value, "a finite number");
      }
      values_.push_back(value);
    }
  }
}

double CrossedTable::mean() const { return averageOf(values_); }

std::vector<double> CrossedTable::rowMeans() const {
  std::vector<double> means(rows_);
  auto value = values_.begin();
  for (double& mean : means) {
    const auto next = value + static_cast<std::ptrdiff_t>(columns_);
    mean = std::accumulate(value, next, 0.0) / static_cast<double>(columns_);
    value = next;
  }
  return means;
}

std::vector<double> CrossedTable::columnMeans() const {
  std::vector<double> means(columns_, 0.0);
  for (std::size_t i = 0; i < values_.size(); ++i) {
    means[i % columns_] += values_[i] / static_cast<double>(rows_);
  }
  return means;
}

CrossedTable CrossedTable::plus(double weight, const CrossedTable& other) const {
  requireSameShape(other, *this);
  CrossedTable sum = *this;
  for (std::size_t i = 0; i < values_.size(); ++i) {
    sum.values_[i] += weight * other.values_[i];
  }
  return sum;
}

MeanSquares meanSquares(const CrossedTable& table) {
  if (table.rows() < 2) {
    refuse("number of rows", table.rows(), "at least 2");
  }
  if (table.columns() < 2) {
    refuse("number of columns", table.columns(), "at least 2");
  }
  const double mean = table.mean();
  const std::vector<double> row_means = table.rowMeans();
  const std::vector<double> column_means = table.columnMeans();
  double residual = 0.0;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    for (std::size_t column = 0; column < table.columns(); ++column) {
      const double rest = table.at(row, column) - row_means[row] - column_means[column] + mean;
      residual += rest * rest;
    }
  }
  const auto rows = static_cast<double>(table.rows());
  const auto columns = static_cast<double>(table.columns());
  return {columns * squaredDeviations(row_means, mean) / (rows - 1.0),
          rows * squaredDeviations(column_means, mean) / (columns - 1.0), residual / ((rows - 1.0) * (columns - 1.0))};
}

VarianceComponents varianceComponents(const CrossedTable& table) {
  const MeanSquares squares = meanSquares(table);
  return {std::max(0.0, squares.rows - squares.residual) / static_cast<double>(table.columns()),
          std::max(0.0, squares.columns - squares.residual) / static_cast<double>(table.rows()), squares.residual};
}

Estimate crossedMean(const CrossedTable& table, const Interval& limits) {
  const double mean = table.mean();
  if (isTooSmall(table)) {
    return {mean, std::nullopt};
  }
  const std::optional<MeanError> error = errorOf(meanSquares(table), table.rows(), table.columns());
  if (!error) {
    return {mean, std::nullopt};
  }
  const double half_width = error->halfWidth();
  return {mean, Interval{std::max(mean - half_width, limits.low), std::min(mean + half_width, limits.high)}};
}

Estimate crossedRatio(const CrossedTable& numerators, const CrossedTable& denominators) {
  requireNonNegative(numerators);
  requireNonNegative(denominators);
  requireSameShape(denominators, numerators);
  const double numerator = numerators.mean();
  const double denominator = denominators.mean();
  if (denominator == 0.0) {
    return {};
  }
  const double ratio = numerator / denominator;
  if (numerator == 0.0 || isTooSmall(numerators)) {
    return {ratio, std::nullopt};
  }
  const DifferenceError error(numerators, denominators);
  const bool varies = errorOf(meanSquares(numerators.plus(-ratio, denominators)), numerators.rows(),
                              numerators.columns())
                          .has_value();  // without the rounding of sums of squares
  const std::optional<MeanError> of_denominators = error.ofDenominators();
  if (!varies || (of_denominators && of_denominators->halfWidth() >= denominator)) {
    return {ratio, std::nullopt};
  }
  const auto is_likely = [&](double r) {
    const std::optional<MeanError> of_difference = error.at(r);
    return of_difference && std::abs(numerator - r * denominator) <= of_difference->halfWidth();
  };
  double outside = 2.0 * ratio;
  while (is_likely(outside)) {
    outside *= 2.0;
  }
  return {ratio, Interval{edge(is_likely, ratio, 0.0), edge(is_likely, ratio, outside)}};
}

Difference crossedDifference(const CrossedTable& differences) {
  const double mean = differences.mean();
  return differenceOf(mean, isTooSmall(differences)
                                ? std::nullopt
                                : errorOf(meanSquares(differences), differences.rows(), differences.columns()));
}

Difference crossedDifference(const CrossedTable& more, const CrossedTable& less) {
  if (less.columns() != more.columns()) {
    refuse("number of columns", less.columns(), "that of the first table, " + std::to_string(more.columns()));
  }
  const double mean = more.mean() - less.mean();
  return differenceOf(mean, isTooSmall(more) || isTooSmall(less) ? std::nullopt : errorOfGroups(more, less));
}

}  // namespace sim2sim
