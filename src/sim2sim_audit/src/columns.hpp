// SPDX-License-Identifier: BSD-3-Clause
/// Rows of numbers by their columns: normalizations as trainings make them, and other layouts.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace sim2sim {

/// Lines by which columns are normalized: (value - origin) / unit.
template <std::size_t kColumns>
struct Normalization {
  using Row = std::array<float, kColumns>;
  std::array<double, kColumns> origin{};
  std::array<double, kColumns> unit{};

  Row normalized(const Row& row) const {
    return mapped(row, [this](double value, std::size_t i) { return (value - origin[i]) / unit[i]; });
  }
  Row inSiUnits(const Row& row) const {
    return mapped(row, [this](double value, std::size_t i) { return value * unit[i] + origin[i]; });
  }

 private:
  template <class Map>
  static Row mapped(Row row, const Map& map) {
    for (std::size_t i = 0; i < kColumns; ++i) {
      row[i] = static_cast<float>(map(row[i], i));
    }
    return row;
  }
};

/// Means, deviations and bounds of columns.
template <std::size_t kColumns>
class Columns {
 public:
  using Row = std::array<float, kColumns>;

  void add(const Row& row) {
    ++rows_;
    for (std::size_t i = 0; i < kColumns; ++i) {
      const double value = row[i];
      least_[i] = std::min(least_[i], value);
      greatest_[i] = std::max(greatest_[i], value);
      sum_[i] += value;
      squares_[i] += value * value;
    }
  }

  /// [least, greatest] to [-1, 1]
  Normalization<kColumns> toSignedUnit() const {
    return made([this](std::size_t i) { return (least_[i] + greatest_[i]) / 2.0; },
                [this](std::size_t i) { return (greatest_[i] - least_[i]) / 2.0; }, 0.5);
  }
  /// [least, greatest] to [0, 1]
  Normalization<kColumns> toUnit() const {
    return made([this](std::size_t i) { return least_[i]; }, [this](std::size_t i) { return greatest_[i] - least_[i]; },
                1.0);
  }
  /// Mean to 0, deviation to 1
  Normalization<kColumns> toStandard() const {
    return made([this](std::size_t i) { return mean(i); },
                [this](std::size_t i) { return std::sqrt(std::max(0.0, squares_[i] / rows_ - mean(i) * mean(i))); },
                1.0);
  }

 private:
  double mean(std::size_t i) const { return sum_[i] / rows_; }

  /// A column that does not change has the unit `constant`, as trainings do it (pusht_policy/model.py); the least of
  /// its range becomes what the least of others becomes.
  template <class Origin, class Unit>
  Normalization<kColumns> made(const Origin& origin, const Unit& unit, double constant) const {
    constexpr double kSmallest = 1e-4;
    Normalization<kColumns> result;
    for (std::size_t i = 0; i < kColumns; ++i) {
      const bool changes = greatest_[i] - least_[i] >= kSmallest;
      result.unit[i] = changes ? unit(i) : constant;
      result.origin[i] = changes ? origin(i) : origin(i) + (1.0 - constant);
    }
    return result;
  }

  static std::array<double, kColumns> filled(double value) {
    std::array<double, kColumns> row;
    row.fill(value);
    return row;
  }

  std::array<double, kColumns> least_ = filled(std::numeric_limits<double>::infinity());
  std::array<double, kColumns> greatest_ = filled(-std::numeric_limits<double>::infinity());
  std::array<double, kColumns> sum_{};
  std::array<double, kColumns> squares_{};
  double rows_ = 0.0;
};

/// Place of number `flat` of `rows` rows that are written number by number.
template <std::size_t kColumns>
float& byColumns(std::vector<std::array<float, kColumns>>& rows, std::size_t flat) {
  return rows[flat % rows.size()][flat / rows.size()];
}

/// Rows whose numbers are those of `rows`, number by number.
template <std::size_t kColumns>
std::vector<std::array<float, kColumns>> transposed(std::vector<std::array<float, kColumns>> rows) {
  std::vector<std::array<float, kColumns>> result = rows;
  for (std::size_t flat = 0; flat < rows.size() * kColumns; ++flat) {
    result[flat / kColumns][flat % kColumns] = byColumns(rows, flat);
  }
  return result;
}

/// Inverse of transposed().
template <std::size_t kColumns>
std::vector<std::array<float, kColumns>> untransposed(const std::vector<std::array<float, kColumns>>& rows) {
  std::vector<std::array<float, kColumns>> result = rows;
  for (std::size_t flat = 0; flat < rows.size() * kColumns; ++flat) {
    byColumns(result, flat) = rows[flat / kColumns][flat % kColumns];
  }
  return result;
}

}  // namespace sim2sim
