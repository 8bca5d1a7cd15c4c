// SPDX-License-Identifier: BSD-3-Clause
#include "planning_expert.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/task.hpp"
#include "stroke_planner.hpp"

namespace pusht {
namespace {

using Eigen::Vector2d;

constexpr double kWandering = 0.1;  // [m] per axis from the walls' middle, of a pusher that reaches no stroke

/// State that a task's observation shows, all at rest.
WorldState stateIn(const Observation& o, const Task& task) {
  const Pose tee =
      task.frame.poseToTable({{o[2], o[3]}, std::atan2(static_cast<double>(o[4]), static_cast<double>(o[5]))});
  WorldState state;
  state.pusher_position = task.frame.pointToTable({o[0], o[1]});
  state.tee_position = tee.position;
  state.tee_yaw = tee.yaw;
  return state;
}

/// Point near the walls' middle.
Vector2d somewhere(const Task& task, NumpyGenerator& random) {
  const auto [x, y] = task.physics.wall_middle;
  const double right = random.uniform(-kWandering, kWandering);
  const double up = random.uniform(-kWandering, kWandering);
  return {x + right, y + up};
}

}  // namespace

/// Rest of a stroke.
struct PlanningExpert::Stroke : Policy::Memory {
  explicit Stroke(std::uint64_t seed) : random(seed, "planning expert") {}

  NumpyGenerator random;
  std::vector<Vector2d> references;           // [m] for each control step of it
  std::size_t done = 0;                       // of them
  Vector2d last_velocity = Vector2d::Zero();  // [m/s] of the pusher at its end, as planned
};

PlanningExpert::PlanningExpert(std::unique_ptr<Simulator> world)
    : planner_(std::make_unique<StrokePlanner>(std::move(world))) {}

PlanningExpert::~PlanningExpert() = default;

std::unique_ptr<Policy::Memory> PlanningExpert::begin(const Beginning& beginning) const {
  requireExecutable(beginning, 1);
  return std::make_unique<Stroke>(beginning.seed);
}

void PlanningExpert::act(Span<const Query> queries, Span<Action> actions) {
  for (std::size_t i = 0; i < queries.size(); ++i) {
    auto* stroke = dynamic_cast<Stroke*>(queries[i].memory);
    if (stroke == nullptr) {
      throw InternalError("planning expert: a query must carry a memory from begin()");
    }
    actions[i] = answerTo(queries[i].observation, *stroke);
  }
}

Action PlanningExpert::answerTo(const Observation& observation, Stroke& stroke) {
  WorldState state = stateIn(observation, planner_->task());
  if (stroke.done == stroke.references.size()) {
    state.pusher_velocity = stroke.last_velocity;
    planNext(state, stroke);
  }
  return actionToward(stroke.references[stroke.done++], state.pusher_position, planner_->task());
}

/// Plans for one control step at least: it stays where the task is solved, and wanders where there is no stroke.
void PlanningExpert::planNext(const WorldState& state, Stroke& stroke) {
  stroke.done = 0;
  stroke.last_velocity.setZero();
  if (isSolved(state, planner_->task())) {
    stroke.references = {state.pusher_position};
  } else if (std::optional<Plan> plan = planner_->plan(state, stroke.random)) {
    stroke.references = std::move(plan->references);
    stroke.last_velocity = plan->end.pusher_velocity;
  } else {
    stroke.references = {somewhere(planner_->task(), stroke.random)};
  }
}

}  // namespace pusht
