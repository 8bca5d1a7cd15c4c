// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/rollout.hpp"

#include <utility>

namespace pusht {

Rollout::Rollout(Simulator& world, const WorldState& start, std::unique_ptr<Policy::Memory> memory)
    : world_(&world), memory_(std::move(memory)) {
  trace_.states.reserve(kHorizon + 1);
  trace_.actions.reserve(kHorizon);
  world_->reset(start);
  trace_.states.push_back(world_->state());
}

void Rollout::advance(const Action& action) {
  world_->step(action);
  trace_.actions.push_back(clip(action));
  trace_.states.push_back(world_->state());
  latch_.update(error());
}

void runClosedLoop(Rollout& rollout, Policy& policy, int horizon) {
  while (!rollout.finished(horizon)) {
    const Policy::Query query = rollout.query();
    Action action{};
    policy.act({&query, 1}, {&action, 1});
    rollout.advance(action);
  }
}

}  // namespace pusht
