// SPDX-License-Identifier: BSD-3-Clause
/// Scripted expert: a hand-written controller that solves PushT from any spawn. It demonstrates for training.
#pragma once

#include <memory>

#include "pusht_task/policy.hpp"
#include "pusht_task/task.hpp"

namespace pusht {

/// Two-phase waypoint controller, which plans anew at every control step. It approaches a staging point behind the
/// point of the tee to be pushed, around the tee if need be, then pushes in a stroke. Its memory is whether a stroke is
/// under way.
/// It was written for the course's task: in another one it sees the tee from the target, and is as exact as there.
class ScriptedExpert : public Policy {
 public:
  explicit ScriptedExpert(const Task& task = fullCircle()) : task_(&task) {}

  std::unique_ptr<Memory> begin(const Beginning& beginning) const override;
  void act(Span<const Query> queries, Span<Action> actions) override;

 private:
  const Task* task_;
};

}  // namespace pusht
