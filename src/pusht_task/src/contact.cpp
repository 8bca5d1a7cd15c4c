// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/contact.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"

namespace pusht {
namespace {

using Eigen::Vector2d;

/// Box of the tee, in the tee's frame [m].
struct Box {
  double center_y;
  double half_x;
  double half_y;

  Vector2d center() const { return {0.0, center_y}; }
  Vector2d half() const { return {half_x, half_y}; }
};

Box barOf(const Physics& physics) { return {0.0, physics.bar_half_length, physics.bar_half_width}; }

Box stemOf(const Physics& physics) { return {-physics.stem_offset, physics.stem_half_width, physics.stem_half_length}; }

Box boxOf(Part part, const Physics& physics) {
  switch (part) {
    case Part::kBar:
      return barOf(physics);
    case Part::kStem:
      return stemOf(physics);
    case Part::kNone:
    case Part::kCorner:
      break;
  }
  throw InternalError("slipDistance: the part must be bar or stem");
}

/// Point of a box's surface nearest to a given point, with its gap and normal.
struct Nearest {
  double distance;  // [m] below 0: the point is inside
  Vector2d point;
  Vector2d normal;  // outwards
};

/// Source: C. Ericson, "Real-Time Collision Detection" (2005), 5.1.3; inside, the nearest face.
Nearest nearest(const Box& box, const Vector2d& point) {
  const Vector2d from_center = point - box.center();
  const Vector2d inside = from_center.cwiseMax(-box.half()).cwiseMin(box.half());
  const Vector2d outwards = from_center - inside;
  if (!outwards.isZero(0.0)) {
    return {outwards.norm(), box.center() + inside, outwards.normalized()};
  }
  const Vector2d depth = box.half() - from_center.cwiseAbs();
  const Eigen::Index axis = depth.x() <= depth.y() ? 0 : 1;
  Vector2d normal = Vector2d::Zero();
  normal[axis] = from_center[axis] < 0.0 ? -1.0 : 1.0;
  return {-depth[axis], point + depth[axis] * normal, normal};
}

Eigen::Rotation2Dd teeToTable(const WorldState& state) { return Eigen::Rotation2Dd(state.tee_yaw); }

/// Point of a box nearest to the pusher, in the tee's frame.
Nearest nearestToPusher(const Box& box, const WorldState& state) {
  return nearest(box, teeToTable(state).inverse() * (state.pusher_position - state.tee_position));
}

Vector2d turnLeft(const Vector2d& v) { return {-v.y(), v.x()}; }

Contact contactWith(const Box& box, const WorldState& state, double pusher_radius) {
  const Nearest found = nearestToPusher(box, state);
  const Eigen::Rotation2Dd rotation = teeToTable(state);
  const Vector2d arm = rotation * found.point;
  const Vector2d normal = rotation * found.normal;
  const Vector2d tee_velocity = state.tee_velocity + state.tee_yaw_rate * turnLeft(arm);
  return {found.distance - pusher_radius, state.tee_position + arm, normal,
          turnLeft(normal).dot(state.pusher_velocity - tee_velocity)};
}

/// The corners of the tee's convex hull, in its frame [m]: those of the bar, and the two at the stem's end.
std::array<Vector2d, 6> teeCorners(const Physics& physics) {
  const double end = -physics.stem_offset - physics.stem_half_length;
  return {Vector2d(physics.bar_half_length, physics.bar_half_width),
          Vector2d(-physics.bar_half_length, physics.bar_half_width),
          Vector2d(physics.bar_half_length, -physics.bar_half_width),
          Vector2d(-physics.bar_half_length, -physics.bar_half_width),
          Vector2d(physics.stem_half_width, end),
          Vector2d(-physics.stem_half_width, end)};
}

}  // namespace

Part common(Part a, Part b) {
  if (a == b || b == Part::kCorner) {
    return a;
  }
  return a == Part::kCorner ? b : Part::kNone;
}

Part Contacts::part() const {
  if (bar.touches()) {
    return stem.touches() ? Part::kCorner : Part::kBar;
  }
  return stem.touches() ? Part::kStem : Part::kNone;
}

Contacts contactsOf(const WorldState& state, const Task& task) {
  const Physics& physics = task.physics;
  return {contactWith(barOf(physics), state, physics.pusher_radius),
          contactWith(stemOf(physics), state, physics.pusher_radius)};
}

double slipDistance(const WorldState& before, const WorldState& after, Part part, const Task& task) {
  const Box box = boxOf(part, task.physics);
  const Nearest from = nearestToPusher(box, before);
  const Nearest to = nearestToPusher(box, after);
  const Vector2d way = to.point - from.point;  // straight: a step goes round a corner of the box at most
  const double along = std::copysign(way.norm(), way.dot(turnLeft(from.normal + to.normal)));
  const auto direction = [](const WorldState& state, const Nearest& found) {
    return std::atan2(found.normal.y(), found.normal.x()) + state.tee_yaw;
  };
  return along + task.physics.pusher_radius * wrapAngle(direction(after, to) - direction(before, from));
}

WallGaps wallGapsOf(const WorldState& state, const Task& task) {
  const Physics& physics = task.physics;
  WallGaps gaps{physics.wall_inner_face - physics.pusher_radius - reachOf(state.pusher_position, physics),
                physics.wall_inner_face};
  const Eigen::Rotation2Dd rotation = teeToTable(state);
  for (const Vector2d& corner : teeCorners(physics)) {
    const Vector2d at = state.tee_position + rotation * corner;
    gaps.tee = std::min(gaps.tee, physics.wall_inner_face - reachOf(at, physics));
  }
  return gaps;
}

}  // namespace pusht
