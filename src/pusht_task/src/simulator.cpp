// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/simulator.hpp"

#include <string>

#include "pusht_task/error.hpp"
#include "pusht_task/task.hpp"

namespace pusht {

void Simulator::reset(const WorldState& state) {
  if (!isFinite(state)) {
    throw InvalidInput("reset: every number of a world state must be finite");
  }
  ready_ = false;
  WorldState wrapped = state;
  wrapped.tee_yaw = wrapAngle(state.tee_yaw);
  doReset(wrapped);
  ready_ = true;
}

void Simulator::step(const Action& action) {
  if (!ready_) {
    throw InvalidInput("step: the world must be reset first");
  }
  if (!isFinite(action)) {
    throw InvalidInput("step: action (" + std::to_string(action[0]) + ", " + std::to_string(action[1]) +
                       ") must be finite");
  }
  ready_ = false;
  doStep(clip(action));
  if (!isFinite(state())) {
    throw RuntimeFault("step: the simulation left the finite numbers");
  }
  ready_ = true;
}

}  // namespace pusht
