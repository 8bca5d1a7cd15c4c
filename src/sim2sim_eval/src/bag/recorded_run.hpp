// SPDX-License-Identifier: BSD-3-Clause
/// Recorded run: its episodes, computed again from a bag instead of simulated.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "bag/recorded_episode.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_protocol/results/bands.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"

namespace sim2sim {

/// Content of the bag of a run.
struct RecordedRun {
  RunConfiguration configuration;
  nlohmann::ordered_json provenance;
  DivergenceBands bands;                ///< over the finished episodes
  std::vector<EpisodeResult> episodes;  ///< finished episodes by index, computed from the recorded states
};

/// Reads the bag at `path`. `each` gets every finished episode, in the bag's order. Throws InvalidInput if `path` is
/// not the bag of a run or was not closed, BadDependency if a recorded episode does not follow the protocol,
/// RuntimeFault if `stop` holds before the end.
RecordedRun readRun(
    const std::filesystem::path& path, const std::function<bool()>& stop = [] { return false; },
    const std::function<void(Episode&&)>& each = [](Episode&&) {});

}  // namespace sim2sim
