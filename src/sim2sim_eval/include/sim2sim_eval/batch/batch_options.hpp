// SPDX-License-Identifier: BSD-3-Clause
/// How a run in process goes about its episodes.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "sim2sim_eval/batch/loaded_run.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_protocol/reference_cache.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace sim2sim {

/// Without influence on the results.
struct BatchOptions {
  int threads = 0;              ///< 0: as many as there are cores
  std::string reference_cache;  ///< folder; empty: none

  /// Declares the options on a command line.
  void declare(CLI::App& app);

  int threadCount() const;

  /// The cache that they ask for. Throws as ReferenceCache does.
  std::optional<ReferenceCache> references(const LoadedRun& loaded, const RunOptions& options) const;
};

/// The number of episodes of a run that names none: `usual`, or as many as the file has starts, if these are fewer. An
/// empty path, or a file that cannot be read, means `usual`.
int defaultEpisodes(int usual, const std::filesystem::path& starts);

/// Declares each option of a run on a command line.
void declare(CLI::App& app, RunOptions& options);

}  // namespace sim2sim
