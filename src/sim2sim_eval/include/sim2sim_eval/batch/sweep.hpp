// SPDX-License-Identifier: BSD-3-Clause
/// Sweeps in process: what `rosrun sim2sim_eval sweep` does.
#pragma once

#include <string>

#include "sim2sim_eval/batch/batch_options.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace sim2sim {

/// Command line of `sweep`.
struct SweepOptions {
  std::string plan;   ///< YAML file, as readSweepPlan()
  int episodes = 0;   ///< instead of those of the plan; 0: as there
  std::string shard;  ///< "I/N"; empty: the whole sweep
  std::string out;    ///< folder; empty: the next free results/sweep-N
  bool overwrite = false;
  BatchOptions batch;

  /// Declares the options on a command line.
  void declare(CLI::App& app);
};

/// Runs a sweep, or goes on with it: rows that the folder holds are not run again. The reference is rolled out once for
/// all rows. A row in which a simulation fails does not keep the others from running. Throws an Error of its kind on
/// failure; finished rows are kept then.
void sweep(const SweepOptions& options);

}  // namespace sim2sim
