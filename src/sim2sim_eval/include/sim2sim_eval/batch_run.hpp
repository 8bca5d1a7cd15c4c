// SPDX-License-Identifier: BSD-3-Clause
/// A run in process, many episodes at a time.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <string>

#include "sim2sim_eval/protocol.hpp"
#include "sim2sim_eval/reference_cache.hpp"
#include "sim2sim_eval/run.hpp"
#include "sim2sim_eval/setup.hpp"

namespace sim2sim {

/// How episodes are run in process, with no influence on the results.
struct BatchOptions {
  int threads = 0;              ///< 0: as many as there are cores
  std::string reference_cache;  ///< folder; empty: none

  /// Declares the options on a command line.
  void declare(CLI::App& app);

  int threadCount() const;

  /// The cache that they ask for. Throws as ReferenceCache does.
  std::optional<ReferenceCache> references(const Setup& setup, int horizon) const;
};

/// Runs the episodes of `run` in this process and adds them. `deliver`, which may be null, gets each first, one at a
/// time. Throws RuntimeFault if it is interrupted.
void runEpisodes(Run& run, const Players& players, int threads, const ReferenceCache* references,
                 const std::function<void(const Episode&)>& deliver);

}  // namespace sim2sim
