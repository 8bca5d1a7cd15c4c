// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/simulator.hpp"

#include <string>

#include "pusht_task/error.hpp"
#include "pusht_task/task.hpp"

namespace pusht {

WorldState checkedStart(const WorldState& state) {
  if (!isFinite(state)) {
    throw InvalidInput("reset: every number of a world state must be finite");
  }
  WorldState wrapped = state;
  wrapped.tee_yaw = wrapAngle(state.tee_yaw);
  return wrapped;
}

Action checkedAction(const Action& action) {
  if (!isFinite(action)) {
    throw InvalidInput("step: action (" + std::to_string(action[0]) + ", " + std::to_string(action[1]) +
                       ") must be finite");
  }
  return clip(action);
}

void requireFiniteStep(const WorldState& state) {
  if (!isFinite(state)) {
    throw SimulationFault("step: the simulation left the finite numbers");
  }
}

void Simulator::reset(const WorldState& state) {
  const WorldState start = checkedStart(state);
  ready_ = false;
  doReset(start);
  ready_ = true;
}

void Simulator::step(const Action& action) {
  if (!ready_) {
    throw InvalidInput("step: the world must be reset first");
  }
  const Action clipped = checkedAction(action);
  ready_ = false;
  doStep(clipped);
  requireFiniteStep(state());
  ready_ = true;
}

}  // namespace pusht
