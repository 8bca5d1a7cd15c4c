// SPDX-License-Identifier: BSD-3-Clause
/// The measurement: one policy, one start, two simulators, three modes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "pusht_task/constants.hpp"
#include "pusht_task/policy.hpp"
#include "pusht_task/rollout.hpp"
#include "pusht_task/simulator.hpp"
#include "sim2sim_eval/divergence.hpp"

namespace sim2sim {

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

/// Which episodes are run.
struct Protocol {
  std::uint64_t seed = 0;  ///< of the run; episode i starts from spawn seed 10000 + seed + i
  int first_episode = 0;   ///< index; the others follow it
  int episodes = 50;
  int horizon = pusht::kHorizon;  ///< [control steps]

  int lastEpisode() const { return first_episode + episodes - 1; }

  /// Throws InvalidInput with field, value and rule.
  void validate() const;

  /// Spawn seed of an episode: held out, no demonstration starts there.
  std::uint64_t spawnSeed(int episode) const;
};

/// `protocol` as short as the course's smoke run: 2 episodes of 40 control steps.
Protocol smokeRun(Protocol protocol);

struct RolloutResult {
  int steps = 0;
  bool success = false;  ///< whether success latched at any step
  pusht::PoseError final_error;
  std::optional<Divergence> mean_divergence;  ///< from the reference; none for the reference itself
};

struct EpisodeResult {
  int index = 0;
  std::uint64_t seed = 0;  ///< spawn seed
  std::array<RolloutResult, kModeCount> modes;
};

/// The worlds in which episodes run, one after the other.
struct Worlds {
  std::unique_ptr<pusht::Simulator> reference;
  std::unique_ptr<pusht::Simulator> engine;
  std::unique_ptr<pusht::Simulator> replay;  ///< another world of the engine
};

/// One episode: three rollouts from one start, advanced in lockstep.
class Episode {
 public:
  /// Resets the worlds, which are driven by this episode alone while it lasts. The policy only gives memories.
  /// Throws as advance() does.
  Episode(const Protocol& protocol, int index, const Worlds& worlds, const pusht::Policy& policy);

  int index() const { return index_; }
  const pusht::Rollout& rollout(Mode mode) const { return rollouts_[mode]; }

  /// Control steps taken, those of the rollout that has taken most.
  int steps() const;
  bool finished() const;

  /// Appends the queries of the rollouts that need an action of the policy now.
  void appendQueries(std::vector<pusht::Policy::Query>& queries) const;

  /// One control step of every rollout that goes on. `actions` holds the answers from `next` on, in the order
  /// of the queries; `next` moves past them. Throws the error of a world or BadDependency for an action that
  /// is not finite; its message begins with episode, mode and step.
  void advance(const std::vector<pusht::Action>& actions, std::size_t& next);

  /// The same where this is the only episode under way: asks `policy` itself.
  void advance(pusht::Policy& policy);

  EpisodeResult result() const;

 private:
  pusht::Rollout begin(Mode mode, pusht::Simulator& world, std::unique_ptr<pusht::Policy::Memory> memory) const;
  bool loopGoesOn(Mode mode) const;
  bool replayGoesOn() const;
  void advance(Mode mode, const pusht::Action& action);

  int index_;
  std::uint64_t seed_;
  int horizon_;
  std::array<pusht::Rollout, kModeCount> rollouts_;
};

/// Episodes in flight at once, so that the policy sees batches.
constexpr int kEpisodesInFlight = 8;

/// Runs the protocol. `policy` answers all rollouts in flight at once; `deliver` gets every episode when it has
/// finished, not in order; `stop` is asked before every control step and ends the run early when true.
/// Results do not depend on how many episodes are in flight.
void runProtocol(const Protocol& protocol, const std::function<Worlds()>& make_worlds, pusht::Policy& policy,
                 const std::function<void(const Episode&)>& deliver, const std::function<bool()>& stop);

}  // namespace sim2sim
