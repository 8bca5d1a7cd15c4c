// SPDX-License-Identifier: BSD-3-Clause
/// Planning a measurement: the smallest differences that a number of episodes shows, and the number of episodes that
/// shows a given difference. Work of the command `plan`.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_protocol/results/contrast.hpp"
#include "sim2sim_protocol/results/matrix.hpp"

namespace sim2sim {

/// Questions to a plan. Each difference is optional; with it, the plan says how many episodes show it.
struct PlanQuestions {
  std::vector<int> episodes = {50, 200, 1000};  ///< numbers of episodes, a column of the table each
  std::optional<double> success{};              ///< difference of success rates, above 0
  std::optional<double> position{};             ///< difference of mean position divergences [m], above 0
  std::optional<double> angle{};                ///< difference of mean angle divergences [rad], above 0
};

/// Options of the command `plan`.
struct PlanOptions {
  std::string pilot;  ///< folder of a finished run, or of a sweep over policies; it says how much they vary
  std::string other;  ///< folder of a second run over the same episodes, to plan a contrast of the two; empty: none
  PlanQuestions questions;
};

/// Table for the terminal: a row for each figure of the run, and of the contrast with `other`; a column for each number
/// of episodes. A cell is the smallest difference that is found in 80 % of runs, tested at 5 % on both sides; "-" where
/// no pair of the pilot differs, "none" where not even the largest possible difference is found.
std::string planTable(const PlanQuestions& questions, const RunResults& pilot, const std::optional<RunResults>& other);

/// Table for the terminal: for each two simulators the number of policies that shows that a ranking is preserved, if
/// Kendall's tau is that of `pilot`.
std::string policiesTable(const Matrix& pilot);

/// Reads the runs and prints planTable(), or the sweep and prints policiesTable(). Returns the figures of the table;
/// null where it has none. Throws InvalidInput for a difference that is not above 0 or asked of a sweep, a folder
/// without results, or two runs that do not pair.
nlohmann::json plan(const PlanOptions& options, const CommandHost& host = {});

}  // namespace sim2sim
