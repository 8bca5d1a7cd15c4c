// SPDX-License-Identifier: BSD-3-Clause
/// One world on its way through an episode.
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

/// A world, what the policy remembers of it, its success latch and its trace. In closed loop the caller
/// answers query() with the policy's action; in open loop it takes the actions of another trace.
class Rollout {
 public:
  /// Resets `world` to `start`. The world must outlive the rollout, and be driven by nothing else.
  Rollout(Simulator& world, const WorldState& start, std::unique_ptr<Policy::Memory> memory = nullptr);

  Policy::Query query() const { return {observe(trace_.states.back()), memory_.get()}; }

  /// One control step. Throws as Simulator::step does.
  void advance(const Action& action);

  /// Whether a closed loop ends here: success, or `horizon` control steps.
  bool finished(int horizon) const { return success() || steps() >= horizon; }

  int steps() const { return static_cast<int>(trace_.steps()); }
  bool success() const { return latch_.latched(); }
  PoseError error() const { return poseError(trace_.states.back()); }
  const Trace& trace() const { return trace_; }

 private:
  Simulator* world_;
  std::unique_ptr<Policy::Memory> memory_;
  SuccessLatch latch_;
  Trace trace_;
};

/// Drives `rollout` with `policy` until it is finished.
void runClosedLoop(Rollout& rollout, Policy& policy, int horizon);

}  // namespace pusht
