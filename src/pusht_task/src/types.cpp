// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/types.hpp"

#include <cmath>

#include "pusht_task/constants.hpp"

namespace pusht {

bool operator==(const WorldState& a, const WorldState& b) {
  return a.pusher_position == b.pusher_position && a.pusher_velocity == b.pusher_velocity &&
         a.tee_position == b.tee_position && a.tee_velocity == b.tee_velocity && a.tee_yaw == b.tee_yaw &&
         a.tee_yaw_rate == b.tee_yaw_rate;
}

bool operator!=(const WorldState& a, const WorldState& b) { return !(a == b); }

bool isFinite(const WorldState& state) {
  return state.pusher_position.allFinite() && state.pusher_velocity.allFinite() && state.tee_position.allFinite() &&
         state.tee_velocity.allFinite() && std::isfinite(state.tee_yaw) && std::isfinite(state.tee_yaw_rate);
}

bool isFinite(const Action& action) { return std::isfinite(action[0]) && std::isfinite(action[1]); }

double wrapAngle(double angle) {
  if (angle >= -kPi && angle < kPi) {
    return angle;
  }
  const double wrapped = std::remainder(angle, 2.0 * kPi);  // exact, in [-pi, pi]
  return wrapped < kPi ? wrapped : -kPi;
}

}  // namespace pusht
