// SPDX-License-Identifier: BSD-3-Clause
/// The measurement: one policy, one start, two simulators, three modes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pusht_task/batch_simulator.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/policy.hpp"
#include "pusht_task/rollout.hpp"
#include "pusht_task/simulator.hpp"
#include "sim2sim_protocol/parting.hpp"
#include "sim2sim_protocol/probes.hpp"
#include "sim2sim_protocol/quantities.hpp"
#include "sim2sim_protocol/run_options.hpp"
#include "sim2sim_protocol/starts.hpp"

namespace sim2sim {

class ReferenceCache;

/// The three rollouts of an episode, in the order in which they advance.
enum Mode : std::size_t {
  kReferenceClosed,  ///< the policy drives the reference
  kEngineClosed,     ///< the policy drives the engine: does the skill transfer?
  kEngineReplay,     ///< the engine is given the reference's actions: how far do the dynamics diverge?
  kModeCount
};

constexpr std::array<Mode, kModeCount> kModes = {kReferenceClosed, kEngineClosed, kEngineReplay};

/// As in episodes.csv: "reference_closed", ...
const char* modeName(Mode mode);

/// Which episodes are run, and in which rollouts.
struct Protocol : RunOptions {
  std::shared_ptr<const Starts> starts{};  ///< of all episodes; none: they come of the spawn seeds

  int lastEpisode() const { return first_episode + episodes - 1; }

  /// Run when the modes of an episode have ended. Throws as probesOf().
  std::vector<Probe> probes() const { return probesOf(floor, reanchor); }

  /// Beyond it a rollout has parted from the reference.
  Bound bound() const { return {bound_position, bound_angle}; }

  /// Throws InvalidInput with field, value and rule.
  void validate() const;

  /// Spawn seed of an episode: held out, no demonstration starts there. None where the starts are given.
  std::optional<std::uint64_t> spawnSeed(int episode) const;

  pusht::WorldState start(int episode) const;

  /// Of every rollout of an episode, in the order of its results: the modes, then the probes.
  std::vector<std::string> rolloutNames() const;

  /// Whether a rollout has the quantities of a scope; `rollout` is its place in rolloutNames().
  bool has(std::size_t rollout, Scope scope) const;

  /// Of the start, for who keeps what comes of it: its spawn seed, or a hash.
  std::string startName(int episode) const;
};

/// Calls function(rollout, index in kQuantities) for every quantity that a rollout of `protocol` has.
template <class Function>
void forEachQuantity(const Protocol& protocol, const Function& function) {
  const std::size_t rollouts = kModeCount + protocol.probes().size();
  for (std::size_t rollout = 0; rollout < rollouts; ++rollout) {
    for (std::size_t i = 0; i < kQuantities.size(); ++i) {
      if (protocol.has(rollout, kQuantities[i].scope)) {
        function(rollout, i);
      }
    }
  }
}

/// `protocol` as short as the course's smoke run: 2 episodes of 40 control steps. Throws InvalidInput if `protocol`
/// names other numbers than the default ones: they would be in the course's configuration hash, and nowhere else.
Protocol smokeRun(Protocol protocol);

/// Result of a rollout: its length, success and quantities.
struct RolloutResult {
  int steps = 0;
  bool success = false;  ///< whether success latched at any step
  QuantityValues quantities = noQuantities();
  std::optional<Parting> parting{};  ///< from the reference, if it leaves the protocol's bound

  double at(std::string_view quantity) const { return quantities[quantityIndex(quantity)]; }
  double& at(std::string_view quantity) { return quantities[quantityIndex(quantity)]; }
};

/// Result of an episode: its rollouts by mode, then by probe.
struct EpisodeResult {
  int index = 0;
  std::optional<std::uint64_t> seed{};  ///< spawn seed; none where the start was given
  std::vector<RolloutResult> rollouts = std::vector<RolloutResult>(kModeCount);  ///< by mode, then by probe
};

/// Of a rollout that took place before; none where it must be run.
struct Recalled {
  std::optional<pusht::Trace> reference{};
  std::vector<std::optional<pusht::Trace>> probes{};  ///< as those of the protocol; may be shorter
};

/// The worlds in which episodes run: for each mode a lane for each episode in flight.
using Worlds = std::array<std::unique_ptr<pusht::BatchSimulator>, kModeCount>;

/// For one episode at a time.
Worlds worldsOf(std::unique_ptr<pusht::Simulator> reference, std::unique_ptr<pusht::Simulator> engine,
                std::unique_ptr<pusht::Simulator> replay);

/// One episode: three rollouts from one start, advanced in lockstep by a Flight, and the probes that follow.
class Episode {
 public:
  Episode(Protocol protocol, int index, std::array<pusht::Rollout, kModeCount> rollouts,
          std::vector<std::optional<pusht::Trace>> probes = {});

