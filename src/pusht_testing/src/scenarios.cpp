// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_testing/scenarios.hpp"

#include "pusht_task/constants.hpp"
#include "pusht_task/spawn.hpp"

namespace pusht::testing {

WorldState movingState(std::uint64_t seed) {
  NumpyGenerator generator(seed + 1'000'000);
  WorldState state = spawn(seed);
  for (double* velocity :
       {&state.pusher_velocity.x(), &state.pusher_velocity.y(), &state.tee_velocity.x(), &state.tee_velocity.y()}) {
    *velocity = generator.uniform(-0.5, 0.5);
  }
  state.tee_yaw_rate = generator.uniform(-3.0, 3.0);
  return state;
}

std::vector<WorldState> absurdStates() {
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

std::array<WorldState, 4> statesBeyondWhatIsPlausible() {
  std::array<WorldState, 4> beyond = {spawn(3), spawn(3), spawn(3), spawn(3)};
  beyond[0].tee_position.x() = 1e11;
  beyond[1].pusher_velocity.y() = -1e11;
  beyond[2].tee_velocity.x() = 1e308;
  beyond[3].tee_yaw_rate = 1e11;
  return beyond;
}

Action chase(const WorldState& state, const Task& task) {
  return actionFor((state.tee_position - state.pusher_position).normalized(), state.pusher_position, task);
}

Action mixedAction(const WorldState& state, std::size_t world, int step) {
  if (step % 17 == 16) {
    return {0.0F, 0.0F};
  }
  return world % 4 == 3 ? Action{-1.0F, 0.25F} : chase(state);
}

}  // namespace pusht::testing
