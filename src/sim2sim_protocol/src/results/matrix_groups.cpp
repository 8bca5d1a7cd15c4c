// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "group_tables.hpp"
#include "sim2sim_protocol/results/matrix.hpp"
#include "sim2sim_statistics/crossed.hpp"

namespace sim2sim {
namespace {

constexpr double kNoSpread = std::numeric_limits<double>::quiet_NaN();
constexpr Interval kRates{0.0, 1.0};

/// Mean divergence of a group, with an interval where the method is made for it.
Estimate meanDivergence(const CrossedTable& table) {
  Estimate mean = crossedMean(table, {0.0, std::numeric_limits<double>::infinity()});
  if (isCarriedByFewStarts(table)) {
    mean.interval.reset();
  }
  return mean;
}

/// Cell of a group of one policy: over starts alone.
GroupCell cellOfOne(const MatrixCell& cell, bool is_away) {
  GroupCell one{1, {cell.success.rate, cell.success.interval}, {}, kNoSpread};
  if (is_away) {
    one.transfer = {cell.transfer.value_or(kNoSpread), cell.transfer_interval};
    one.divergences = cell.mean_divergences;
  }
  return one;
}

std::optional<GroupCell> groupCell(const Matrix& matrix, const std::vector<std::size_t>& members,
                                   std::size_t simulator) {
  if (members.size() == 1) {
    const std::optional<MatrixCell>& only = matrix.cells[members.front()][simulator];
    return only ? std::optional(cellOfOne(*only, matrix.policies[members.front()].reference != simulator))
                : std::nullopt;
  }
  Rows successes;
  Rows in_reference;
  const std::size_t first_reference = matrix.policies[members.front()].reference;
  std::array<Rows, kMatrixDivergences.size()> divergences;
  bool is_away = true;
  for (const std::size_t policy : members) {
    const std::optional<MatrixCell>& cell = matrix.cells[policy][simulator];
    if (!cell) {
      continue;
    }
    const std::size_t reference = matrix.policies[policy].reference;
    is_away = is_away && reference != simulator && reference == first_reference;
    successes.push_back(numbersOf(cell->successes));
    in_reference.push_back(numbersOf(matrix.cells[policy][reference]->successes));
    for (std::size_t i = 0; i < kMatrixDivergences.size(); ++i) {
      divergences[i].push_back(cell->divergences[i]);
    }
  }
  if (successes.empty()) {
    return std::nullopt;
  }
  const CrossedTable table(successes);
  GroupCell cell{successes.size(), crossedMean(table, kRates), {}, kNoSpread};
  if (table.rows() > 1 && table.columns() > 1) {
    cell.between_policies = std::sqrt(varianceComponents(table).row);
  }
  if (is_away) {
    cell.transfer = crossedRatio(table, CrossedTable(in_reference));
    for (std::size_t i = 0; i < kMatrixDivergences.size(); ++i) {
      if (const Rows dense = withoutGaps(divergences[i]); !dense.front().empty()) {
        cell.divergences[i] = meanDivergence(CrossedTable(dense));
      }
    }
  }
  return cell;
}

}  // namespace

std::vector<MatrixGroup> groupsOf(const Matrix& matrix) {
  std::vector<MatrixGroup> groups;
  for (std::size_t policy = 0; policy < matrix.policies.size(); ++policy) {
    const std::string& name = matrix.policies[policy].group;
    if (name.empty()) {
      continue;
    }
    auto group =
        std::find_if(groups.begin(), groups.end(), [&](const MatrixGroup& other) { return other.name == name; });
    if (group == groups.end()) {
      group = groups.insert(group, {name, {}, {}});
    }
    group->policies.push_back(policy);
  }
  for (MatrixGroup& group : groups) {
    for (std::size_t simulator = 0; simulator < matrix.simulators.size(); ++simulator) {
      group.cells.push_back(groupCell(matrix, group.policies, simulator));
    }
  }
  return groups;
}

}  // namespace sim2sim
