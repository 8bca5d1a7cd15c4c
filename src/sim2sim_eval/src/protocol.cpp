// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/protocol.hpp"

#include <algorithm>
#include <limits>
#include <string>

#include "pusht_task/error.hpp"
#include "pusht_task/spawn.hpp"

namespace sim2sim {
namespace {

constexpr std::uint64_t kFirstHeldOutSeed = 10'000;
constexpr int kMaxEpisodes = 1'000'000;

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
  requireWithin("episodes", episodes, 1, kMaxEpisodes);
  requireWithin("horizon", horizon, 1, pusht::kHorizon);
  if (seed > std::numeric_limits<std::uint64_t>::max() - kFirstHeldOutSeed - static_cast<std::uint64_t>(episodes)) {
    throw pusht::InvalidInput("seed " + std::to_string(seed) + ": 10000 + seed + episodes must be below 2^64");
  }
}

std::uint64_t Protocol::spawnSeed(int episode) const {
  return kFirstHeldOutSeed + seed + static_cast<std::uint64_t>(episode);
}

Episode::Episode(const Protocol& protocol, int index, const Worlds& worlds, const pusht::Policy& policy)
    : index_(index),
      seed_(protocol.spawnSeed(index)),
      horizon_(protocol.horizon),
      rollouts_{pusht::Rollout(*worlds.reference, pusht::spawn(seed_), policy.begin()),
                pusht::Rollout(*worlds.engine, pusht::spawn(seed_), policy.begin()),
                pusht::Rollout(*worlds.replay, pusht::spawn(seed_))} {}

bool Episode::loopGoesOn(Mode mode) const { return !rollouts_[mode].finished(horizon_); }

bool Episode::replayGoesOn() const { return rollouts_[kEngineReplay].steps() < rollouts_[kReferenceClosed].steps(); }

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
  try {
    requireFinite(action);
    rollouts_[mode].advance(action);
  } catch (const pusht::Error& error) {
    throw pusht::Error(error.exitCode(), "episode " + std::to_string(index_) + " (spawn seed " + std::to_string(seed_) +
                                             "), " + modeName(mode) + ", step " +
                                             std::to_string(rollouts_[mode].steps()) + ": " + error.what());
  }
}

EpisodeResult Episode::result() const {
  EpisodeResult result{index_, seed_, {}};
  const pusht::Trace& reference = rollouts_[kReferenceClosed].trace();
  for (std::size_t mode = 0; mode < kModeCount; ++mode) {
    const pusht::Rollout& rollout = rollouts_[mode];
    result.modes[mode] = {rollout.steps(), rollout.success(), rollout.error(), std::nullopt};
    if (mode != kReferenceClosed) {
      result.modes[mode].mean_divergence = meanDivergence(reference, rollout.trace());
    }
  }
  return result;
}

void runProtocol(const Protocol& protocol, const std::function<Worlds()>& make_worlds, pusht::Policy& policy,
                 const std::function<void(const EpisodeResult&)>& deliver, const std::function<bool()>& stop) {
  protocol.validate();
  std::vector<Slot> slots(static_cast<std::size_t>(std::min(kEpisodesInFlight, protocol.episodes)));
  for (Slot& slot : slots) {
    slot.worlds = make_worlds();
  }
  int next_episode = 0;
  std::vector<pusht::Policy::Query> queries;
  std::vector<pusht::Action> actions;
  while (!stop()) {
    // Fill the empty slots.
    for (Slot& slot : slots) {
      if (!slot.episode && next_episode < protocol.episodes) {
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
    bool any_left = next_episode < protocol.episodes;
    for (Slot& slot : slots) {
      if (slot.episode) {
        slot.episode->advance(actions, next_action);
        if (slot.episode->finished()) {
          deliver(slot.episode->result());
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
