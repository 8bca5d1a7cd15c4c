// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/task.hpp"

#include <algorithm>
#include <cmath>

namespace pusht {

Action clip(const Action& action) {
  return {std::clamp(action[0], -kActionLimit, kActionLimit), std::clamp(action[1], -kActionLimit, kActionLimit)};
}

Observation observe(const WorldState& state) {
  constexpr std::array<float, 4> kTarget = {0.0F, 0.0F, 0.0F, 1.0F};  // x, y, sin, cos of the target pose
  return {static_cast<float>(state.pusher_position.x()),
          static_cast<float>(state.pusher_position.y()),
          static_cast<float>(state.tee_position.x()),
          static_cast<float>(state.tee_position.y()),
          static_cast<float>(std::sin(state.tee_yaw)),
          static_cast<float>(std::cos(state.tee_yaw)),
          kTarget[0],
          kTarget[1],
          kTarget[2],
          kTarget[3]};
}

PoseError poseError(const WorldState& state) { return {state.tee_position.norm(), std::abs(wrapAngle(state.tee_yaw))}; }

bool SuccessLatch::update(const PoseError& error) {
  steps_in_tolerance_ = error.inTolerance() ? steps_in_tolerance_ + 1 : 0;
  if (latched_ || steps_in_tolerance_ < kSuccessHold) {
    return false;
  }
  latched_ = true;
  return true;
}

double reward(const PoseError& error, bool just_latched) {
  const double shaping = -0.5 * (error.position / kRewardPositionScale + error.angle / kPi);
  return just_latched ? shaping + kRewardBonus : shaping;
}

}  // namespace pusht
