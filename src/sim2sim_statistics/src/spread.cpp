// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/spread.hpp"

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string>

#include "sim2sim_statistics/common.hpp"

namespace sim2sim {
namespace {

/// Values by policy and simulator.
using Cells = std::vector<std::vector<double>>;

std::vector<double> columnMeansOf(const Cells& cells) {
  std::vector<double> means(cells.front().size(), 0.0);
  for (const std::vector<double>& row : cells) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      means[i] += row[i] / static_cast<double>(cells.size());
    }
  }
  return means;
}

/// Mean squares of the sources, in the order of Spread.
struct SourceSquares {
  double group = 0.0;
  double simulator = 0.0;
  double group_simulator = 0.0;
  double policy = 0.0;
  double policy_simulator = 0.0;

  void add(double weight, const SourceSquares& other) {
    group += weight * other.group;
    simulator += weight * other.simulator;
    group_simulator += weight * other.group_simulator;
    policy += weight * other.policy;
    policy_simulator += weight * other.policy_simulator;
  }
};

/// Analysis of variance of one table of cells.
class Analysis {
 public:
  Analysis(const std::vector<std::size_t>& groups, std::size_t simulator_count)
      : groups_(groups),
        sizes_(groups.empty() ? 0 : *std::max_element(groups.begin(), groups.end()) + 1),
        simulator_count_(static_cast<double>(simulator_count)) {
    for (const std::size_t group : groups) {
      ++sizes_[group];
    }
  }

  double groupCount() const { return static_cast<double>(sizes_.size()); }
  double simulatorCount() const { return simulator_count_; }
  bool isWithoutGap() const { return std::find(sizes_.begin(), sizes_.end(), 0) == sizes_.end(); }
  double policiesWithinGroups() const { return static_cast<double>(groups_.size() - sizes_.size()); }

  /// Part of the variance between policies that is in the mean of a group, averaged over the groups.
  double partInGroupMean() const {
    return std::accumulate(sizes_.begin(), sizes_.end(), 0.0,
                           [](double sum, std::size_t size) { return sum + 1.0 / static_cast<double>(size); }) /
           groupCount();
  }

  SourceSquares meanSquares(const Cells& cells) const {
    Cells group_means(sizes_.size(), std::vector<double>(cells.front().size(), 0.0));
    for (std::size_t policy = 0; policy < cells.size(); ++policy) {
      for (std::size_t i = 0; i < cells[policy].size(); ++i) {
        group_means[groups_[policy]][i] += cells[policy][i] / static_cast<double>(sizes_[groups_[policy]]);
      }
    }
    SourceSquares squares = squaresBetween(group_means);
    for (std::size_t policy = 0; policy < cells.size(); ++policy) {
      std::vector<double> beyond_group = cells[policy];
      std::transform(beyond_group.begin(), beyond_group.end(), group_means[groups_[policy]].begin(),
                     beyond_group.begin(), std::minus<>());
      const double own = averageOf(beyond_group);
      squares.policy += simulator_count_ * own * own / policiesWithinGroups();
      for (const double value : beyond_group) {
        squares.policy_simulator += (value - own) * (value - own) / (policiesWithinGroups() * (simulator_count_ - 1.0));
      }
    }
    return squares;
  }

 private:
  SourceSquares squaresBetween(const Cells& group_means) const {
    SourceSquares squares;
    const std::vector<double> of_simulators = columnMeansOf(group_means);
    const double grand = averageOf(of_simulators);
    for (const double mean : of_simulators) {
      squares.simulator += groupCount() * (mean - grand) * (mean - grand) / (simulator_count_ - 1.0);
    }
    for (const std::vector<double>& row : group_means) {
      const double of_group = averageOf(row);
      squares.group += simulator_count_ * (of_group - grand) * (of_group - grand) / (groupCount() - 1.0);
      for (std::size_t i = 0; i < row.size(); ++i) {
        const double beyond = row[i] - of_group - of_simulators[i] + grand;
        squares.group_simulator += beyond * beyond / ((groupCount() - 1.0) * (simulator_count_ - 1.0));
      }
    }
    return squares;
  }

