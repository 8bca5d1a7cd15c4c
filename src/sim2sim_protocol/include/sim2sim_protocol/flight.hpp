// SPDX-License-Identifier: BSD-3-Clause
/// Stepping of episodes: asks the policy, steps the worlds and runs the probes.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "pusht_task/batch_simulator.hpp"
#include "pusht_task/policy.hpp"
#include "pusht_task/rollout.hpp"
#include "pusht_task/simulator.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"

namespace sim2sim {

/// Simulators in which episodes run: one for each mode, with a lane for each episode in flight. A null replay runs in
/// the engine's, after the closed loop: the world is reset in between, and must start as before.
using Worlds = std::array<std::unique_ptr<pusht::BatchSimulator>, kModeCount>;

/// Worlds of the model variants, in the order of variantsOf(); each has one lane.
using VariantWorlds = std::vector<std::unique_ptr<pusht::BatchSimulator>>;

/// Worlds of one lane, from three single simulators.
Worlds worldsOf(std::unique_ptr<pusht::Simulator> reference, std::unique_ptr<pusht::Simulator> engine,
                std::unique_ptr<pusht::Simulator> replay);

/// Cached traces of an episode; an empty entry is simulated.
struct CachedTraces {
  std::optional<pusht::Trace> reference{};
  std::vector<std::optional<pusht::Trace>> probes{};  ///< in the protocol's order; missing entries are empty
};

/// Episodes in flight. They advance together, so that the policy gets batches and worlds step in lanes. The result of
/// an episode does not depend on the others.
class Flight {
 public:
  /// `worlds`, `policy` and `variants`, one for each model variant of the protocol, must outlive the flight, which
  /// alone drives them. It has as many places as the worlds have lanes. After an exception it must not be used again.
  Flight(Protocol protocol, const Worlds& worlds, pusht::Policy& policy, const VariantWorlds& variants);

  bool full() const;
  bool empty() const;

  /// Begins an episode: resets its worlds to the initial state. The flight must not be full. Returns the episode, which
  /// is valid until it lands. Throws the error of a world, with episode, mode and step before its message.
  const Episode& begin(int index, CachedTraces cached = {});

  /// Advances every unfinished rollout by one control step. Throws as begin(), BadDependency for an action that is not
  /// finite, and what the policy throws.
  void advance();

  /// Takes out the finished episodes, after running their probes in the worlds that they leave. Calls `watch` before
  /// every step of a probe; it may throw. Throws as begin().
  std::vector<Episode> land(const std::function<void()>& watch = [] {});

 private:
  void askPolicy();
  pusht::Rollout start(Mode mode, std::size_t lane, int index, std::unique_ptr<pusht::Policy::Memory> memory);
  bool goesOn(Mode mode, std::size_t lane) const { return episodes_[lane] && episodes_[lane]->goesOn(mode); }
  bool mayAdvance(Mode mode, std::size_t lane) const;
  bool replaysAfterwards() const { return worlds_[kEngineReplay] == nullptr; }
  pusht::BatchSimulator& worldOf(Mode mode) const;
  void advance(Mode mode, std::size_t& next_answer);
  void turnToReplay(std::size_t lane);
  void probe(Episode& episode, std::size_t lane, const std::function<void()>& watch) const;
  pusht::BatchSimulator& variantOf(const Probe& probe) const;
  pusht::Trace drive(pusht::BatchSimulator& world, int index, const std::function<void(int)>& before_step) const;

  Protocol protocol_;
  const Worlds& worlds_;
  pusht::Policy& policy_;
  const VariantWorlds& variants_;
  std::vector<std::optional<Episode>> episodes_;  // by lane
  std::vector<pusht::Policy::Query> queries_;     // of the closed loops, by mode and lane
  std::vector<pusht::Action> answers_;
  std::vector<std::optional<pusht::Action>> actions_;  // of one mode, by lane
};

/// Runs one episode to its end, in the first lane of `worlds`; `protocol` has no model variants but those that are
/// cached. Throws as Flight.
Episode runEpisode(const Protocol& protocol, int index, const Worlds& worlds, pusht::Policy& policy,
                   CachedTraces cached = {});

}  // namespace sim2sim
