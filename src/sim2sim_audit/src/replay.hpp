// SPDX-License-Identifier: BSD-3-Clause
/// Short replays of a policy's actions, put back to the reference's state every half second: the divergence that the
/// effects of findings are shares of.
#pragma once

#include <cstdint>
#include <vector>

#include "pusht_task/policy.hpp"
#include "pusht_task/simulator.hpp"

namespace sim2sim {

/// Control steps after which a replay is compared and put back.
constexpr int kReplaySteps = 5;

/// States and actions of an episode; one more state than actions.
struct EpisodeToReplay {
  std::vector<pusht::WorldState> states;
  std::vector<pusht::Action> actions;
};

/// Episodes of `policy` in `world`, from the spawns of `seed`. Throws what the world throws.
std::vector<EpisodeToReplay> recordEpisodes(pusht::Simulator& world, pusht::Policy& policy, std::uint64_t seed);

/// [m] Mean distance of the tee from where it was in the recordings, kReplaySteps after each reset to a recorded state.
double divergenceInReplays(pusht::Simulator& world, const std::vector<EpisodeToReplay>& episodes);

}  // namespace sim2sim
