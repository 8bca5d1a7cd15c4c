// SPDX-License-Identifier: BSD-3-Clause
/// What a world does in an episode.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "pusht_task/policy.hpp"
#include "pusht_task/simulator.hpp"
#include "pusht_task/task.hpp"

namespace pusht {

/// What happened: states[k] is the world before actions[k]; one more state than actions.
struct Trace {
  std::vector<WorldState> states;
  std::vector<Action> actions;  ///< as applied, i.e. clipped

  std::size_t steps() const { return actions.size(); }
};

/// The record of a world on its way through an episode: its trace, its success latch and what the policy remembers
/// of it. Whoever steps the world records what it did. In closed loop the world is given the policy's answer to
/// query(); in open loop the actions of another trace.
class Rollout {
 public:
  /// `start` is the world's state after its reset.
  explicit Rollout(const WorldState& start, std::unique_ptr<Policy::Memory> memory = nullptr);

  /// One that took place before.
  explicit Rollout(const Trace& trace);

  Policy::Query query() const { return {observe(trace_.states.back()), memory_.get()}; }

  /// One control step: the world was given `action` and is in `state` now.
  void record(const Action& action, const WorldState& state);

  /// Whether a closed loop ends here: success, or `horizon` control steps.
  bool finished(int horizon) const { return success() || steps() >= horizon; }

  int steps() const { return static_cast<int>(trace_.steps()); }
  bool success() const { return latch_.latched(); }
  PoseError error() const { return poseError(trace_.states.back()); }
  const Trace& trace() const { return trace_; }

 private:
  std::unique_ptr<Policy::Memory> memory_;
  SuccessLatch latch_;
  Trace trace_;
};

/// Resets `world` to `start`.
Rollout begin(Simulator& world, const WorldState& start, std::unique_ptr<Policy::Memory> memory = nullptr);

/// Steps `world` and records it. Throws as Simulator::step does.
void advance(Rollout& rollout, Simulator& world, const Action& action);

/// Resets `world` to `start` and drives it with `policy` until the rollout is finished.
Rollout runClosedLoop(Simulator& world, const WorldState& start, Policy& policy, int horizon);

}  // namespace pusht
