// SPDX-License-Identifier: BSD-3-Clause
/// Sweep in one process. Work of `rosrun sim2sim_eval sweep`.
#pragma once

#include <string>

#include "sim2sim_eval/batch/batch_options.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace sim2sim {

/// Command line of `sweep`.
struct SweepOptions {
  std::string plan;   ///< YAML file for readSweepPlan()
  int episodes = 0;   ///< number of episodes instead of the plan's; 0: the plan's
  std::string shard;  ///< "I/N"; empty: the whole sweep
  std::string out;    ///< results folder; empty: the next free results/sweep-N
  bool overwrite = false;
  BatchOptions batch;

  /// Declares the options on a command line.
  void declare(CLI::App& app);
};

/// Runs all rows of a plan over the same episodes, or continues an unfinished sweep: rows in the folder are not run
/// again. The reference is simulated once for all rows. A row whose simulation fails is left out, and the others run.
/// Throws InvalidInput for a bad plan, RuntimeFault if it was interrupted or a row has failed; finished rows are kept
/// then.
void sweep(const SweepOptions& options);

}  // namespace sim2sim
