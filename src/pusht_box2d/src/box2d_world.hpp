// SPDX-License-Identifier: BSD-3-Clause
/// PushT in Box2D 2.4, which computes in single precision.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "pusht_task/constants.hpp"
#include "pusht_task/simulator.hpp"
#include "pusht_task/switches.hpp"

namespace pusht {

/// Version of the library as loaded, e.g. "2.4.1".
std::string box2dVersion();

/// Choices of the mapping: true is the mapping, false the idiom, which the tutorials of Box2D have.
struct Box2dSwitches {
  bool servo = true;
  bool table_friction = true;
  bool drag = true;
  bool scale = true;
};

/// Settings of Box2D's solver and steps, and the choices of the mapping. The task's masses, forces and
/// frictions are those of pusht_task.
struct Box2dParameters {
  int velocity_iterations = 30;  ///< sweeps of the solver over velocities in a substep
  int position_iterations = 10;  ///< most sweeps over overlaps in a substep
  double substep = kSubstep;     ///< [s] a value of substepDescriptor()
  Box2dSwitches switches{};
};

namespace box2d {

class Scene;

/// Descriptions of all switches.
inline constexpr std::array kSwitches = {
    Switch<Box2dSwitches>{"servo",
                          "a soft servo of 20 N s/m up to 30 N, implicit; idiom: a motor joint, as stiff as 30 N allow",
                          &Box2dSwitches::servo},
    Switch<Box2dSwitches>{"table_friction",
                          "Coulomb friction per axis, at the tee's origin; idiom: a friction joint, a disc, at its "
                          "center of mass",
                          &Box2dSwitches::table_friction},
    Switch<Box2dSwitches>{"drag",
                          "damping at the tee's origin, implicit; idiom: linear and angular damping of the body",
                          &Box2dSwitches::drag},
    Switch<Box2dSwitches>{"scale",
                          "lengths times 100, polygons without their skin; idiom: meters as they are, a skin of 0.01 m",
                          &Box2dSwitches::scale},
};

}  // namespace box2d

/// One world. The tee is one rigid body of two boxes, the pusher a disc that does not turn. Servo and damping are
/// implicit, as in pusht_task/mapping.hpp.
class Box2dWorld : public Simulator {
 public:
  /// [m, rad, m/s, rad/s] Single precision within kReach, and up to 32 rad/s.
  static constexpr double kStartTolerance = 1e-6;
  static constexpr double kReach = 8.0;  ///< [m] |x| or |y| within which bodies must be

  explicit Box2dWorld(const Box2dParameters& parameters = {});
  /// Builds its scene, of this substep [s], with `make_scene` at every reset; a test gives scenes with errors.
  using MakeScene = std::function<std::unique_ptr<box2d::Scene>()>;
  explicit Box2dWorld(MakeScene make_scene, double substep = kSubstep);
  ~Box2dWorld() override;

 private:
  /// Builds the scene anew: Box2D remembers contacts, impulses and their order. Throws SimulationFault for a start that
  /// single precision or the engine's limits of speed cannot hold.
  void doReset(const WorldState& state) override;
  /// Throws SimulationFault if a body leaves that range, or reaches the engine's limits of speed.
  void doStep(const Action& action) override;
  WorldState doState() const override;

  MakeScene make_scene_;
  int substeps_;  ///< in a control step
  std::unique_ptr<box2d::Scene> scene_;
  std::optional<WorldState> start_;  ///< as the bodies were given it, until the first step
};

}  // namespace pusht
