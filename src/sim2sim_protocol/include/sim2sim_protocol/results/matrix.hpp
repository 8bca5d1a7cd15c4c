// SPDX-License-Identifier: BSD-3-Clause
/// Matrix of a sweep over policies: the success of each policy in each simulator, its transfer from its reference, and
/// what holds for groups of policies, such as those of one recipe.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim2sim_protocol/results/summary.hpp"
#include "sim2sim_statistics/intervals.hpp"
#include "sim2sim_statistics/ranking.hpp"
#include "sim2sim_statistics/spread.hpp"

namespace sim2sim {

/// Simulator of a matrix: a column.
struct MatrixSimulator {
  std::string name;   ///< as a plan names it: "mujoco:timestep=0.005"
  std::string title;  ///< for people: "MuJoCo, timestep 0.005"
};

/// Policy of a matrix: a line.
struct MatrixPolicy {
  std::string name;       ///< as in the plan
  std::string group;      ///< empty: none
  std::size_t reference;  ///< its simulator in the plan: often its home
};

/// Quantity of the replays that a matrix has beside success, over the horizon that leads in tables.
inline constexpr std::array kMatrixDivergences = {"early_position_divergence", "early_angle_divergence"};

/// Policy in a simulator.
struct MatrixCell {
  /// Folder of the sweep's row that has it, in that of the sweep; in the reference the policy's first row.
  std::string sweep_row;
  std::vector<bool> successes;                  ///< by episode, in closed loop
  SuccessRate success{};                        ///< interval: over further starts, for this policy
  std::optional<double> transfer{};             ///< success over that in the reference; none there
  std::optional<Interval> transfer_interval{};  ///< likewise over further starts
  /// Divergences of replays of the reference's actions, by kMatrixDivergences and episode; NaN where an episode is too
  /// short; empty in the reference.
  std::array<std::vector<double>, kMatrixDivergences.size()> divergences{};
  std::array<Estimate, kMatrixDivergences.size()> mean_divergences{};
};

/// Group of policies in a simulator: means over its policies, with intervals over further trainings and starts
/// (sim2sim_statistics/crossed.hpp). A group of one has that policy's success and transfer, with intervals over further
/// starts alone.
struct GroupCell {
  std::size_t policy_count;  ///< how many have the cell
  Estimate success{};        ///< rate
  Estimate transfer{};       ///< ratio of the mean rates, here over reference; NaN in it, or of several ones
  double between_policies;   ///< standard deviation of the true rates of policies, estimated; NaN below two
  /// By kMatrixDivergences, over the episodes that are long enough for all policies; NaN likewise. No interval where
  /// few starts carry the mean (isCarriedByFew()), for which the method is not made.
  std::array<Estimate, kMatrixDivergences.size()> divergences{};
};

/// Group of policies: its cells by simulator.
struct MatrixGroup {
  std::string name;
  std::vector<std::size_t> policies;            ///< in Matrix::policies
  std::vector<std::optional<GroupCell>> cells;  ///< by simulator
};

/// Ranking of the policies by their success in one simulator beside that in another.
struct MatrixRanking {
  std::size_t reference;  ///< in Matrix::simulators
  std::size_t test;
  std::size_t policy_count;  ///< how many have a cell in both
  RankingComparison comparison;
};

/// What makes the cells of a figure differ: groups, simulators, policies or starts.
struct MatrixSpread {
  std::string figure;                   ///< "success", "transfer", or one of kMatrixDivergences
  std::vector<std::size_t> simulators;  ///< those in which all policies that have a group have the figure
  Spread spread;                        ///< in the square of the figure's unit
};

/// Matrix of a sweep.
struct Matrix {
  int episodes;
  int first_episode;  ///< number of the first of them
  std::vector<MatrixSimulator> simulators;
  std::vector<MatrixPolicy> policies;
  std::vector<std::vector<std::optional<MatrixCell>>> cells;  ///< by policy and simulator; none: not in the plan
  /// Each simulator beside each other one, where two policies or more have cells in both.
  std::vector<MatrixRanking> rankings;
  std::vector<MatrixGroup> groups;    ///< in the order of their first policies
  std::vector<MatrixSpread> spreads;  ///< of the figures that two groups or more have in two simulators or more
};

/// Two policies over the same starts in one simulator.
struct PolicyPair {
  std::size_t simulator;  ///< in Matrix::simulators
  std::size_t first;      ///< in Matrix::policies
  std::size_t second;
  PairTable successes;
  Difference difference;               ///< of the success rates, second - first: Tango's interval, McNemar's mid-p
  std::optional<double> adjusted_p{};  ///< after Holm, over all pairs that are asked for
};

/// All pairs of some policies, in each simulator that both have. Throws InvalidInput for a name that is not in the
/// matrix, one that stands twice, and below two names.
std::vector<PolicyPair> pairsOf(const Matrix& matrix, const std::vector<std::string>& policies);

/// Reads the matrix of the finished sweep in `folder`, with the policies of some groups, or all if `groups` is empty.
/// Throws InvalidInput with file or row if it is no sweep over listed policies, or a shard of one, or a group is not in
/// it; also as readResults(). Calls `go_on` before each row that it reads; it may throw to end the work.
Matrix readMatrix(const std::filesystem::path& folder, const std::vector<std::string>& groups,
                  const std::function<void()>& go_on);

}  // namespace sim2sim
