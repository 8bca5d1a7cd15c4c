// SPDX-License-Identifier: BSD-3-Clause
/// What the rigid-body engine depends on: ten modelling choices, each the two-mass engine's or MuJoCo's, and the
/// numbers that follow from them. docs/ladder.md has the table of the switches and the formula behind each.
#pragma once

#include <array>
#include <cstddef>

#include "pusht_task/constants.hpp"

namespace pusht {

/// Each is faithful (true: as MuJoCo has this scene) or simple (false: as the two-mass engine has it).
struct RigidBodyParameters {
  bool servo = true;
  bool pusher_inertia = true;
  bool tee_inertia = true;
  bool shape = true;
  bool drag = true;
  bool coulomb = true;
  bool friction = true;
  bool softness = true;
  bool walls = true;
  bool narrow_phase = true;
};

namespace rigid_body {

/// A switch, for whoever sets or shows it by name. The order is that of the ladder.
struct Switch {
  const char* name;
  const char* meaning;  ///< faithful; simple
  bool RigidBodyParameters::*value;
};

inline constexpr std::array kSwitches = {
    Switch{"servo", "force of 20 N s/m up to 30 N, damped, implicit; simple: acceleration of 20 1/s without limit",
           &RigidBodyParameters::servo},
    Switch{"pusher_inertia", "0.2 kg in contact; simple: 4 kg", &RigidBodyParameters::pusher_inertia},
    Switch{"tee_inertia", "moment of inertia of two boxes; simple: of two points", &RigidBodyParameters::tee_inertia},
    Switch{"shape", "two boxes; simple: two discs", &RigidBodyParameters::shape},
    Switch{"drag", "4 N s/m at the tee's origin and 0.02 N m s, implicit; simple: 6 1/s on every mass",
           &RigidBodyParameters::drag},
    Switch{"coulomb", "dry friction with the table, 1.2 N per axis and 0.006 N m; simple: none",
           &RigidBodyParameters::coulomb},
    Switch{"friction", "friction between bodies, coefficient 1; simple: none", &RigidBodyParameters::friction},
    Switch{"softness", "contacts give way as MuJoCo's do; simple: hard, a fifth of the overlap removed in a substep",
           &RigidBodyParameters::softness},
    Switch{"walls", "walls for pusher and tee; simple: none", &RigidBodyParameters::walls},
    Switch{"narrow_phase", "points of contact as MuJoCo finds them; simple: the nearest points",
           &RigidBodyParameters::narrow_phase},
};

/// Of the simple choices: those of the two-mass engine (two_mass_dynamics.hpp, TwoMassParameters), of whose course they
/// are.
namespace simple {
constexpr double kServoRate = 20.0;    ///< [1/s]
constexpr double kPusherMass = 4.0;    ///< [kg]
constexpr double kBarRadius = 0.032;   ///< [m]
constexpr double kStemRadius = 0.026;  ///< [m]
constexpr double kDragRate = 6.0;      ///< [1/s]
constexpr double kOverlapShare = 0.2;  ///< [-] of the overlap, removed in one substep
constexpr double kMargin = 1.0e-3;     ///< [m] bodies closer than this touch
/// [-] What is left of a violated constraint's missing acceleration. Contacts are hard, but a number must say how hard.
constexpr double kCompliance = 1.0e-6;
}  // namespace simple

/// MuJoCo's defaults for constraints; the names are those of its XML reference.
namespace soft {
constexpr double kTimeConstant = 0.02;   ///< [s] solref[0]; its damping ratio is 1
constexpr double kLeastImpedance = 0.9;  ///< [-] solimp[0]
constexpr double kImpedance = 0.95;      ///< [-] solimp[1], from a depth of kWidth on
constexpr double kWidth = 0.001;         ///< [m] solimp[2]; solimp[3] and [4] make the way there two parabolas
constexpr double kDamping = 2.0 / (kImpedance * kTimeConstant);                                 ///< [1/s]
constexpr double kStiffness = 1.0 / (kImpedance * kImpedance * kTimeConstant * kTimeConstant);  ///< [1/s^2]
}  // namespace soft

/// Coordinates and velocities, in MuJoCo's order.
enum Coordinate : std::size_t { kTeeX, kTeeY, kTeeYaw, kPusherX, kPusherY, kCoordinateCount };

/// What a substep depends on besides the bodies.
struct Model {
  RigidBodyParameters switches;

  double tee_mass;          ///< [kg]
  double tee_moment;        ///< [kg m^2] about the tee's origin
  double pusher_mass;       ///< [kg] in contact
  double servo_gain;        ///< [kg/s] force per missing velocity
  double servo_limit;       ///< [N] per axis
  double pusher_damping;    ///< [kg/s]
  double drag_rate;         ///< [1/s] of every mass of the tee; explicit
  double tee_damping;       ///< [kg/s] at its origin; implicit, as are the next and the servo of MuJoCo
  double tee_yaw_damping;   ///< [N m s]
  double servo_derivative;  ///< [kg/s] of the pusher's smooth force by its velocity, as far as it is implicit

  std::array<double, 3> dry_friction;             ///< [N, N, N m] at most; 0: none
  std::array<double, 3> dry_friction_regularity;  ///< [kg, kg, kg m^2] force per missing acceleration

  double tee_pusher_weight;  ///< [1/kg] scale of the compliance of contacts between tee and pusher
  double tee_wall_weight;
  double pusher_wall_weight;
};

Model modelOf(const RigidBodyParameters& parameters);

}  // namespace rigid_body
}  // namespace pusht
