// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/task.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "pusht_task/mapping.hpp"
#include "pusht_task/numbers.hpp"

namespace pusht {
namespace {

using Eigen::Vector2d;

/// Distance [m] of a point from a box of these half-sizes around the origin; negative within.
double signedDistance(const Vector2d& point, const Vector2d& half) {
  const Vector2d beyond = point.cwiseAbs() - half;
  return beyond.cwiseMax(0.0).norm() + std::min(0.0, beyond.maxCoeff());
}

}  // namespace

bool TaskFrame::isTables() const { return per_meter == 1.0 && middle.isZero(0.0) && !y_down && bar_center == 0.0; }

Vector2d TaskFrame::flipped(const Vector2d& vector) const {
  return y_down ? Vector2d(vector.x(), -vector.y()) : vector;
}

Vector2d TaskFrame::vectorToTable(const Vector2d& vector) const { return flipped(vector) / per_meter; }

Vector2d TaskFrame::vectorFromTable(const Vector2d& vector) const { return per_meter * flipped(vector); }

Vector2d TaskFrame::pointToTable(const Vector2d& point) const { return vectorToTable(point - middle); }

Vector2d TaskFrame::pointFromTable(const Vector2d& point) const {
  return isTables() ? point : Vector2d(vectorFromTable(point) + middle);  // the former keeps -0
}

// The stem lies along -y of the tee in the table frame, and so along +y where y is down.

Pose TaskFrame::poseToTable(const Pose& pose) const {
  const double yaw = y_down ? -pose.yaw : pose.yaw;
  const Vector2d arm = Eigen::Rotation2Dd(yaw) * Vector2d(0.0, -bar_center / per_meter);
  return {pointToTable(pose.position) + arm, wrapAngle(yaw)};
}

Pose TaskFrame::poseFromTable(const Pose& pose) const {
  if (isTables()) {
    return pose;
  }
  const Vector2d arm = Eigen::Rotation2Dd(pose.yaw) * Vector2d(0.0, -bar_center / per_meter);
  return {pointFromTable(pose.position - arm), y_down ? -pose.yaw : pose.yaw};
}

Action clip(const Action& action, const Task& task) {
  if (!task.action_limit) {
    return action;
  }
  const float limit = *task.action_limit;
  return {std::clamp(action[0], -limit, limit), std::clamp(action[1], -limit, limit)};
}

Vector2d commandOf(const Action& action, const Task& task) {
  const Vector2d command(action[0], action[1]);
  return task.physics.drive == Drive::kPosition ? task.frame.pointToTable(command) : command;
}

double actionPerSpeed(const Task& task) {
  const bool is_velocity = task.physics.drive == Drive::kVelocity;
  return is_velocity ? 1.0 : task.frame.per_meter * task.physics.servo_gain / task.physics.servo_stiffness;
}

Action actionFor(const Vector2d& velocity, const Vector2d& position, const Task& task) {
  Vector2d action = velocity;
  if (task.physics.drive == Drive::kPosition) {
    const double lead = task.physics.servo_gain / task.physics.servo_stiffness;  // [s]
    action = task.frame.pointFromTable(position + lead * velocity);
  }
  return clip({static_cast<float>(action.x()), static_cast<float>(action.y())}, task);
}

Observation observe(const WorldState& state, const Task& task) {
  const Vector2d pusher = task.frame.pointFromTable(state.pusher_position);
  const Pose tee = task.frame.poseFromTable({state.tee_position, state.tee_yaw});
  const Pose target = task.frame.poseFromTable(task.target);
  return {static_cast<float>(pusher.x()),           static_cast<float>(pusher.y()),
          static_cast<float>(tee.position.x()),     static_cast<float>(tee.position.y()),
          static_cast<float>(std::sin(tee.yaw)),    static_cast<float>(std::cos(tee.yaw)),
          static_cast<float>(target.position.x()),  static_cast<float>(target.position.y()),
          static_cast<float>(std::sin(target.yaw)), static_cast<float>(std::cos(target.yaw))};
}

double reachOf(const Vector2d& point, const Physics& physics) {
  return (point - Vector2d(physics.wall_middle[0], physics.wall_middle[1])).lpNorm<Eigen::Infinity>();
}

Overlap deepestOverlap(const WorldState& state, const Task& task) {
  const Physics& physics = task.physics;
  const Eigen::Rotation2Dd yaw(state.tee_yaw);
  const Vector2d pusher = yaw.inverse() * (state.pusher_position - state.tee_position);
  Overlap deepest{"pusher and walls",
                  reachOf(state.pusher_position, physics) + physics.pusher_radius - physics.wall_inner_face};
  const auto take = [&](const char* bodies, double depth) {
    if (depth > deepest.depth) {
      deepest = {bodies, depth};
    }
  };
  for (const PlacedBox& part : teeBoxes(physics)) {
    const Vector2d center(part.x, part.y);
    const Vector2d half(part.half_x, part.half_y);
    take("pusher and tee", physics.pusher_radius - signedDistance(pusher - center, half));
    for (const double x : {-1.0, 1.0}) {
      for (const double y : {-1.0, 1.0}) {
        const Vector2d corner = center + Vector2d(x, y).cwiseProduct(half);
        take("tee and walls", reachOf(state.tee_position + yaw * corner, physics) - physics.wall_inner_face);
      }
    }
  }
  return deepest;
}

PoseError poseError(const WorldState& state, const Task& task) {
  return {(state.tee_position - task.target.position).norm(), std::abs(wrapAngle(state.tee_yaw - task.target.yaw))};
}

WorldState stateAtTarget(const Task& task) {
  WorldState state;
  state.tee_position = task.target.position;
  state.tee_yaw = task.target.yaw;
  state.pusher_position = {task.physics.wall_middle[0], task.physics.wall_middle[1]};
  return state;
}

double coverageOf(const WorldState& state, const Task& task) {
  return coverageOf({state.tee_position, state.tee_yaw}, task.target, task.physics);
}

std::string distanceText(const WorldState& state, const Task& task) {
  if (task.success.coverage) {
    return "covers " + fixedText(coverageOf(state, task), 2);
  }
  const PoseError error = poseError(state, task);
  return fixedText(error.position, 3) + " m, " + fixedText(error.angle, 2) + " rad off";
}

bool isSolved(const WorldState& state, const Task& task) {
  const SuccessRule& rule = task.success;
  if (rule.coverage) {
    return coverageOf(state, task) > *rule.coverage;
  }
  const PoseError error = poseError(state, task);
  return error.position < rule.position_tolerance && error.angle < rule.angle_tolerance;
}

bool SuccessLatch::update(const WorldState& state) {
  steps_solved_ = isSolved(state, *task_) ? steps_solved_ + 1 : 0;
  if (latched_ || steps_solved_ < task_->success.hold) {
    return false;
  }
  latched_ = true;
  return true;
}

double reward(const WorldState& state, bool just_latched, const Task& task) {
  if (const std::optional<double> needed = task.success.coverage) {
    return std::min(coverageOf(state, task) / *needed, 1.0);
  }
  const PoseError error = poseError(state, task);
  const double shaping = -0.5 * (error.position / kRewardPositionScale + error.angle / kPi);
  return just_latched ? shaping + kRewardBonus : shaping;
}

}  // namespace pusht
