// SPDX-License-Identifier: BSD-3-Clause
/// Rollout: the record of a world in an episode.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "pusht_task/policy.hpp"
#include "pusht_task/simulator.hpp"
#include "pusht_task/task.hpp"

namespace pusht {

/// Trace: states[k] is the world before actions[k]; there is one more state than actions.
struct Trace {
  std::vector<WorldState> states;
  std::vector<Action> actions;  ///< applied, hence clipped, in the task's unit

  std::size_t steps() const { return actions.size(); }
};

/// Record of a world on its way through an episode: trace, success latch, and the policy's memory. The caller steps the
/// world and records each step. In closed loop it takes the policy's action for query(); in open loop, the actions of
/// another trace.
class Rollout {
 public:
  /// `start` is the state of the world after its reset. `task` must outlive it.
  explicit Rollout(const WorldState& start, std::unique_ptr<Policy::Memory> memory = nullptr,
                   const Task& task = fullCircle());

  /// Rollout that took place before, from its trace.
  explicit Rollout(const Trace& trace, const Task& task = fullCircle());

  Policy::Query query() const { return {observe(trace_.states.back(), *task_), memory_.get(), &trace_.states.back()}; }

  /// Records a control step: `action`, clipped here as the world clipped it, and the state after it.
  void record(const Action& action, const WorldState& state);

  /// Whether a closed loop ends here: success, or `horizon` control steps.
  bool finished(int horizon) const { return success() || steps() >= horizon; }

  int steps() const { return static_cast<int>(trace_.steps()); }
  bool success() const { return latch_.latched(); }
  PoseError error() const { return poseError(trace_.states.back(), *task_); }
  /// Whether the last state counts as solved.
  bool solved() const { return isSolved(trace_.states.back(), *task_); }
  const Task& task() const { return *task_; }
  const Trace& trace() const { return trace_; }

 private:
  const Task* task_;
  std::unique_ptr<Policy::Memory> memory_;
  SuccessLatch latch_;
  Trace trace_;
};

/// Resets `world` to `start`. The rollout has the world's task.
Rollout begin(Simulator& world, const WorldState& start, std::unique_ptr<Policy::Memory> memory = nullptr);

/// Steps `world` and records it. Throws as Simulator::step does.
void advance(Rollout& rollout, Simulator& world, const Action& action);

/// Resets `world` to `start` and drives it with `policy` until the rollout is finished. The policy begins with seed 0,
/// in the role of the reference.
Rollout runClosedLoop(Simulator& world, const WorldState& start, Policy& policy, int horizon);

}  // namespace pusht