  int index() const { return index_; }
  const pusht::Rollout& rollout(Mode mode) const { return rollouts_[mode]; }

  /// What a probe of the protocol did, once it has been run.
  const std::optional<pusht::Trace>& probe(std::size_t probe) const { return probes_.at(probe); }

  /// Control steps taken, those of the rollout that has taken most.
  int steps() const;

  /// A closed loop ends at success or the horizon, the replay with the reference.
  bool goesOn(Mode mode) const;
  bool finished() const;

  /// The action of the reference that the replay is to take next.
  const pusht::Action& nextReplayed() const;

  void record(Mode mode, const pusht::Action& action, const pusht::WorldState& state) {
    rollouts_[mode].record(action, state);
  }

  void recordProbe(std::size_t probe, pusht::Trace trace) { probes_.at(probe) = std::move(trace); }

  /// Once all probes have been run.
  EpisodeResult result() const;

 private:
  Protocol protocol_;
  int index_;
  std::array<pusht::Rollout, kModeCount> rollouts_;
  std::vector<std::optional<pusht::Trace>> probes_;  // by probe of the protocol; none: not yet run
};

/// Episodes in flight: they advance together, so that the policy sees batches and worlds step in lanes. What becomes
/// of an episode does not depend on the others.
class Flight {
 public:
  /// `worlds` and `policy` must outlive it, and are driven by it alone.
  Flight(Protocol protocol, const Worlds& worlds, pusht::Policy& policy);

  bool full() const;
  bool empty() const;

  /// Resets worlds to the start of an episode; the flight must not be full. What is recalled of it is not rolled out.
  /// The episode stays where it is until it lands. Throws the error of a world; its message begins with episode, mode
  /// and step.
  const Episode& begin(int index, Recalled recalled = {});

  /// One control step of every rollout that goes on. Throws as begin(), and BadDependency for an action that is not
  /// finite.
  void advance();

  /// Takes out the episodes that have finished, when their probes have been run, in the worlds that they leave.
  /// `watch` is called before every step of a probe, and may throw. Throws as begin().
  std::vector<Episode> land(const std::function<void()>& watch = [] {});

 private:
  void askPolicy();
  pusht::Rollout start(Mode mode, std::size_t lane, int index, std::unique_ptr<pusht::Policy::Memory> memory);
  bool goesOn(Mode mode, std::size_t lane) const { return episodes_[lane] && episodes_[lane]->goesOn(mode); }
  void advance(Mode mode, std::size_t& next_action);
  void probe(Episode& episode, std::size_t lane, const std::function<void()>& watch) const;

  Protocol protocol_;
  const Worlds& worlds_;
  pusht::Policy& policy_;
  std::vector<std::optional<Episode>> episodes_;  // by lane
  std::vector<pusht::Policy::Query> queries_;     // of the closed loops, by mode and lane
  std::vector<pusht::Action> answers_;
  std::vector<std::optional<pusht::Action>> actions_;  // of one mode, by lane
};

/// Runs one episode.
Episode runEpisode(const Protocol& protocol, int index, const Worlds& worlds, pusht::Policy& policy,
                   Recalled recalled = {});

/// Episodes in flight at once in each thread of a run: enough for the lanes of the engine and the policy's batches.
constexpr int kEpisodesInFlight = 8;

/// Who plays in a run. Every thread has its own.
struct Players {
  std::function<Worlds(int lanes)> make_worlds;
  std::function<std::unique_ptr<pusht::Policy>()> make_policy;
};

/// Runs the protocol in `threads` threads. `deliver` gets every episode when it has finished, not in order but one at a
/// time; `stop` is asked before every control step of the modes and ends the run early when true. Neither the reference
/// nor its floor is rolled out for episodes that are in `references`; those of the others are kept there. Results
/// depend neither on the number of threads nor on `references`.
void runProtocol(const Protocol& protocol, const Players& players, int threads, const ReferenceCache* references,
                 const std::function<void(Episode&&)>& deliver, const std::function<bool()>& stop);

}  // namespace sim2sim
