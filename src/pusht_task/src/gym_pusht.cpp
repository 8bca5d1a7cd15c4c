// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/gym_pusht.hpp"

#include <Eigen/Geometry>

#include "pusht_task/constants.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/task.hpp"

namespace pusht::gym_pusht {
namespace {

using Eigen::Vector2d;

/// [px] Vector to a point of the axis of a tee that is turned by `angle`.
Vector2d armTo(double point, double angle) { return Eigen::Rotation2Dd(angle) * Vector2d(0.0, point); }

Vector2d perpendicular(const Vector2d& arm) { return {-arm.y(), arm.x()}; }

}  // namespace

WorldState toTable(const State& state, double center_of_gravity) {
  const TaskFrame& frame = gymPusht().frame;
  const Pose tee = frame.poseToTable({state.tee, state.angle});
  const Vector2d arm = armTo(kBarCenter - center_of_gravity, state.angle);
  WorldState table;
  table.pusher_position = frame.pointToTable(state.pusher);
  table.pusher_velocity = frame.vectorToTable(state.pusher_velocity);
  table.tee_position = tee.position;
  table.tee_velocity = frame.vectorToTable(state.tee_velocity + state.rate * perpendicular(arm));
  table.tee_yaw = tee.yaw;
  table.tee_yaw_rate = -state.rate;
  return table;
}

State fromTable(const WorldState& table, double center_of_gravity) {
  const TaskFrame& frame = gymPusht().frame;
  const Pose tee = frame.poseFromTable({table.tee_position, table.tee_yaw});
  const Vector2d arm = armTo(kBarCenter - center_of_gravity, tee.yaw);
  State state;
  state.pusher = frame.pointFromTable(table.pusher_position);
  state.pusher_velocity = frame.vectorFromTable(table.pusher_velocity);
  state.tee = tee.position;
  state.angle = tee.yaw;
  state.rate = -table.tee_yaw_rate;
  state.tee_velocity = frame.vectorFromTable(table.tee_velocity) - state.rate * perpendicular(arm);
  return state;
}

State drawn(std::uint32_t seed) {
  NumpyRandomState random(seed);
  const auto point = [&random](int low, int high) {
    const double x = random.randint(low, high);
    const double y = random.randint(low, high);
    return Vector2d(x, y);
  };
  State state;
  state.pusher = point(50, 450);
  state.tee = point(100, 400);
  state.angle = random.randn() * 2.0 * kPi - kPi;
  return state;
}

State turned(const State& asked, double center_of_gravity) {
  State state = asked;
  state.tee = asked.tee + Vector2d(0.0, center_of_gravity) - armTo(center_of_gravity, asked.angle);
  return state;
}

}  // namespace pusht::gym_pusht
