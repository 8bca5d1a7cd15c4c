// SPDX-License-Identifier: BSD-3-Clause
/// Parameters of the rigid-body engine: ten modeling choices, each the two-mass engine's or MuJoCo's, the numbers that
/// follow from them, and a substep. docs/ladder.md has the table of the switches and the formula behind each.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "pusht_task/constants.hpp"
#include "pusht_task/physics.hpp"
#include "pusht_task/switches.hpp"

namespace pusht {

/// Length of a substep; switches, one for each modeling choice: faithful (true: MuJoCo's in this scene) or simple
/// (false: the two-mass engine's); and continuous contact, which neither has.
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
  bool continuous = false;    ///< whether bodies that meet within a substep stop there (continuous_contact.hpp)
  double substep = kSubstep;  ///< [s] a value of substepDescriptor()
};

namespace rigid_body {

using Switch = pusht::Switch<RigidBodyParameters>;

/// Descriptions of all switches, in the order of docs/ladder.md.
inline constexpr std::array kSwitches = {
    Switch{"servo", "force of 20 N s/m up to 30 N, damped, implicit; simple: acceleration of 20 1/s without limit",
           &RigidBodyParameters::servo},
    Switch{"pusher_inertia", "0.2 kg in contact; simple: 4 kg", &RigidBodyParameters::pusher_inertia},
    Switch{"tee_inertia", "moment of inertia of two boxes; simple: of two points", &RigidBodyParameters::tee_inertia},
    Switch{"shape", "two boxes; simple: two discs", &RigidBodyParameters::shape},
    Switch{"drag", "4 N s/m at the tee's origin and 0.02 N m s, implicit; simple: 6 1/s on every mass",
           &RigidBodyParameters::drag},
    Switch{"coulomb", "Coulomb friction with the table, 1.2 N per axis and 0.006 N m; simple: none",
           &RigidBodyParameters::coulomb},
    Switch{"friction", "friction between bodies, coefficient 1; simple: none", &RigidBodyParameters::friction},
    Switch{"softness", "contacts give way as MuJoCo's do; simple: hard, a fifth of the overlap removed in a substep",
           &RigidBodyParameters::softness},
    Switch{"walls", "walls for pusher and tee; simple: none", &RigidBodyParameters::walls},
    Switch{"narrow_phase", "points of contact as MuJoCo finds them; simple: the nearest points",
           &RigidBodyParameters::narrow_phase},
};

/// Constants of the simple choices. Source: the two-mass engine (two_mass_dynamics.hpp, TwoMassParameters).
namespace simple {
constexpr double kServoRate = 20.0;    ///< [1/s]
constexpr double kPusherMass = 4.0;    ///< [kg]
constexpr double kBarRadius = 0.032;   ///< [m]
constexpr double kStemRadius = 0.026;  ///< [m]
constexpr double kDragRate = 6.0;      ///< [1/s]
constexpr double kOverlapShare = 0.2;  ///< [-] share of the overlap that is removed in one substep
constexpr double kMargin = 1.0e-3;     ///< [m] gap below which bodies touch
/// [-] Share of a violated constraint's missing acceleration that stays. Near 0: contacts are hard.
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

/// Generalized coordinates, in MuJoCo's order.
enum Coordinate : std::size_t { kTeeX, kTeeY, kTeeYaw, kPusherX, kPusherY, kCoordinateCount };

/// Vector over the generalized coordinates.
using Vector = std::array<double, kCoordinateCount>;

/// Box upright on the table, along its own axes. Half height and height matter to the portal only.
struct Box {
  double half_x;       ///< [m]
  double half_y;       ///< [m]
  double half_height;  ///< [m]
  double height;       ///< [m] of its center
};

/// Part of the tee: bar or stem.
struct Part {
  double offset;  ///< [m] from the origin of the tee's coordinates to the part's center, along body -y
  Box box;
  double disc_radius;  ///< [m] of the disc that stands for it where shapes are simple

  /// [m] Upper bound of the distance of any point of box or disc from the part's center.
  constexpr double reach() const { return box.half_x + box.half_y; }
};

/// Wall. Walls cross at the corners of the table.
struct Wall {
  Eigen::Index axis;       ///< 0: x, 1: y
  double side;             ///< 1 or -1
  double face;             ///< [m] of the inner face from the walls' middle
  Eigen::Vector2d middle;  ///< [m] between the walls

  Eigen::Vector2d inward() const { return -side * Eigen::Vector2d::Unit(axis); }
  /// [m] Distance of a point from the middle, towards the wall.
  double along(const Eigen::Vector2d& point) const { return side * (point[axis] - middle[axis]); }
  Eigen::Vector2d center() const { return middle - (face + 0.5 * dynamics::kWallThickness) * inward(); }
  Box box() const;
};

/// Constants of a substep. The tee's coordinates are those of the point at which the table acts on it.
struct Model {
  RigidBodyParameters switches;
  double substep;  ///< [s]

  std::array<Part, 2> parts;
  std::array<Wall, 4> walls;
  double pusher_radius;     ///< [m]
  double contact_friction;  ///< [-]
  double center_of_mass;    ///< [m] from the origin of the tee's coordinates, along body -y

  double tee_mass;          ///< [kg]
  double tee_moment;        ///< [kg m^2] about the tee's origin
  double pusher_mass;       ///< [kg] in contact
  double servo_stiffness;   ///< [N/m] force per missing way, of a drive to a position; 0: the drive is to a velocity
  double servo_gain;        ///< [kg/s] force per missing velocity, or per velocity of a drive to a position
  double servo_limit;       ///< [N] per axis
  double pusher_damping;    ///< [kg/s]
  double drag_rate;         ///< [1/s] on every mass of the tee; explicit
  double tee_damping;       ///< [kg/s] at the tee's origin; implicit
  double tee_yaw_damping;   ///< [N m s] implicit
  double servo_derivative;  ///< [kg/s] minus the implicit part of the pusher's force by its velocity

  std::array<double, 3> coulomb_limit;       ///< [N, N, N m] greatest friction with the table
  std::array<double, 3> coulomb_regularity;  ///< [kg, kg, kg m^2] friction per missing acceleration

  double tee_pusher_weight;   ///< [1/kg] scale of the compliance of contacts between tee and pusher
  double tee_wall_weight;     ///< [1/kg] between tee and wall
  double pusher_wall_weight;  ///< [1/kg] between pusher and wall
};

/// Constants of a substep with these switches, in a task of this physics. Throws InvalidInput for a switch that a drive
/// to a position does not have.
Model modelOf(const RigidBodyParameters& parameters, const Physics& physics = {});

/// State of a world. The yaw is not wrapped.
struct Bodies {
  Vector positions;   ///< [m, m, rad, m, m]
  Vector velocities;  ///< [m/s, m/s, rad/s, m/s, m/s]
};

/// One substep in which the pusher is to move with velocity `command` [m/s], or to that place [m].
void substep(const Model& model, const Eigen::Vector2d& command, Bodies& bodies);

}  // namespace rigid_body
}  // namespace pusht
