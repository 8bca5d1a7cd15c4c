// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/hypotheses.hpp"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <set>
#include <utility>

#include "group_tables.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/joined.hpp"
#include "sim2sim_statistics/crossed.hpp"
#include "sim2sim_statistics/pairs.hpp"
#include "sim2sim_statistics/ranking.hpp"

namespace sim2sim {
namespace {

/// Refuses a part of a hypothesis: by its name, value and rule.
[[noreturn]] void refuse(const std::string& what, const std::string& value, const std::string& rule) {
  throw pusht::InvalidInput(what + " " + value + ": " + rule);
}

std::size_t simulatorNamed(const Matrix& matrix, const std::string& name) {
  std::vector<std::string> names;
  for (const MatrixSimulator& simulator : matrix.simulators) {
    names.push_back(simulator.name);
  }
  const auto place = std::find(names.begin(), names.end(), name);
  if (place == names.end()) {
    refuse("simulator", name, "must be one of " + pusht::joined(names));
  }
  return static_cast<std::size_t>(place - names.begin());
}

const MatrixGroup& groupNamed(const Matrix& matrix, const std::string& name) {
  const auto found = std::find_if(matrix.groups.begin(), matrix.groups.end(),
                                  [&](const MatrixGroup& group) { return group.name == name; });
  if (found == matrix.groups.end()) {
    std::vector<std::string> names;
    std::transform(matrix.groups.begin(), matrix.groups.end(), std::back_inserter(names),
                   [](const MatrixGroup& group) { return group.name; });
    refuse("group", name, "must be one of the matrix, " + pusht::joined(names));
  }
  return *found;
}

/// Successes of a group in a simulator, a row for each policy.
Rows successRows(const Matrix& matrix, const std::string& group, const std::string& simulator) {
  const std::size_t column = simulatorNamed(matrix, simulator);
  Rows rows;
  for (const std::size_t policy : groupNamed(matrix, group).policies) {
    const std::optional<MatrixCell>& cell = matrix.cells[policy][column];
    if (!cell) {
      refuse("group", group, "has no success of " + matrix.policies[policy].name + " in " + simulator);
    }
    rows.push_back(numbersOf(cell->successes));
  }
  return rows;
}

/// Divergences of a group in a simulator, likewise.
Rows divergenceRows(const Matrix& matrix, const std::string& group, const GroupDifference& difference) {
  const auto divergence = std::find(kMatrixDivergences.begin(), kMatrixDivergences.end(), difference.figure);
  if (divergence == kMatrixDivergences.end()) {
    refuse("figure", difference.figure,
           std::string("must be ") + kSuccessFigure + ", " + kMatrixDivergences[0] + " or " + kMatrixDivergences[1]);
  }
  const std::size_t column = simulatorNamed(matrix, difference.simulator);
  Rows rows;
  for (const std::size_t policy : groupNamed(matrix, group).policies) {
    const std::optional<MatrixCell>& cell = matrix.cells[policy][column];
    if (!cell || column == matrix.policies[policy].reference) {
      refuse("group", group,
             "has no " + difference.figure + " of " + matrix.policies[policy].name + " in " + difference.simulator);
    }
    rows.push_back(cell->divergences[static_cast<std::size_t>(divergence - kMatrixDivergences.begin())]);
  }
  return rows;
}

Rows rowsOf(const Matrix& matrix, const std::string& group, const GroupDifference& difference) {
  return difference.figure == kSuccessFigure ? successRows(matrix, group, difference.simulator)
                                             : divergenceRows(matrix, group, difference);
}

/// Difference over the starts that have the figure for all policies of both groups.
Difference found(const Matrix& matrix, const GroupDifference& difference) {
  Rows rows = rowsOf(matrix, difference.more, difference);
  const std::size_t more_count = rows.size();
  const Rows others = rowsOf(matrix, difference.less, difference);
  if (difference.paired && others.size() != more_count) {
    refuse("group", difference.less,
           "has " + std::to_string(others.size()) + " policies; must have as many as the other, " +
               std::to_string(more_count));
  }
  rows.insert(rows.end(), others.begin(), others.end());
  const Rows dense = withoutGaps(rows);
  if (dense.front().empty()) {
    refuse("figure", difference.figure, "must be there for all policies of both groups in some episode, is in none");
  }
  const auto middle = dense.begin() + static_cast<std::ptrdiff_t>(more_count);
  const CrossedTable more(Rows(dense.begin(), middle));
  const CrossedTable less(Rows(middle, dense.end()));
  Difference result = difference.paired ? crossedDifference(more.plus(-1.0, less)) : crossedDifference(more, less);
  const bool is_divergence = difference.figure != kSuccessFigure;
  if (is_divergence && (isCarriedByFewStarts(more) || isCarriedByFewStarts(less))) {
    result.interval.reset();
    result.p.reset();
  }
  return result;
}

Difference found(const Matrix& matrix, const GroupRanking& ranking) {
  if (ranking.here == ranking.there) {
    refuse("ranking", pusht::joined(ranking.groups), "must be of two simulators, is of " + ranking.here + " alone");
  }
  if (std::set<std::string>(ranking.groups.begin(), ranking.groups.end()).size() < ranking.groups.size()) {
    refuse("ranking", pusht::joined(ranking.groups), "must name each group once");
  }
  Rows here;
  Rows there;
  for (const std::string& group : ranking.groups) {
    const Rows its_here = successRows(matrix, group, ranking.here);
    const Rows its_there = successRows(matrix, group, ranking.there);
    here.insert(here.end(), its_here.begin(), its_here.end());
    there.insert(there.end(), its_there.begin(), its_there.end());
  }
  if (here.size() < 2 || matrix.episodes < 2) {
    refuse("ranking", pusht::joined(ranking.groups),
           "has " + std::to_string(here.size()) + " policies and " + std::to_string(matrix.episodes) +
               " episodes; must have two or more of each");
  }
  const Estimate kendall = compareRankings(CrossedTable(here), CrossedTable(there)).kendall;
  return {kendall.value, kendall.interval, std::nullopt};
}

bool isOnOneSide(const Hypothesis& hypothesis) { return hypothesis.side != Hypothesis::Side::kWithin; }

HypothesisResult::Verdict verdictOf(const HypothesisResult& result) {
  using Verdict = HypothesisResult::Verdict;
  const Hypothesis& hypothesis = result.hypothesis;
  if (!result.found.interval) {
    return Verdict::kNotShown;
  }
  const Interval interval = *result.found.interval;
  if (!isOnOneSide(hypothesis)) {
    const double margin = hypothesis.margin;
    return interval.low > -margin && interval.high < margin     ? Verdict::kHolds
           : interval.low >= margin || interval.high <= -margin ? Verdict::kContradicted
                                                                : Verdict::kNotShown;
  }
  const bool is_corrected = std::holds_alternative<GroupDifference>(hypothesis.figure);
  const bool is_found = !is_corrected || (result.adjusted_p && *result.adjusted_p <= 1.0 - kConfidence);
  if (!is_found || (interval.low <= 0.0 && interval.high >= 0.0)) {
    return Verdict::kNotShown;
  }
  const bool is_above = interval.low > 0.0;
  return is_above == (hypothesis.side == Hypothesis::Side::kAbove) ? Verdict::kHolds : Verdict::kContradicted;
}

}  // namespace

std::vector<HypothesisResult> test(const Matrix& matrix, const std::vector<Hypothesis>& hypotheses) {
  std::vector<HypothesisResult> results;
  std::vector<double> p;
  for (const Hypothesis& hypothesis : hypotheses) {
    try {
      results.push_back(
          {hypothesis, std::visit([&](const auto& figure) { return found(matrix, figure); }, hypothesis.figure)});
    } catch (pusht::InvalidInput& error) {
      error.addContext("hypothesis " + hypothesis.name);
      throw;
    }
    if (results.back().found.p && isOnOneSide(hypothesis)) {
      p.push_back(*results.back().found.p);
    }
  }
  const std::vector<double> adjusted = holm(p);
  auto next = adjusted.begin();
  for (HypothesisResult& result : results) {
    if (result.found.p && isOnOneSide(result.hypothesis)) {
      result.adjusted_p = *next++;
    }
    result.verdict = verdictOf(result);
  }
  return results;
}

}  // namespace sim2sim
