// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_policy/scripted_expert.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/task.hpp"

namespace pusht {
namespace {

using Eigen::Vector2d;

// Units: m, m/s, rad, control steps.
constexpr double kDoneShare = 0.9;            // of both tolerances: inside, nothing is left to do
constexpr double kTranslateBeyond = 0.045;    // position error above which the tee is translated, not rotated
constexpr double kSideShiftPerRadian = 0.05;  // push line shifted sideways to turn the tee on its way
constexpr double kSideShiftMax = 0.022;
constexpr double kOutlineStep = 0.001;  // resolution of the search for the tee's outline
constexpr int kOutlineSteps = 200;
constexpr double kOutlineMin = 0.02;
constexpr double kTipInset = 0.012;  // where a bar tip is pushed, from its end
constexpr double kTranslateSpeed = 0.4;
constexpr double kRotateSpeed = 0.3;
constexpr double kStagingDistance = 0.05;  // behind the contact point
constexpr double kReach = 0.33;            // |x|, |y| of the pusher; beyond it the walls are near
constexpr double kApproachSpeedMax = 0.9;
constexpr double kApproachSpeedMin = 0.05;
constexpr double kApproachGain = 5.0;         // [1/s]
constexpr double kClearance = 0.11;           // from the tee's center of mass, on the way to the staging point
constexpr double kDetourBeyond = 0.115;       // farther than this the pusher takes the tangent, nearer it slides
constexpr double kTangentMargin = 1.15;       // of the tangent's angle
constexpr double kOutwardBias = 0.6;          // of the sliding heading
constexpr double kStrokeStartOffset = 0.012;  // sideways of the push line
constexpr double kStrokeStartNear = 0.01;     // behind the contact point
constexpr double kStrokeStartFar = 0.07;
constexpr double kStrokeEndOffset = 0.035;
constexpr int kStrokeSteps = 22;     // after the first one
constexpr double kOffsetGain = 4.0;  // [1/s]
constexpr double kOffsetSpeedMax = 0.3;

/// One expert's memory of a rollout: how much of the current stroke is left.
struct Stroke : Policy::Memory {
  std::optional<int> steps_left;  // none while approaching
};

Vector2d turnLeft(const Vector2d& v) { return {-v.y(), v.x()}; }

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

Vector2d clipNorm(const Vector2d& v, double limit) { return v.cwiseMax(-limit).cwiseMin(limit); }

/// The world as the expert reads it from an observation.
struct View {
  const Physics& physics;
  Vector2d pusher;
  Vector2d tee;
  double yaw;
  Eigen::Rotation2Dd rotation;  // tee frame to table frame
  Vector2d center_of_mass;

  /// View of the pusher at a point [m], and of the tee in a pose [m, rad], both from the target.
  View(Vector2d pusher_position, const Pose& pose, const Physics& of_task)
      : physics(of_task),
        pusher(std::move(pusher_position)),
        tee(pose.position),
        yaw(pose.yaw),
        rotation(yaw),
        center_of_mass(tee + rotation * Vector2d(0.0, -of_task.centerOfMass())) {}

  /// Whether a point of the table lies under the tee.
  bool covers(const Vector2d& point) const {
    const Vector2d body = rotation.inverse() * (point - tee);
    const bool in_bar = std::abs(body.x()) <= physics.bar_half_length && std::abs(body.y()) <= physics.bar_half_width;
    const bool in_stem = std::abs(body.x()) <= physics.stem_half_width &&
                         std::abs(body.y() + physics.stem_offset) <= physics.stem_half_length;
    return in_bar || in_stem;
  }
};

/// A push: the pusher's center starts at `contact` and moves along `direction`.
struct Push {
  Vector2d contact;
  Vector2d direction;
  double speed;

