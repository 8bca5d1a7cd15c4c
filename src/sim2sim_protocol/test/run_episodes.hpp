// SPDX-License-Identifier: BSD-3-Clause
/// Made-up episodes of a run.
#pragma once

#include <cstdint>
#include <vector>

#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"

namespace sim2sim {

/// The modes alone.
inline Protocol bare() {
  Protocol protocol;
  protocol.floor = false;
  return protocol;
}

inline RunConfiguration bareConfiguration() {
  RunConfiguration configuration;
  configuration.protocol = bare();
  return configuration;
}

/// `total` episodes, the first `reference` and `engine` of which succeed.
inline std::vector<EpisodeResult> episodesWith(int total, int reference, int engine) {
  std::vector<EpisodeResult> episodes;
  for (int i = 0; i < total; ++i) {
    EpisodeResult episode;
    episode.index = i;
    episode.seed = 10'000U + static_cast<std::uint64_t>(i);
    for (RolloutResult& rollout : episode.rollouts) {
      rollout.at("final_position_error") = 0.0;
      rollout.at("final_angle_error") = 0.0;
      rollout.at("null_position_divergence") = 0.2;
      rollout.at("null_angle_divergence") = 1.0;
    }
    episode.rollouts[kReferenceClosed].success = i < reference;
    episode.rollouts[kEngineClosed].success = i < engine;
    episode.rollouts[kEngineClosed].at("mean_position_divergence") = 0.5;
    episode.rollouts[kEngineClosed].at("mean_angle_divergence") = 0.5;
    episode.rollouts[kEngineReplay].success = true;  // must not count
    episode.rollouts[kEngineReplay].at("mean_position_divergence") = 0.01 * i;
    episode.rollouts[kEngineReplay].at("mean_angle_divergence") = 0.05 * i;
    episodes.push_back(episode);
  }
  return episodes;
}

}  // namespace sim2sim
