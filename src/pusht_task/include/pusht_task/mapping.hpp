// SPDX-License-Identifier: BSD-3-Clause
/// The task's physics in the terms of an engine by others, which has rigid bodies, boxes and forces that are constant
/// in a substep.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "pusht_task/constants.hpp"
#include "pusht_task/physics.hpp"
#include "pusht_task/types.hpp"

namespace pusht {

// In the reference, servo and damping act at the velocity at a substep's end (implicit). With a force F - D v, a mass M
// and a substep h, an explicit step of a body of the mass M + h D is that implicit one.

/// [kg] Mass of a pusher whose servo and damping are implicit in substeps of this length [s]; 0: they are explicit. A
/// drive to a position is explicit.
constexpr double pusherMass(const Physics& physics, double implicit_substep) {
  if (physics.drive == Drive::kPosition) {
    return physics.pusher_mass;
  }
  return physics.pusher_mass + implicit_substep * (physics.servo_gain + physics.pusher_damping);
}

/// Inertia of a tee as one rigid body.
struct TeeInertia {
  double mass;           ///< [kg]
  double first_moment;   ///< [kg m] mass times center of mass, along body -y
  double second_moment;  ///< [kg m^2] moment of inertia about the tee origin

  /// [m] from the tee origin to its center of mass, along body -y.
  constexpr double center() const { return first_moment / mass; }
  /// [kg m^2] Moment of inertia about a point [m] of its axis, along body -y from the origin.
  constexpr double momentAbout(double point) const {
    return second_moment - point * (2.0 * first_moment - mass * point);
  }
  /// [kg m^2] Moment of inertia about the center of mass.
  constexpr double momentAboutCenter() const { return second_moment - mass * center() * center(); }
};

/// Inertia of a tee whose damping is implicit in substeps of this length [s]; 0: it is explicit. The mass that makes it
/// so sits where the damping acts.
constexpr TeeInertia teeInertia(const Physics& physics, double implicit_substep) {
  const double added = implicit_substep * physics.tee_damping;
  const double point = physics.table_point;
  return {physics.tee_mass + added, physics.tee_first_moment + added * point,
          physics.tee_second_moment + implicit_substep * physics.tee_yaw_damping + added * point * point};
}

/// `state` with place and velocity of the tee at a point of it in place of its origin; the point is `distance` [m]
/// along body -y. With the distance back, it is the state again, to rounding.
inline WorldState atPointOfTee(WorldState state, double distance) {
  if (distance != 0.0) {
    const Eigen::Vector2d arm(distance * std::sin(state.tee_yaw), -distance * std::cos(state.tee_yaw));
    state.tee_position += arm;
    state.tee_velocity += state.tee_yaw_rate * Eigen::Vector2d(-arm.y(), arm.x());
  }
  return state;
}

/// [N] Force of drive and damping on the pusher along an axis, for its command [m/s, or m] and its present position [m]
/// and velocity [m/s].
constexpr double pusherForce(const Physics& physics, double command, double position, double velocity) {
  if (physics.drive == Drive::kPosition) {
    const double force = physics.servo_stiffness * (command - position) - physics.servo_gain * velocity;
    return std::clamp(force, -physics.servo_limit, physics.servo_limit) - physics.pusher_damping * velocity;
  }
  return std::clamp(physics.servo_gain * (command - velocity), -physics.servo_limit, physics.servo_limit) -
         physics.pusher_damping * velocity;
}

/// Box along the axes of its body, or of the table.
struct PlacedBox {
  double x;       ///< [m] of its center
  double y;       ///< [m] of its center
  double half_x;  ///< [m] half its length along x
  double half_y;  ///< [m] half its length along y
};

/// Bar and stem, in the tee's frame.
constexpr std::array<PlacedBox, 2> teeBoxes(const Physics& physics) {
  return {{{0.0, 0.0, physics.bar_half_length, physics.bar_half_width},
           {0.0, -physics.stem_offset, physics.stem_half_width, physics.stem_half_length}}};
}

/// The walls at +y, -y, +x and -x, which meet in the corners.
constexpr std::array<PlacedBox, 4> wallBoxes(const Physics& physics) {
  constexpr double kHalf = dynamics::kWallThickness / 2.0;
  const double middle = physics.wall_inner_face + kHalf;
  const double half_length = physics.wall_inner_face + dynamics::kWallThickness;
  const auto [x, y] = physics.wall_middle;
  return {{{x, y + middle, half_length, kHalf},
           {x, y - middle, half_length, kHalf},
           {x + middle, y, kHalf, half_length},
           {x - middle, y, kHalf, half_length}}};
}

}  // namespace pusht
