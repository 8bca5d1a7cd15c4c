// SPDX-License-Identifier: BSD-3-Clause
/// Physics of the task as one struct of numbers: an engine that follows the reference can be built from it, and the
/// physics suite of pusht_testing holds every kind of simulator against it.
#pragma once

#include <array>

#include "pusht_task/constants.hpp"

namespace pusht {

/// [kg m^2] Moment of inertia of a box with these half-sides about its center, in the plane.
constexpr double momentOfBox(double mass, double half_x, double half_y) {
  return mass * (half_x * half_x + half_y * half_y) / 3.0;
}

/// How the pusher is driven by a command.
enum class Drive {
  kVelocity,  ///< to a velocity, by a servo of `servo_gain`
  kPosition,  ///< to a position, by a spring of `servo_stiffness` and a damper of `servo_gain`
};

/// Masses, forces and sizes of a task, by default of the reference of `full_circle`. The table acts on the tee at one
/// point of it, along each axis of the table, and on its yaw.
struct Physics {
  double tee_mass = kBarMass + kStemMass;             ///< [kg]
  double tee_first_moment = kStemOffset * kStemMass;  ///< [kg m] mass times center of mass, along body -y
  double tee_second_moment =                          ///< [kg m^2] moment of inertia about the tee origin
      momentOfBox(kBarMass, kBarHalfLength, kTeeHalfWidth) + momentOfBox(kStemMass, kTeeHalfWidth, kStemHalfLength) +
      kStemMass * kStemOffset * kStemOffset;
  double tee_damping = dynamics::kTeeDamping;  ///< [N s/m] per axis
  double table_point = 0.0;                    ///< [m] from the tee origin to where the table acts, along body -y
  double tee_yaw_damping = dynamics::kTeeYawDamping;                                      ///< [N m s]
  std::array<double, 2> tee_friction = {dynamics::kTeeFriction, dynamics::kTeeFriction};  ///< [N] Coulomb, per axis
  double tee_yaw_friction = dynamics::kTeeYawFriction;                                    ///< [N m] Coulomb

  double pusher_mass = dynamics::kPusherMass;  ///< [kg]
  Drive drive = Drive::kVelocity;
  double servo_stiffness = 0.0;                      ///< [N/m] per axis, of a drive to a position
  double servo_gain = dynamics::kServoGain;          ///< [N s/m] per axis
  double servo_limit = dynamics::kServoLimit;        ///< [N] per axis
  double pusher_damping = dynamics::kPusherDamping;  ///< [N s/m] per axis

  double contact_friction = dynamics::kContactFriction;  ///< [-] between all bodies
  double pusher_radius = kPusherRadius;                  ///< [m]
  double bar_half_length = kBarHalfLength;               ///< [m] along body x
  double bar_half_width = kTeeHalfWidth;                 ///< [m] along body y
  double stem_half_length = kStemHalfLength;             ///< [m] along body y
  double stem_half_width = kTeeHalfWidth;                ///< [m] along body x
  double stem_offset = kStemOffset;                      ///< [m] from the bar's center to the stem's, along body -y
  double wall_inner_face = kWallInnerFace;               ///< [m] |x| or |y|, from the walls' middle
  std::array<double, 2> wall_middle = {0.0, 0.0};        ///< [m] between the walls

  /// [m] from the tee origin to its center of mass, along body -y.
  constexpr double centerOfMass() const { return tee_first_moment / tee_mass; }
};

constexpr double kLeastMass = 1e-3;  ///< [kg] of a body that a user may ask for
constexpr double kMostMass = 100.0;  ///< [kg]

/// [kg m^2] Moment of inertia, about the tee origin, of bar and stem of these masses [kg] and of the sizes of
/// `physics`.
constexpr double momentOfTee(double bar_mass, double stem_mass, const Physics& physics) {
  return momentOfBox(bar_mass, physics.bar_half_length, physics.bar_half_width) +
         momentOfBox(stem_mass, physics.stem_half_width, physics.stem_half_length) +
         stem_mass * physics.stem_offset * physics.stem_offset;
}

/// `physics` with the moments of a uniform tee of its mass and sizes.
constexpr Physics withUniformTee(Physics physics) {
  const double bar_area = physics.bar_half_length * physics.bar_half_width;
  const double stem_area = physics.stem_half_length * physics.stem_half_width;
  const double stem_mass = physics.tee_mass * stem_area / (bar_area + stem_area);
  physics.tee_first_moment = physics.stem_offset * stem_mass;
  physics.tee_second_moment = momentOfTee(physics.tee_mass - stem_mass, stem_mass, physics);
  return physics;
}

}  // namespace pusht