  /// Offset of the pusher from the push line, positive to its left [m].
  double sidewaysOffset(const Vector2d& pusher) const { return (pusher - contact).dot(turnLeft(direction)); }
  double distanceBehind(const Vector2d& pusher) const { return (contact - pusher).dot(direction); }
};

/// Push the center of mass to its goal, a little beside it so that the tee turns on its way.
Push planTranslation(const View& view) {
  const Vector2d goal(0.0, -view.physics.centerOfMass());
  const Vector2d direction = (goal - view.center_of_mass).normalized();
  const double shift = std::clamp(kSideShiftPerRadian * view.yaw, -kSideShiftMax, kSideShiftMax);
  const Vector2d through = view.center_of_mass + shift * turnLeft(direction);
  double outline = 0.0;
  for (int i = 0; i <= kOutlineSteps; ++i) {
    const double distance = i * kOutlineStep;
    if (view.covers(through - distance * direction)) {
      outline = distance;
    }
  }
  return {through - (std::max(outline, kOutlineMin) + view.physics.pusher_radius) * direction, direction,
          kTranslateSpeed};
}

/// Push the tip of the bar that is nearer, across the bar.
Push planRotation(const View& view) {
  const double turn = view.yaw > 0.0 ? 1.0 : -1.0;
  const Physics& physics = view.physics;
  const Vector2d tip(physics.bar_half_length - kTipInset, turn * (physics.bar_half_width + physics.pusher_radius));
  const Vector2d direction = view.rotation * Vector2d(0.0, -turn);
  const Push right = {view.tee + view.rotation * tip, direction, kRotateSpeed};
  const Push left = {view.tee - view.rotation * tip, -direction, kRotateSpeed};
  const bool right_is_nearer = (right.contact - view.pusher).norm() <= (left.contact - view.pusher).norm();
  return right_is_nearer ? right : left;
}

/// Heading around the tee, given the straight one to the staging point.
Vector2d detour(const View& view, const Vector2d& straight) {
  const Vector2d outward = view.pusher - view.center_of_mass;
  const double distance = outward.norm();
  const auto nearer = [&](const Vector2d& a, const Vector2d& b) { return a.dot(straight) >= b.dot(straight) ? a : b; };
  if (distance > kDetourBeyond) {
    const double angle = kTangentMargin * std::asin(kClearance / distance);
    const Vector2d inward = -outward / distance;
    return nearer(Eigen::Rotation2Dd(angle) * inward, Eigen::Rotation2Dd(-angle) * inward);
  }
  const Vector2d radial = outward / std::max(distance, 1e-9);
  const Vector2d tangent = turnLeft(radial);
  return (nearer(tangent, -tangent) + kOutwardBias * radial).normalized();
}

/// Heading without the component that leads further into a wall.
Vector2d awayFromWalls(const Vector2d& pusher, Vector2d heading) {
  for (int axis = 0; axis < 2; ++axis) {
    if (std::abs(pusher[axis]) > kReach && heading[axis] * pusher[axis] > 0.0) {
      heading[axis] = 0.0;
    }
  }
  return heading.norm() > 1e-9 ? heading.normalized() : (-pusher).normalized();
}

Vector2d approach(const View& view, const Push& push) {
  const Vector2d staging = clipNorm(push.contact - kStagingDistance * push.direction, kReach);
  const Vector2d way = staging - view.pusher;
  const double distance = way.norm();
  Vector2d heading = way / std::max(distance, 1e-9);
  const Vector2d to_tee = view.center_of_mass - view.pusher;
  const double along = to_tee.dot(heading);
  if (along > 0.0 && along < distance && std::abs(cross(heading, to_tee)) < kClearance) {
    heading = detour(view, heading);
  }
  const double speed = std::min(kApproachSpeedMax, kApproachGain * distance + kApproachSpeedMin);
  return speed * awayFromWalls(view.pusher, heading);
}

Vector2d strokeCommand(const View& view, const Push& push) {
  const double correction =
      std::clamp(-kOffsetGain * push.sidewaysOffset(view.pusher), -kOffsetSpeedMax, kOffsetSpeedMax);
  return push.speed * push.direction + correction * turnLeft(push.direction);
}

bool mayStart(const View& view, const Push& push) {
  const double behind = push.distanceBehind(view.pusher);
  return std::abs(push.sidewaysOffset(view.pusher)) < kStrokeStartOffset && behind > kStrokeStartNear &&
         behind < kStrokeStartFar;
}

bool mayContinue(const View& view, const Push& push, const Stroke& stroke) {
  return stroke.steps_left > 0 && std::abs(push.sidewaysOffset(view.pusher)) <= kStrokeEndOffset;
}

Vector2d command(const View& view, Stroke& stroke) {
  const PoseError error{view.tee.norm(), std::abs(view.yaw)};
  if (error.position < kDoneShare * kPositionTolerance && error.angle < kDoneShare * kAngleTolerance) {
    stroke.steps_left.reset();
    return Vector2d::Zero();
  }
  const Push push = error.position > kTranslateBeyond ? planTranslation(view) : planRotation(view);
  if (stroke.steps_left) {
    if (mayContinue(view, push, stroke)) {
      --*stroke.steps_left;
      return strokeCommand(view, push);
    }
    stroke.steps_left.reset();
  }
  if (mayStart(view, push)) {
    stroke.steps_left = kStrokeSteps;
    return strokeCommand(view, push);
  }
  return approach(view, push);
}

/// Pose that an observation has from its number `first` on, in the task's frame.
Pose poseIn(const Observation& o, std::size_t first) {
  return {{o[first], o[first + 1]}, std::atan2(static_cast<double>(o[first + 2]), static_cast<double>(o[first + 3]))};
}

Action answerTo(const Observation& observation, Stroke& stroke, const Task& task) {
  const Pose seen_tee = poseIn(observation, 2);
  const Vector2d seen_pusher(observation[0], observation[1]);
  if (&task == &fullCircle()) {  // the target is the table's origin: nothing turns, so that no bit is lost
    return actionFor(command(View(seen_pusher, seen_tee, task.physics), stroke), seen_pusher, task);
  }
  const Pose tee = task.frame.poseToTable(seen_tee);
  const Vector2d pusher = task.frame.pointToTable(seen_pusher);
  const Eigen::Rotation2Dd from_target(task.target.yaw);
  const auto seen_from_target = [&](const Vector2d& point) -> Vector2d {
    return from_target.inverse() * (point - task.target.position);
  };
  const View view(seen_from_target(pusher), {seen_from_target(tee.position), wrapAngle(tee.yaw - task.target.yaw)},
                  task.physics);
  return actionFor(from_target * command(view, stroke), pusher, task);
}

}  // namespace

std::unique_ptr<Policy::Memory> ScriptedExpert::begin(const Beginning& beginning) const {
  requireExecutable(beginning, 1);
  return std::make_unique<Stroke>();
}

void ScriptedExpert::act(Span<const Query> queries, Span<Action> actions) {
  for (std::size_t i = 0; i < queries.size(); ++i) {
    auto* stroke = dynamic_cast<Stroke*>(queries[i].memory);
    if (stroke == nullptr) {
      throw InternalError("scripted expert: a query must carry a memory from begin()");
    }
    actions[i] = answerTo(queries[i].observation, *stroke, *task_);
  }
}

}  // namespace pusht
