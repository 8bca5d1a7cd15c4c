// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/ending.hpp"

#include <algorithm>
#include <vector>

#include "pusht_task/task.hpp"
#include "sim2sim_protocol/divergence.hpp"
#include "sim2sim_protocol/first_divergence.hpp"

namespace sim2sim {
namespace {

using pusht::WorldState;

bool isBeyondWalls(const Eigen::Vector2d& point, const pusht::Task& task) {
  return pusht::reachOf(point, task.physics) > task.physics.wall_inner_face;
}

/// First step from which on every state is as the last one, in the sense of `is_as`.
template <class IsAs>
int firstStepAs(const std::vector<WorldState>& states, const IsAs& is_as) {
  const auto other = std::find_if_not(states.rbegin(), states.rend(),
                                      [&](const WorldState& state) { return is_as(state, states.back()); });
  return static_cast<int>(states.rend() - other);
}

bool isTeeAs(const WorldState& a, const WorldState& b) { return kNoticeable.used(divergence(a, b)) <= 1.0; }

bool isPusherAs(const WorldState& a, const WorldState& b) {
  return (a.pusher_position - b.pusher_position).norm() <= kNoticeable.position;
}

}  // namespace

RolloutEnding endingOf(const pusht::Rollout& rollout) {
  const std::vector<WorldState>& states = rollout.trace().states;
  const int still_step = firstStepAs(states, isTeeAs);
  const auto is_still = [&](int step) { return rollout.steps() - step >= kStillSteps; };
  const Ending ending = rollout.success()                           ? Ending::kSuccess
                        : isOffTable(states.back(), rollout.task()) ? Ending::kLost
                        : is_still(still_step)                      ? Ending::kStuck
                                                                    : Ending::kMoving;
  const PusherEnding pusher = isBeyondWalls(states.back().pusher_position, rollout.task()) ? PusherEnding::kLost
                              : is_still(firstStepAs(states, isPusherAs))                  ? PusherEnding::kStill
                                                                                           : PusherEnding::kMoving;
  return {ending, still_step, pusher};
}

bool isOffTable(const WorldState& state, const pusht::Task& task) { return isBeyondWalls(state.tee_position, task); }

}  // namespace sim2sim
