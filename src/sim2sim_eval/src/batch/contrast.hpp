// SPDX-License-Identifier: BSD-3-Clause
/// Pairwise comparison of runs over the same episodes. Work of the command `contrast`.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batch/requirements.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_protocol/results/contrast.hpp"

namespace sim2sim {

/// Options of the command `contrast`.
struct ContrastOptions {
  std::vector<std::string> results;  ///< folders of runs or sweeps; each row of a sweep is a run
  int against = 0;                   ///< number of the baseline among these runs, from 0
  std::filesystem::path out;         ///< JSON file for all figures; empty: none
  RequirementOptions required{};
};

/// Results of all runs that the options name, the baseline first. Throws InvalidInput if there are fewer than two, or
/// none with the number `against`; as runsIn() and readResults(). Ends as requireNotInterrupted().
std::vector<RunResults> runsToContrast(const ContrastOptions& options);

/// Compares each run with the baseline, prints the table and writes the JSON file, whose content it returns. Throws as
/// runsToContrast() and contrastsOf(); InvalidInput if there is something at `out` already; and as requireAllMet().
nlohmann::json contrast(const ContrastOptions& options, const CommandHost& host = {});

}  // namespace sim2sim
