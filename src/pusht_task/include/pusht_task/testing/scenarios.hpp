// SPDX-License-Identifier: BSD-3-Clause
/// Starts and actions that put a world under load, for tests and benchmarks.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pusht_task/constants.hpp"
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

/// Starts that are allowed, and that no simulation can make sense of: too fast for a table, one body inside the other,
/// in walls and far beyond them.
inline std::vector<WorldState> absurdStates() {
  WorldState fast = spawn(3);
  fast.tee_velocity.x() = kPlausibleSpeed;
  fast.pusher_velocity.y() = -kPlausibleSpeed;
  fast.tee_yaw_rate = kPlausibleYawRate;
  WorldState overlapping = spawn(3);
  overlapping.pusher_position = overlapping.tee_position;
  std::vector<WorldState> states = {fast, overlapping};
  for (const double place : {1e-30, kWallInnerFace, 0.41, 7.9, 0.999 * kPlausibleDistance}) {  // [m]
    for (const double speed : {1e-30, 60.0, 199.0, kPlausibleSpeed}) {                         // [m/s]
      WorldState state;
      state.pusher_position = {place, -place};
      state.tee_position = {-place, 0.5 * place};
      state.pusher_velocity = {-speed, speed};
      state.tee_velocity = {speed, 0.0};
      state.tee_yaw = 3.0;
      state.tee_yaw_rate = 0.3 * speed;
      states.push_back(state);
    }
  }
  return states;
}

/// Starts that are not allowed.
inline std::array<WorldState, 4> statesBeyondWhatIsPlausible() {
  std::array<WorldState, 4> beyond = {spawn(3), spawn(3), spawn(3), spawn(3)};
  beyond[0].tee_position.x() = 1e11;
  beyond[1].pusher_velocity.y() = -1e11;
  beyond[2].tee_velocity.x() = 1e308;
  beyond[3].tee_yaw_rate = 1e11;
  return beyond;
}

/// Drives the pusher at the tee and through it, so that there is contact: reaction, not memory.
inline Action chase(const WorldState& state) {
  const Eigen::Vector2d way = (state.tee_position - state.pusher_position).normalized();
  return {static_cast<float>(way.x()), static_cast<float>(way.y())};
}

/// Actions for the worlds of a batch: most chase, so that contacts come and go; every fourth pushes straight on, and
/// now and then the pusher is told to stand still.
inline Action mixedAction(const WorldState& state, std::size_t world, int step) {
  if (step % 17 == 16) {
    return {0.0F, 0.0F};
  }
  return world % 4 == 3 ? Action{-1.0F, 0.25F} : chase(state);
}

}  // namespace pusht::testing
