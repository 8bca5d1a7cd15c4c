// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/rollout.hpp"

#include <utility>

namespace pusht {

Rollout::Rollout(const WorldState& start, std::unique_ptr<Policy::Memory> memory, const Task& task)
    : task_(&task), memory_(std::move(memory)), latch_(task) {
  trace_.states.reserve(kHorizon + 1);
  trace_.actions.reserve(kHorizon);
  trace_.states.push_back(start);
}

Rollout::Rollout(const Trace& trace, const Task& task) : Rollout(trace.states.front(), nullptr, task) {
  for (std::size_t step = 0; step < trace.steps(); ++step) {
    record(trace.actions[step], trace.states[step + 1]);
  }
}

void Rollout::record(const Action& action, const WorldState& state) {
  trace_.actions.push_back(clip(action, *task_));
  trace_.states.push_back(state);
  latch_.update(state);
}

Rollout begin(Simulator& world, const WorldState& start, std::unique_ptr<Policy::Memory> memory) {
  world.reset(start);
  return Rollout(world.state(), std::move(memory), world.task());
}

void advance(Rollout& rollout, Simulator& world, const Action& action) {
  world.step(action);
  rollout.record(action, world.state());
}

Rollout runClosedLoop(Simulator& world, const WorldState& start, Policy& policy, int horizon) {
  Rollout rollout = begin(world, start, policy.begin({}));
  while (!rollout.finished(horizon)) {
    const Policy::Query query = rollout.query();
    Action action{};
    policy.act({&query, 1}, {&action, 1});
    advance(rollout, world, action);
  }
  return rollout;
}

}  // namespace pusht
