// SPDX-License-Identifier: BSD-3-Clause
/// Merging the shards of a sweep. Work of `rosrun sim2sim_eval merge`.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}  // namespace CLI

namespace sim2sim {

/// Command line of `merge`.
struct MergeOptions {
  std::vector<std::string> shards;  ///< folders of all shards, in any order
  std::string out;                  ///< results folder; empty: the next free results/merge-N
  bool overwrite = false;

  /// Declares the options on a command line.
  void declare(CLI::App& app);
};

/// Joins the shards of a sweep. The results have the bytes of the sweep in one piece. Throws BadDependency, naming the
/// shards, if one is missing, given twice, unfinished, or of another sweep, build or machine class; InvalidInput for a
/// folder that is no sweep or of another format.
void merge(const MergeOptions& options);

}  // namespace sim2sim
