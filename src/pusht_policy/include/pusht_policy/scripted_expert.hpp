// SPDX-License-Identifier: BSD-3-Clause
/// The demonstrator: a hand-written controller that solves PushT from any spawn.
#pragma once

#include <memory>

#include "pusht_task/policy.hpp"

namespace pusht {

/// A two-phase waypoint controller, planned anew at every control step. It approaches a staging point
/// behind the place where the tee should be pushed, around the tee if need be, then pushes in a stroke.
class ScriptedExpert : public Policy {
 public:
  std::unique_ptr<Memory> begin() const override;
  void act(Span<const Query> queries, Span<Action> actions) override;
};

}  // namespace pusht
