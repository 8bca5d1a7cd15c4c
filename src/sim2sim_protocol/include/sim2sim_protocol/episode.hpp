// SPDX-License-Identifier: BSD-3-Clause
/// Record of one episode while it is run, and what is measured of it at its end.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "pusht_task/rollout.hpp"
#include "sim2sim_protocol/ending.hpp"
#include "sim2sim_protocol/protocol.hpp"

namespace sim2sim {

/// Measurements of one rollout.
struct RolloutResult {
  int steps = 0;         ///< control steps taken
  bool success = false;  ///< whether success latched at any step
  QuantityValues quantities = noQuantities();
  std::optional<FirstDivergence> first_divergence{};  ///< empty if it stays within the protocol's bound
  std::optional<RolloutEnding> ending{};              ///< empty unless a policy drives it
  /// Control steps whose command is at the task's limit in an axis: clipped, as a rule. Empty unless a policy
  /// drives it, and in results that were read from episodes.csv.
  std::optional<int> limited_commands{};

  /// Value of a quantity by name. Throws std::out_of_range for an unknown one.
  double at(std::string_view quantity) const { return quantities[quantityIndex(quantity)]; }
  double& at(std::string_view quantity) { return quantities[quantityIndex(quantity)]; }
};

/// Measurements of one episode: its rows of episodes.csv.
struct EpisodeResult {
  int index = 0;
  std::optional<std::uint64_t> seed{};  ///< spawn seed; empty if the initial state was given
  std::vector<RolloutResult> rollouts = std::vector<RolloutResult>(kModeCount);  ///< by mode, then by probe
};

/// Rollouts of one episode in lockstep. It records what worlds do; a Flight steps them.
class Episode {
 public:
  /// `rollouts` are at their initial states; that of a cached reference is whole. `probes` are traces that are known
  /// beforehand, in the protocol's order; an empty or missing entry is still to be run.
  Episode(Protocol protocol, int index, std::array<pusht::Rollout, kModeCount> rollouts,
          std::vector<std::optional<pusht::Trace>> probes = {});

  const Protocol& protocol() const { return protocol_; }
  int index() const { return index_; }
  const pusht::Rollout& rollout(Mode mode) const { return rollouts_[mode]; }

  /// Trace of a probe, by its index in Protocol::probes(). Empty until it has been run.
  const std::optional<pusht::Trace>& probe(std::size_t probe) const { return probes_.at(probe); }

  /// Trace of a mode or a probe, by its index in Protocol::rolloutNames(). Throws std::bad_optional_access while the
  /// probe has not been run.
  const pusht::Trace& trace(std::size_t rollout) const;

  /// Largest number of control steps that a mode has taken so far.
  int steps() const;

  /// Whether a mode takes further steps. A closed loop ends at success or at the horizon, the replay with the
  /// reference.
  bool goesOn(Mode mode) const;
  bool finished() const;

  /// Action of the reference that the replay takes next. Throws std::out_of_range at the end of the reference.
  const pusht::Action& nextReplayed() const;

  /// Records one control step of a mode: the action, and the state that it led to.
  void record(Mode mode, const pusht::Action& action, const pusht::WorldState& state) {
    rollouts_[mode].record(action, state);
  }

  void recordProbe(std::size_t probe, pusht::Trace trace) { probes_.at(probe) = std::move(trace); }

  /// Measures all rollouts. Throws std::bad_optional_access while a probe has not been run.
  EpisodeResult result() const;

 private:
  Protocol protocol_;
  int index_;
  std::array<pusht::Rollout, kModeCount> rollouts_;
  std::vector<std::optional<pusht::Trace>> probes_;  // by probe of the protocol; empty: not yet run
};

}  // namespace sim2sim
