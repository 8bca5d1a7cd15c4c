// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/protocol.hpp"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/spawn.hpp"

namespace sim2sim {
namespace {

constexpr std::uint64_t kFirstHeldOutSeed = 10'000;
constexpr int kMaxEpisodes = 1'000'000;
constexpr int kMaxFirstEpisode = 1'000'000'000;

constexpr int kSmokeEpisodes = 2;
constexpr int kSmokeHorizon = 40;  // [control steps]

void requireWithin(const char* field, int value, int low, int high) {
  if (value < low || value > high) {
    throw pusht::InvalidInput(std::string(field) + " " + std::to_string(value) + ": must be from " +
                              std::to_string(low) + " to " + std::to_string(high));
  }
}

void requireFinite(const pusht::Action& action) {
  if (!pusht::isFinite(action)) {
    throw pusht::BadDependency("the policy's action (" + std::to_string(action[0]) + ", " + std::to_string(action[1]) +
                               ") must be finite");
  }
}

/// Runs `action`; an error of it then says where in the episode it came up.
template <class Function>
auto located(int episode, std::uint64_t seed, Mode mode, int step, const Function& action) {
  try {
    return action();
  } catch (pusht::Error& error) {
    error.addContext("episode " + std::to_string(episode) + " (spawn seed " + std::to_string(seed) + "), " +
                     modeName(mode) + ", step " + std::to_string(step));
    throw;
  }
}

/// An episode and the worlds it runs in, for one episode after the other.
struct Slot {
  Worlds worlds;
  std::optional<Episode> episode;
};

}  // namespace

const char* modeName(Mode mode) {
  constexpr std::array<const char*, kModeCount> kNames = {"reference_closed", "engine_closed", "engine_replay"};
  return kNames.at(mode);
}

void Protocol::validate() const {
  requireWithin("first_episode", first_episode, 0, kMaxFirstEpisode);
  requireWithin("episodes", episodes, 1, kMaxEpisodes);
  requireWithin("horizon", horizon, 1, pusht::kHorizon);
  const auto end = static_cast<std::uint64_t>(first_episode) + static_cast<std::uint64_t>(episodes);
  if (seed > std::numeric_limits<std::uint64_t>::max() - kFirstHeldOutSeed - end) {
    throw pusht::InvalidInput("seed " + std::to_string(seed) +
                              ": 10000 + seed + first_episode + episodes must be below 2^64");
  }
}

std::uint64_t Protocol::spawnSeed(int episode) const {
  return kFirstHeldOutSeed + seed + static_cast<std::uint64_t>(episode);
}

Protocol smokeRun(Protocol protocol) {
  protocol.episodes = kSmokeEpisodes;
  protocol.horizon = kSmokeHorizon;
  return protocol;
}

Episode::Episode(const Protocol& protocol, int index, const Worlds& worlds, const pusht::Policy& policy)
    : index_(index),
      seed_(protocol.spawnSeed(index)),
      horizon_(protocol.horizon),
      rollouts_{begin(kReferenceClosed, *worlds.reference, policy.begin()),
                begin(kEngineClosed, *worlds.engine, policy.begin()), begin(kEngineReplay, *worlds.replay, nullptr)} {}

pusht::Rollout Episode::begin(Mode mode, pusht::Simulator& world, std::unique_ptr<pusht::Policy::Memory> memory) const {
  return located(index_, seed_, mode, 0, [&] { return pusht::Rollout(world, pusht::spawn(seed_), std::move(memory)); });
}

bool Episode::loopGoesOn(Mode mode) const { return !rollouts_[mode].finished(horizon_); }

bool Episode::replayGoesOn() const { return rollouts_[kEngineReplay].steps() < rollouts_[kReferenceClosed].steps(); }

int Episode::steps() const {
  return std::max_element(rollouts_.begin(), rollouts_.end(),
                          [](const auto& a, const auto& b) { return a.steps() < b.steps(); })
      ->steps();
}

bool Episode::finished() const {
  return !loopGoesOn(kReferenceClosed) && !loopGoesOn(kEngineClosed) && !replayGoesOn();
}

void Episode::appendQueries(std::vector<pusht::Policy::Query>& queries) const {
  for (const Mode mode : {kReferenceClosed, kEngineClosed}) {
    if (loopGoesOn(mode)) {
      queries.push_back(rollouts_[mode].query());
    }
  }
}

void Episode::advance(const std::vector<pusht::Action>& actions, std::size_t& next) {
  for (const Mode mode : {kReferenceClosed, kEngineClosed}) {
    if (loopGoesOn(mode)) {
      advance(mode, actions.at(next++));
    }
  }
  if (replayGoesOn()) {
    const auto step = static_cast<std::size_t>(rollouts_[kEngineReplay].steps());
    advance(kEngineReplay, rollouts_[kReferenceClosed].trace().actions[step]);
  }
}

void Episode::advance(Mode mode, const pusht::Action& action) {
  located(index_, seed_, mode, rollouts_[mode].steps(), [&] {
    requireFinite(action);
    rollouts_[mode].advance(action);
  });
}

void Episode::advance(pusht::Policy& policy) {
  std::vector<pusht::Policy::Query> queries;
  appendQueries(queries);
  std::vector<pusht::Action> actions(queries.size());
  policy.act(queries, actions);
  std::size_t next = 0;
  advance(actions, next);
}

EpisodeResult Episode::result() const {
  EpisodeResult result{index_, seed_, {}};
  const pusht::Trace& reference = rollouts_[kReferenceClosed].trace();
  for (const Mode mode : kModes) {
    const pusht::Rollout& rollout = rollouts_[mode];
    result.modes[mode] = {rollout.steps(), rollout.success(), rollout.error(), std::nullopt};
    if (mode != kReferenceClosed) {
      result.modes[mode].mean_divergence = meanDivergence(reference, rollout.trace());
    }
  }
  return result;
}

void runProtocol(const Protocol& protocol, const std::function<Worlds()>& make_worlds, pusht::Policy& policy,
                 const std::function<void(const Episode&)>& deliver, const std::function<bool()>& stop) {
  protocol.validate();
  std::vector<Slot> slots(static_cast<std::size_t>(std::min(kEpisodesInFlight, protocol.episodes)));
  for (Slot& slot : slots) {
    slot.worlds = make_worlds();
  }
  int next_episode = protocol.first_episode;
  std::vector<pusht::Policy::Query> queries;
  std::vector<pusht::Action> actions;
  while (!stop()) {
    // Fill the empty slots.
    for (Slot& slot : slots) {
      if (!slot.episode && next_episode <= protocol.lastEpisode()) {
        slot.episode.emplace(protocol, next_episode++, slot.worlds, policy);
      }
    }

    // Ask the policy once for all rollouts.
    queries.clear();
    for (const Slot& slot : slots) {
      if (slot.episode) {
        slot.episode->appendQueries(queries);
      }
    }
    actions.resize(queries.size());
    policy.act(queries, actions);

    // One control step of every episode.
    std::size_t next_action = 0;
    bool any_left = next_episode <= protocol.lastEpisode();
    for (Slot& slot : slots) {
      if (slot.episode) {
        slot.episode->advance(actions, next_action);
        if (slot.episode->finished()) {
          deliver(*slot.episode);
          slot.episode.reset();
        }
        any_left = any_left || slot.episode;
      }
    }
    if (!any_left) {
      return;
    }
  }
}

}  // namespace sim2sim
