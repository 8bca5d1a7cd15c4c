// SPDX-License-Identifier: BSD-3-Clause
#include "replay.hpp"

#include <cstddef>

#include "pusht_task/spawn.hpp"
#include "pusht_task/task.hpp"

namespace sim2sim {
namespace {

EpisodeToReplay recordEpisode(pusht::Simulator& world, pusht::Policy& policy, const pusht::WorldState& start) {
  constexpr int kSteps = 50;
  const auto memory = policy.begin({});
  world.reset(start);
  EpisodeToReplay episode = {{world.state()}, {}};
  for (int step = 0; step < kSteps; ++step) {
    const pusht::Policy::Query query = {pusht::observe(episode.states.back(), world.task()), memory.get()};
    pusht::Action action{};
    policy.act({&query, 1}, {&action, 1});
    world.step(action);
    episode.actions.push_back(action);
    episode.states.push_back(world.state());
  }
  return episode;
}

}  // namespace

std::vector<EpisodeToReplay> recordEpisodes(pusht::Simulator& world, pusht::Policy& policy, std::uint64_t seed) {
  constexpr std::uint64_t kEpisodes = 8;
  std::vector<EpisodeToReplay> episodes;
  for (std::uint64_t i = 0; i < kEpisodes; ++i) {
    episodes.push_back(
        recordEpisode(world, policy, pusht::spawn(world.task().first_spawn_seed + seed + i, world.task())));
  }
  return episodes;
}

double divergenceInReplays(pusht::Simulator& world, const std::vector<EpisodeToReplay>& episodes) {
  constexpr std::size_t kSteps = kReplaySteps;
  double sum = 0.0;
  int count = 0;
  for (const EpisodeToReplay& episode : episodes) {
    for (std::size_t anchor = 0; anchor + kSteps <= episode.actions.size(); anchor += kSteps) {
      world.reset(episode.states[anchor]);
      for (std::size_t step = anchor; step < anchor + kSteps; ++step) {
        world.step(episode.actions[step]);
      }
      sum += (world.state().tee_position - episode.states[anchor + kSteps].tee_position).norm();
      ++count;
    }
  }
  return count == 0 ? 0.0 : sum / count;
}

}  // namespace sim2sim
