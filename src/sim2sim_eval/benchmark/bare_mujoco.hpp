// SPDX-License-Identifier: BSD-3-Clause
/// Baseline for the cost of the reference: MuJoCo's own calls alone.
#pragma once

#include <mujoco/mujoco.h>

#include "pusht_task/constants.hpp"
#include "pusht_task/rollout.hpp"

namespace sim2sim {

/// Repeats the actions of `trace` from its initial state.
inline void stepBareMujoco(const mjModel& model, mjData& data, const pusht::Trace& trace) {
  const pusht::WorldState& start = trace.states.front();
  mj_resetData(&model, &data);
  data.qpos[0] = start.tee_position.x();
  data.qpos[1] = start.tee_position.y();
  data.qpos[2] = start.tee_yaw;
  data.qpos[3] = start.pusher_position.x();
  data.qpos[4] = start.pusher_position.y();
  mj_forward(&model, &data);
  for (const pusht::Action& action : trace.actions) {
    data.ctrl[0] = action[0];
    data.ctrl[1] = action[1];
    for (int i = 0; i < pusht::kSubstepsPerControlStep; ++i) {
      mj_step(&model, &data);
    }
  }
}

}  // namespace sim2sim
