// SPDX-License-Identifier: BSD-3-Clause
/// Protocol of a run: which episodes are run, from which initial states, and which rollouts an episode has.
/// An episode compares two simulators, the reference and the engine. It has three rollouts from one initial state (the
/// modes), and further ones that tell how to read them (the probes).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pusht_task/policy.hpp"
#include "pusht_task/task.hpp"
#include "pusht_task/types.hpp"
#include "sim2sim_protocol/first_divergence.hpp"
#include "sim2sim_protocol/initial_states.hpp"
#include "sim2sim_protocol/probes.hpp"
#include "sim2sim_protocol/quantities.hpp"
#include "sim2sim_protocol/run_options.hpp"

namespace sim2sim {

/// The three rollouts of every episode, in the order in which they advance.
enum Mode : std::size_t {
  kReferenceClosed,  ///< closed loop: the policy drives the reference
  kEngineClosed,     ///< closed loop: the policy drives the engine. Does the skill transfer?
  kEngineReplay,     ///< open loop: the engine takes the reference's actions. How far do the dynamics diverge?
  kModeCount
};

constexpr std::array<Mode, kModeCount> kModes = {kReferenceClosed, kEngineClosed, kEngineReplay};

/// Index of a probe's rollout in Protocol::rolloutNames(), after the modes; `probe` is its index in Protocol::probes().
constexpr std::size_t rolloutOfProbe(std::size_t probe) { return kModeCount + probe; }

/// Name in episodes.csv: "reference_closed", "engine_closed", "engine_replay".
const char* modeName(Mode mode);

/// Name of the engine of a run that has none, in its description.
inline constexpr const char* kNoEngine = "none";

/// Options of a run with its given initial states, and what follows from them.
struct Protocol : RunOptions {
  /// Initial states of all episodes. Null: episodes start from the states of their spawn seeds.
  std::shared_ptr<const InitialStates> initial_states{};

  /// Task of the run. Throws InvalidInput if there is none of that name.
  const pusht::Task& runTask() const { return pusht::taskNamed(task); }

  /// Replaces the path of a task's file by what it says, so that the task is the same wherever the run goes.
  void carryTask() { task = pusht::textOf(runTask()); }

  /// Whether closed loops have the quantities of coverage.
  bool hasCoverage() const { return target_coverage || runTask().success.coverage; }

  /// Whether there is no engine: of the modes the reference's closed loop alone is flown.
  bool alone = false;

  /// Index and number of the initial states: repeats share one.
  int firstStart() const { return first_episode / repeats; }
  int starts() const { return episodes / repeats; }

  int lastEpisode() const { return first_episode + episodes - 1; }

  /// Probes of every episode, in the order in which they are run. Throws InvalidInput as probesOf().
  std::vector<Probe> probes() const { return probesOf(*this); }

  /// Largest divergence at which a rollout still counts as following the reference.
  Bound bound() const { return {bound_position, bound_angle}; }

  /// Throws InvalidInput with option, value and rule if an option is out of range, or asks for what needs an engine.
  void validate() const;

  /// Spawn seed of an episode; repeats of a start share it. It is held out: no demonstration starts from it. Empty if
  /// initial states are given.
  std::optional<std::uint64_t> spawnSeed(int episode) const;

  /// Initial state of an episode. Throws std::out_of_range if initial states are given and this one is not among them.
  pusht::WorldState initialState(int episode) const;

  /// Number of an episode among those from its start, from 0.
  int repeat(int episode) const { return episode % repeats; }

  /// Name of an episode's initial state: its spawn seed, or a hash of the given state.
  std::string initialStateKey(int episode) const;

  /// Name of what the reference cache keeps of an episode: its initial state and, after the first, its repeat.
  std::string cacheKey(int episode) const;

  /// What the policy is told of a closed loop of an episode. The seed of its random numbers follows from `noise_seed`
  /// and cacheKey(). Both roles have the same, unless `independent_noise` asks for others.
  pusht::Beginning beginning(int episode, pusht::Role role) const;

  /// Names of an episode's rollouts, in the order of its results: the modes, then the probes.
  std::vector<std::string> rolloutNames() const;

  /// Probe of a rollout, by its index in rolloutNames(); empty for a mode.
  std::optional<Probe> probeOf(std::size_t rollout) const;

  /// Whether a rollout of rolloutNames() is flown; one that is not has no step and no figure.
  bool isFlown(std::size_t rollout) const { return !alone || rollout == kReferenceClosed || rollout >= kModeCount; }

  /// Whether a policy drives a rollout; `rollout` is an index of rolloutNames().
  bool isClosed(std::size_t rollout) const;

  /// Whether a rollout has the quantities of `scope`; `rollout` is an index of rolloutNames().
  bool has(std::size_t rollout, Scope scope) const;

  /// Indices in kQuantities of the columns of episodes.csv, and of what a message of a rollout has: those of pushes are
  /// among them only if there are state-reset replays, those of coverage only if the run has them.
  std::vector<std::size_t> quantityColumns() const;
};

/// Calls function(rollout, index in kQuantities) for every quantity of every rollout of `protocol`.
template <class Function>
void forEachQuantity(const Protocol& protocol, const Function& function) {
  const std::size_t rollouts = rolloutOfProbe(protocol.probes().size());
  for (std::size_t rollout = 0; rollout < rollouts; ++rollout) {
    for (std::size_t i = 0; i < kQuantities.size(); ++i) {
      if (protocol.has(rollout, kQuantities[i].scope)) {
        function(rollout, i);
      }
    }
  }
}

/// Shortens `protocol` to the course's smoke run: 2 episodes of 40 control steps. Throws InvalidInput if `episodes` or
/// `horizon` is not the default, because a smoke run would not use it.
Protocol smokeRun(Protocol protocol);

}  // namespace sim2sim
