// SPDX-License-Identifier: BSD-3-Clause
/// Physics that a kind of simulator claims to have.
#pragma once

#include <optional>

#include "pusht_task/physics.hpp"

namespace pusht::testing {

/// Claims of a kind; the defaults are the task itself. A kind with simpler physics states its own numbers: 0 for a
/// force that it does not have.
struct PhysicsOfKind {
  Physics numbers{};
  bool implicit_servo =
      true;                ///< servo and damping of the pusher act at the velocity at a substep's end, not its begin
  double drag_rate = 0.0;  ///< [1/s] of every mass of the tee, explicit; in place of damping
  bool soft_friction = false;  ///< the table's Coulomb friction is MuJoCo's: a tee at rest creeps
  bool soft_contacts = false;  ///< contacts are MuJoCo's: bodies that press each other overlap
  bool discs = false;          ///< bar and stem are discs; their half-sides are radii
  bool walls = true;

  // Largest deviations from the formulas. A wider one than these has its reason beside it.
  double free_position = 1e-4;     ///< [m] of a body that moves freely, after a control step
  double free_yaw = 1e-3;          ///< [rad]
  double free_speed = 1e-3;        ///< [m/s], and [rad/s] at a lever of kLever
  double contact_position = 1e-3;  ///< [m] overlap in touch
  double push_position = 1e-3;     ///< [m] how far bodies lag behind a push
  double push_speed = 5e-3;        ///< [m/s] of bodies that push each other steadily
  double slip_speed = 5e-3;        ///< [m/s] along a face with friction

  /// [-] Median position error in replays of expert episodes, as a share of that of a tee that never moves; none if the
  /// kind does not claim to follow the reference.
  std::optional<double> replay_error{};

  static constexpr double kLever = 0.06;  ///< [m]
};

}  // namespace pusht::testing
