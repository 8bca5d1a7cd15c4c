// SPDX-License-Identifier: BSD-3-Clause
/// PushT in Bullet, the engine behind PyBullet, in double precision.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>

#include "pusht_task/constants.hpp"
#include "pusht_task/simulator.hpp"
#include "pusht_task/switches.hpp"

namespace pusht {

/// Settings of Bullet's solver and steps, and its idioms as switches. The task's masses, forces and
/// frictions are those of pusht_task.
struct BulletParameters {
  bool servo = true;           ///< else a motor of Bullet
  bool table_friction = true;  ///< else a plane and gravity
  bool drag = true;            ///< else Bullet's damping of a body
  bool margin = true;          ///< else Bullet's default
  int iterations = 50;         ///< of the constraint solver in a substep
  double overlap_rate = 40.0;  ///< [1/s] of an overlap's decay, about that of MuJoCo's contacts
  double substep = kSubstep;   ///< [s] a value of substepDescriptor()
};

namespace bullet {

class Scene;

using BulletSwitch = Switch<BulletParameters>;

/// Modeling choices: on as in the scene, off as one writes it after Bullet's examples.
inline constexpr std::array kSwitches = {
    BulletSwitch{"servo", "the pusher's soft servo, implicit; idiom: a motor of Bullet that holds the velocity, 30 N",
                 &BulletParameters::servo},
    BulletSwitch{"table_friction",
                 "friction along each axis of the table; idiom: gravity, and friction in contacts with a plane",
                 &BulletParameters::table_friction},
    BulletSwitch{"drag", "damping of the tee at its origin, implicit; idiom: Bullet's damping, as far as it goes",
                 &BulletParameters::drag},
    BulletSwitch{"margin",
                 "the tee collides at its faces, from touch on; idiom: Bullet's default margin, 0.04 m around it",
                 &BulletParameters::margin},
};

}  // namespace bullet

/// One world: a planar task in a three-dimensional engine. The tee is one rigid body of two convex hulls, the pusher a
/// cylinder that does not turn; both move in a plane and turn about z alone. Servo and damping are implicit, as in
/// pusht_task/mapping.hpp. Friction of the table acts along each of its axes: motors of a 6-DoF constraint that hold
/// velocity 0, each with at most so much force.
class BulletWorld : public Simulator {
 public:
  static constexpr double kStartTolerance = 1e-12;  ///< [m, rad, m/s, rad/s]

  explicit BulletWorld(const BulletParameters& parameters = {});
  /// Builds its scene, of this substep [s], with `make_scene` at every reset; a test gives scenes with errors.
  using MakeScene = std::function<std::unique_ptr<bullet::Scene>()>;
  explicit BulletWorld(MakeScene make_scene, double substep = kSubstep);
  ~BulletWorld() override;

 private:
  /// Builds the scene anew: Bullet remembers contacts and their order. Throws SimulationFault for a tee that turns
  /// faster than Bullet can follow.
  void doReset(const WorldState& state) override;
  /// Throws SimulationFault for a tee that comes to turn so fast.
  void doStep(const Action& action) override;
  WorldState doState() const override;

  MakeScene make_scene_;
  double substep_;  ///< [s]
  int substeps_;    ///< in a control step
  std::unique_ptr<bullet::Scene> scene_;
  std::optional<WorldState> start_;  ///< until the first step: Bullet keeps a yaw as a matrix, which rounds it
};

}  // namespace pusht
