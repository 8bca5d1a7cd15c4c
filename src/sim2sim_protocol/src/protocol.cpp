// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/protocol.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>

#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/spawn.hpp"

namespace sim2sim {
namespace {

constexpr int kSmokeEpisodes = 2;
constexpr int kSmokeHorizon = 40;  // [control steps]

std::string textOf(int value) { return std::to_string(value); }
std::string textOf(double value) { return pusht::shortestText(value); }

/// Refuses a number that is out of the range of its option, or no number.
template <class Number, class Option>
void requireWithin(const Option& option, Number value) {
  const OptionRange& range = option.range;
  if (range.least <= value && value <= range.greatest) {
    return;
  }
  const std::string least = textOf(static_cast<Number>(range.least));
  const bool bounded = std::isfinite(range.greatest);
  const std::string rule =
      bounded ? "from " + least + " to " + textOf(static_cast<Number>(range.greatest)) : "at least " + least;
  throw pusht::InvalidInput(std::string(option.name) + " " + textOf(value) + ": must be " + rule +
                            (*option.unit == '\0' ? "" : " [" + std::string(option.unit) + "]"));
}

}  // namespace

const char* modeName(Mode mode) {
  constexpr std::array<const char*, kModeCount> kNames = {"reference_closed", "engine_closed", "engine_replay"};
  return kNames.at(mode);
}

void Protocol::validate() const {
  const pusht::Task& run_task = runTask();
  // Ranges that leave out their lower end.
  bound().validate();
  if (until_decided && !(*until_decided > 0.0 && *until_decided <= 1.0)) {
    throw pusht::InvalidInput("until_decided " + pusht::shortestText(*until_decided) +
                              ": must be above 0 and at most 1");
  }
  forEachOption([&](const auto& option) {
    const auto& value = option.of(*this);
    using Value = std::decay_t<decltype(value)>;
    if constexpr (std::is_same_v<Value, int> || std::is_same_v<Value, double>) {
      requireWithin<Value>(option, value);
    } else if constexpr (std::is_same_v<Value, std::optional<double>>) {
      requireWithin<double>(option, value.value_or(option.range.least));
    }
  });
  for (const Probe& probe : probes()) {
    if (alone && !probe.closed) {
      throw pusht::InvalidInput("probe " + probe.name + ": must be left out without an engine");
    }
  }
  if (alone && until_decided) {
    throw pusht::InvalidInput("until_decided " + pusht::shortestText(*until_decided) +
                              ": must be left out without an engine");
  }
  if (until_decided && repeats > 1) {
    throw pusht::InvalidInput("until_decided " + pusht::shortestText(*until_decided) +
                              ": must not be given with repeats " + std::to_string(repeats) +
                              ", because its bets are on independent episodes");
  }
  if (episodes % repeats != 0 || first_episode % repeats != 0) {
    throw pusht::InvalidInput("repeats " + std::to_string(repeats) + ": must divide episodes " +
                              std::to_string(episodes) + " and first_episode " + std::to_string(first_episode) +
                              ", because a start has that many episodes, one after the other");
  }
  const auto end = static_cast<std::uint64_t>(first_episode) + static_cast<std::uint64_t>(episodes);
  if (seed > run_task.last_spawn_seed - run_task.first_spawn_seed - end) {
    throw pusht::InvalidInput("seed " + std::to_string(seed) + ": " + std::to_string(run_task.first_spawn_seed) +
                              " + seed + first_episode + episodes must be below 2^" +
                              (run_task.last_spawn_seed == UINT64_MAX ? "64" : "32"));
  }
}

std::optional<std::uint64_t> Protocol::spawnSeed(int episode) const {
  return initial_states
             ? std::nullopt
             : std::optional(runTask().first_spawn_seed + seed + static_cast<std::uint64_t>(episode / repeats));
}

pusht::WorldState Protocol::initialState(int episode) const {
  return initial_states ? initial_states->at(episode / repeats) : pusht::spawn(*spawnSeed(episode), runTask());
}

std::vector<std::string> Protocol::rolloutNames() const {
  std::vector<std::string> names;
  std::transform(kModes.begin(), kModes.end(), std::back_inserter(names), modeName);
  for (const Probe& probe : probes()) {
    names.push_back(probe.name);
  }
  return names;
}

std::optional<Probe> Protocol::probeOf(std::size_t rollout) const {
  return rollout < kModeCount ? std::nullopt : std::optional(probes().at(rollout - kModeCount));
}

bool Protocol::isClosed(std::size_t rollout) const {
  const std::optional<Probe> probe = probeOf(rollout);
  return probe ? probe->closed : rollout != kEngineReplay && isFlown(rollout);
}

bool Protocol::has(std::size_t rollout, Scope scope) const {
  if (!isFlown(rollout)) {
    return false;
  }
  const std::optional<Probe> probe = probeOf(rollout);
  switch (scope) {
    case Scope::kModes:
      return !probe || probe->closed;
    case Scope::kCompared:
      return rollout != kReferenceClosed;
    case Scope::kClosed:
      return rollout == kEngineClosed;
    case Scope::kStateReset:
    case Scope::kPushes:
      return probe && probe->reset_every > 0;
    case Scope::kCoverage:
      return hasCoverage() && isClosed(rollout);
    case Scope::kFloor:
      return probe && *probe == floorProbes().back();
  }
  return false;
}

std::vector<std::size_t> Protocol::quantityColumns() const {
  const auto may_have = [this](Scope scope) {
    return scope == Scope::kPushes ? !reanchor.empty() : scope != Scope::kCoverage || hasCoverage();
  };
  std::vector<std::size_t> columns;
  for (std::size_t i = 0; i < kQuantities.size(); ++i) {
    if (may_have(kQuantities[i].scope)) {
      columns.push_back(i);
    }
  }
  return columns;
}

std::string Protocol::initialStateKey(int episode) const {
  return initial_states ? initial_states->keyOf(episode / repeats) : std::to_string(*spawnSeed(episode));
}

std::string Protocol::cacheKey(int episode) const {
  const std::string start = initialStateKey(episode);
  return repeat(episode) == 0 ? start : start + "#" + std::to_string(repeat(episode));
}

pusht::Beginning Protocol::beginning(int episode, pusht::Role role) const {
  const bool apart = independent_noise && role == pusht::Role::kEngine;
  pusht::NumpyGenerator seeds(noise_seed, "rollout " + cacheKey(episode) + (apart ? " of the engine" : ""));
  return {seeds.bits()(), execute, role};
}

Protocol smokeRun(Protocol protocol) {
  if (protocol.episodes != Protocol().episodes || protocol.horizon != Protocol().horizon) {
    throw pusht::InvalidInput("episodes " + std::to_string(protocol.episodes) + ", horizon " +
                              std::to_string(protocol.horizon) +
                              ": must be left out for a smoke run, which has its own");
  }
  protocol.episodes = kSmokeEpisodes;
  protocol.horizon = kSmokeHorizon;
  return protocol;
}

}  // namespace sim2sim
