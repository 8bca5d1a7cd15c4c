// SPDX-License-Identifier: BSD-3-Clause
/// Checks of a world's physics against what its kind claims. Each sets the world to a state, steps it, and compares
/// what it did with a plain formula. They know a world by its interface alone. What they cannot see is a common scale
/// of all masses and forces: no motion depends on it.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "pusht_task/simulator.hpp"
#include "pusht_testing/physics_of_kind.hpp"

namespace pusht::testing {

/// Deviations of a world from a law.
class Deviations {
 public:
  void expectNear(const std::string& what, double found, double expected, double tolerance);
  void expect(bool holds, const std::string& what);

  bool any() const { return count_ > 0; }

  /// "3 of 48 figures deviate; most: spin at 4 rad/s, yaw 2 [rad]: 0.31, must be 0.29 +- 0.001"; empty if none does.
  std::string summary() const;

 private:
  void add(double excess, const std::string& what);

  std::size_t expected_ = 0;
  std::size_t count_ = 0;
  double most_ = 0.0;  // in tolerances
  std::string what_;   // of that one
};

using PhysicsCheck = Deviations (*)(Simulator& world, const PhysicsOfKind& physics);

namespace physics {

/// A servo's velocity and position after a step of its command: gain, damping and mass.
Deviations servo(Simulator& world, const PhysicsOfKind& physics);

/// From a velocity so wrong that the servo's force is at its limit.
Deviations servoLimit(Simulator& world, const PhysicsOfKind& physics);

/// A slide along the line of both centers does not turn the tee: damping and friction with the table, axis by axis. In
/// the diagonal friction has its whole limit on each axis: a box, not a disc.
Deviations slide(Simulator& world, const PhysicsOfKind& physics);

/// A slide across the line of centers turns the tee: side and distance of the center of mass from where the table acts,
/// moment of inertia.
Deviations slideAcross(Simulator& world, const PhysicsOfKind& physics);

/// A tee that turns: moment of inertia, damping and friction of the yaw; the origin's path shows the center of mass.
Deviations spin(Simulator& world, const PhysicsOfKind& physics);

/// A steady push: all forces of the tee in units of the pusher's, and the inertia of both.
Deviations push(Simulator& world, const PhysicsOfKind& physics);

/// Positions of the pusher as it touches each face of the tee, pushing gently.
Deviations sizes(Simulator& world, const PhysicsOfKind& physics);

/// Positions at which walls stop the pusher, and the tee that it pushes; without walls nothing stops them.
Deviations walls(Simulator& world, const PhysicsOfKind& physics);

/// The pusher presses with a force that its servo knows, and is told to slip: friction takes its coefficient times that
/// force from the slip, along a wall, and along the bar in a corner, where it cannot give way. Without friction a push
/// leaves the slip as it is in free space. (Friction without walls is not checked.)
Deviations contactFriction(Simulator& world, const PhysicsOfKind& physics);

}  // namespace physics

/// Physics check with its name in test reports.
struct NamedPhysicsCheck {
  const char* name;
  PhysicsCheck check;
};

inline constexpr std::array kPhysicsChecks = {
    NamedPhysicsCheck{"servo", physics::servo},
    NamedPhysicsCheck{"servo limit", physics::servoLimit},
    NamedPhysicsCheck{"slide", physics::slide},
    NamedPhysicsCheck{"slide across", physics::slideAcross},
    NamedPhysicsCheck{"spin", physics::spin},
    NamedPhysicsCheck{"push", physics::push},
    NamedPhysicsCheck{"sizes", physics::sizes},
    NamedPhysicsCheck{"walls", physics::walls},
    NamedPhysicsCheck{"contact friction", physics::contactFriction},
};

/// Names of the physics checks that find a deviation from what is claimed.
std::vector<std::string> findingsIn(Simulator& world, const PhysicsOfKind& claims);

}  // namespace pusht::testing
