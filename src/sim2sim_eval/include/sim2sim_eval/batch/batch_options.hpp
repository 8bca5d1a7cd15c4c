// SPDX-License-Identifier: BSD-3-Clause
/// Options of a run in one process that have no influence on its results.
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>

#include "sim2sim_eval/batch/loaded_run.hpp"
#include "sim2sim_protocol/reference_cache.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace sim2sim {

/// Threads and cache of a run in one process.
struct BatchOptions {
  int threads = 0;              ///< number of threads; 0: one for each core that the process may use
  std::string reference_cache;  ///< folder of the reference cache; empty: none

  /// Declares the options on a command line; the time limits of nodes are nodeTimes() of the process.
  void declare(CLI::App& app);

  /// Number of threads, at least 1.
  int threadCount() const;

  /// Cache of reference rollouts in `reference_cache`, if there is one. Throws as ReferenceCache.
  std::optional<ReferenceCache> references(const LoadedRun& loaded, const RunOptions& options) const;
};

/// Default number of episodes: the usual one, or that of the file of initial states `starts`, with the repeats of each,
/// if that is less. The usual one for an empty path or a path that is no file.
int defaultEpisodes(const RunOptions& options, const std::filesystem::path& starts);

/// Declares --loop, --loop-reference and --loop-engine, which set parameters of the loops: settings "loop.NAME=VALUE".
void declareLoop(CLI::App& app, std::vector<std::string>& reference, std::vector<std::string>& engine);

/// Declares options of a run on a command line, by their table forEachOption(): those in `names`, or all.
void declare(CLI::App& app, RunOptions& options, const std::set<std::string>& names = {});

}  // namespace sim2sim
