// SPDX-License-Identifier: BSD-3-Clause
/// What `rosrun sim2sim_eval merge` does.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}  // namespace CLI

namespace sim2sim {

/// Command line of `merge`.
struct MergeOptions {
  std::vector<std::string> shards;  ///< folders
  std::string out;                  ///< folder; empty: the next free results/merge-N
  bool overwrite = false;

  /// Declares the options on a command line.
  void declare(CLI::App& app);
};

/// Joins the shards of a sweep: the bytes of the sweep in one piece. Throws BadDependency, naming them, for shards that
/// are missing, given twice, unfinished, or of another sweep, build or machine class.
void merge(const MergeOptions& options);

}  // namespace sim2sim
