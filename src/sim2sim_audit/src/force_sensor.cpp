// SPDX-License-Identifier: BSD-3-Clause
#include "force_sensor.hpp"

#include "pusht_task/constants.hpp"

namespace sim2sim {

Eigen::Vector2d ForceSensor::impulse(const pusht::WorldState& from, const pusht::WorldState& to,
                                     const Eigen::Vector2d& command) const {
  return pusht::kControlStep * scale_.cwiseProduct(command) - damping_ * (to.pusher_position - from.pusher_position) -
         mass_ * (to.pusher_velocity - from.pusher_velocity);
}

}  // namespace sim2sim
