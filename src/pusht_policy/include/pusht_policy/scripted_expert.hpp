// SPDX-License-Identifier: BSD-3-Clause
/// Scripted expert: a hand-written controller that solves PushT from any spawn. It demonstrates for training.
#pragma once

#include <memory>

#include "pusht_task/policy.hpp"

namespace pusht {

/// Two-phase waypoint controller, which plans anew at every control step. It approaches a staging point behind the
/// point of the tee to be pushed, around the tee if need be, then pushes in a stroke. Its memory is whether a stroke is
/// under way.
class ScriptedExpert : public Policy {
 public:
  std::unique_ptr<Memory> begin(const Beginning& beginning) const override;
  void act(Span<const Query> queries, Span<Action> actions) override;
};

}  // namespace pusht
