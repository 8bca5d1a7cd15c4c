// SPDX-License-Identifier: BSD-3-Clause
/// Results of a run, computed again from its bag. Work of the command `recompute`.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"

namespace sim2sim {

/// Options of the command `recompute`.
struct RecomputeOptions {
  std::filesystem::path bag;  ///< compare.bag of a run
  std::filesystem::path out;  ///< results folder; empty: the next free results/recompute-N
  bool overwrite = false;     ///< replace results that are in the folder
  bool traces = false;        ///< write traces.npy
};

/// Indices of the episodes that a run of `protocol` lacks, as text: "3, 5 to 9". `episodes` are the finished ones by
/// index. Empty if it lacks none.
std::string missingEpisodes(const Protocol& protocol, const std::vector<EpisodeResult>& episodes);

/// Writes the results folder, with the bytes of the run's own results, and prints the table. Throws as readRun();
/// RuntimeFault, naming the missing episodes, if the bag does not hold a whole run: finished episodes are written then.
void recompute(const RecomputeOptions& options);

}  // namespace sim2sim
