// SPDX-License-Identifier: BSD-3-Clause
/// Starts and actions that put a world under load, for tests and benchmarks.
#pragma once

#include <cstdint>

#include "pusht_task/spawn.hpp"
#include "pusht_task/types.hpp"

namespace pusht::testing {

/// A spawn that moves and turns, as no episode starts but a world may be set to.
inline WorldState movingState(std::uint64_t seed) {
  NumpyGenerator generator(seed + 1'000'000);
  WorldState state = spawn(seed);
  for (double* velocity :
       {&state.pusher_velocity.x(), &state.pusher_velocity.y(), &state.tee_velocity.x(), &state.tee_velocity.y()}) {
    *velocity = generator.uniform(-0.5, 0.5);
  }
  state.tee_yaw_rate = generator.uniform(-3.0, 3.0);
  return state;
}

/// Drives the pusher at the tee and through it, so that there is contact: reaction, not memory.
inline Action chase(const WorldState& state) {
  const Eigen::Vector2d way = (state.tee_position - state.pusher_position).normalized();
  return {static_cast<float>(way.x()), static_cast<float>(way.y())};
}

}  // namespace pusht::testing
