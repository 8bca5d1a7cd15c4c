// SPDX-License-Identifier: BSD-3-Clause
/// Tables of policies by starts from the cells of a matrix. Private to its calculations.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "sim2sim_protocol/results/matrix.hpp"
#include "sim2sim_statistics/crossed.hpp"
#include "sim2sim_statistics/tails.hpp"

namespace sim2sim {

/// Values of policies (rows) by start (columns).
using Rows = std::vector<std::vector<double>>;

inline std::vector<double> numbersOf(const std::vector<bool>& successes) {
  return {successes.begin(), successes.end()};
}

/// Rows without the columns that are NaN in one of them. There must be a row.
inline Rows withoutGaps(const Rows& rows) {
  Rows dense(rows.size());
  for (std::size_t column = 0; column < rows.front().size(); ++column) {
    if (std::none_of(rows.begin(), rows.end(), [&](const auto& row) { return std::isnan(row[column]); })) {
      for (std::size_t i = 0; i < rows.size(); ++i) {
        dense[i].push_back(rows[i][column]);
      }
    }
  }
  return dense;
}

/// Whether few starts carry the mean divergence of a group: Student's interval is not made for that.
inline bool isCarriedByFewStarts(const CrossedTable& divergences) {
  return isCarriedByFew(divergences.columnMeans(), 0.0);
}

/// Groups of a matrix that has its policies and cells, in the order of their first policies.
std::vector<MatrixGroup> groupsOf(const Matrix& matrix);

}  // namespace sim2sim
