// SPDX-License-Identifier: BSD-3-Clause
/// Rules of PushT: observation, limits of actions, distance of the tee from its target, success, reward. No physics.
#pragma once

#include "pusht_task/constants.hpp"
#include "pusht_task/types.hpp"

namespace pusht {

/// `action` with each axis clipped to [-1, 1] m/s.
Action clip(const Action& action);

/// Observation of `state` for a policy.
Observation observe(const WorldState& state);

/// Two bodies of the task that overlap, and how deep.
struct Overlap {
  const char* bodies = "";  ///< "pusher and tee", "pusher and walls", "tee and walls"
  double depth = 0.0;       ///< [m]; 0 or less: none overlap
};
/// The deepest overlap of a state.
Overlap deepestOverlap(const WorldState& state);

/// Distance of the tee from its target pose.
struct PoseError {
  double position = 0.0;  ///< [m]
  double angle = 0.0;     ///< [rad] in [0, pi]

  bool inTolerance() const { return position < kPositionTolerance && angle < kAngleTolerance; }
};
/// Distance of the tee from the target in position [m] and yaw [rad].
PoseError poseError(const WorldState& state);

/// Success: `kSuccessHold` consecutive control steps in tolerance. Once latched it stays.
class SuccessLatch {
 public:
  /// Takes the error after a control step. Returns true in the one step that latches.
  bool update(const PoseError& error);
  bool latched() const { return latched_; }

 private:
  int steps_in_tolerance_ = 0;
  bool latched_ = false;
};

/// Reward of a control step that ends with `error`; `just_latched` as returned by SuccessLatch::update.
double reward(const PoseError& error, bool just_latched);

}  // namespace pusht