  const std::vector<std::size_t>& groups_;
  std::vector<std::size_t> sizes_;
  double simulator_count_;
};

Cells cellsAt(const std::vector<CrossedTable>& simulators, std::size_t start, const Cells& means) {
  Cells cells = means;
  for (std::size_t policy = 0; policy < cells.size(); ++policy) {
    for (std::size_t i = 0; i < simulators.size(); ++i) {
      cells[policy][i] = simulators[i].at(policy, start) - means[policy][i];
    }
  }
  return cells;
}

void requireShape(const std::vector<CrossedTable>& simulators, const std::vector<std::size_t>& groups) {
  const auto require = [](bool holds, const std::string& what, std::size_t count, const std::string& rule) {
    if (!holds) {
      throw std::domain_error(what + " " + std::to_string(count) + ": must be " + rule);
    }
  };
  require(simulators.size() >= 2, "number of simulators", simulators.size(), "at least 2");
  const CrossedTable& first = simulators.front();
  require(first.columns() >= 2, "number of starts", first.columns(), "at least 2");
  for (const CrossedTable& table : simulators) {
    require(table.rows() == groups.size(), "number of policies", table.rows(), "that of the groups' list");
    require(table.columns() == first.columns(), "number of starts", table.columns(), "the same in all simulators");
  }
}

}  // namespace

Spread spreadOf(const std::vector<CrossedTable>& simulators, const std::vector<std::size_t>& groups) {
  requireShape(simulators, groups);
  const Analysis analysis(groups, simulators.size());
  if (analysis.groupCount() < 2.0 || !analysis.isWithoutGap() || analysis.policiesWithinGroups() < 1.0) {
    throw std::domain_error("groups: must be at least 2, numbered from 0 on, and one of them have 2 policies");
  }
  Cells means(groups.size(), std::vector<double>(simulators.size()));
  for (std::size_t i = 0; i < simulators.size(); ++i) {
    const std::vector<double> of_rows = simulators[i].rowMeans();
    for (std::size_t policy = 0; policy < groups.size(); ++policy) {
      means[policy][i] = of_rows[policy];
    }
  }
  SourceSquares squares = analysis.meanSquares(means);

  // What the starts add to each mean square, and to a cell: the same sums over the deviations of single starts.
  const std::size_t starts = simulators.front().columns();
  const double weight = 1.0 / (static_cast<double>(starts) * static_cast<double>(starts - 1));
  Spread spread{};
  for (std::size_t start = 0; start < starts; ++start) {
    const Cells deviations = cellsAt(simulators, start, means);
    squares.add(-weight, analysis.meanSquares(deviations));
    for (const std::vector<double>& row : deviations) {
      spread.starts += weight * std::inner_product(row.begin(), row.end(), row.begin(), 0.0) /
                       static_cast<double>(groups.size() * simulators.size());
    }
  }
  const double group_count = analysis.groupCount();
  const double simulator_count = analysis.simulatorCount();
  const double part = analysis.partInGroupMean();
  const auto solved = [](double square, double factor) { return std::max(square * factor, 0.0); };
  spread.policy = solved(squares.policy, 1.0 / simulator_count);
  spread.policy_simulator = solved(squares.policy_simulator, (simulator_count - 1.0) / simulator_count);
  spread.group = solved(squares.group - part * squares.policy, (group_count - 1.0) / (group_count * simulator_count));
  spread.simulator = solved(squares.simulator - part * squares.policy_simulator,
                            (simulator_count - 1.0) / (simulator_count * group_count));
  spread.group_simulator = solved(squares.group_simulator - part * squares.policy_simulator,
                                  (group_count - 1.0) * (simulator_count - 1.0) / (group_count * simulator_count));
  return spread;
}

}  // namespace sim2sim
