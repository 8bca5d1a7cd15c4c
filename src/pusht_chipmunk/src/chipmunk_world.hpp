// SPDX-License-Identifier: BSD-3-Clause
/// PushT in Chipmunk 7, the engine behind pymunk and gym-pusht.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>

#include "pusht_task/constants.hpp"
#include "pusht_task/simulator.hpp"
#include "pusht_task/switches.hpp"

namespace pusht {

/// Version of the library, e.g. "7.0.3".
std::string chipmunkVersion();

/// Choices of the mapping: true is the mapping, false the idiom, which demos and manual of Chipmunk have.
struct ChipmunkSwitches {
  bool servo = true;
  bool table_friction = true;
  bool drag = true;
  bool slop = true;
  bool order = true;
};

/// What Chipmunk can be told of its solver and its steps, and the choices of the mapping. The task's masses, forces and
/// frictions are those of pusht_task.
struct ChipmunkParameters {
  int iterations = 30;           ///< of the contact solver in a substep
  double collision_slop = 1e-4;  ///< [m] overlap that is left alone
  double overlap_left = 0.0018;  ///< [-] share of an overlap that is left after a second
  double substep = kSubstep;     ///< [s] a value of substepDescriptor()
  ChipmunkSwitches switches{};
};

namespace chipmunk {

class Scene;

/// Descriptions of all switches.
inline constexpr std::array kSwitches = {
    Switch<ChipmunkSwitches>{"servo",
                             "a soft servo of 20 N s/m up to 30 N, implicit; idiom: a pivot joint to a body that moves "
                             "as commanded, as stiff as 30 N allow",
                             &ChipmunkSwitches::servo},
    Switch<ChipmunkSwitches>{"table_friction",
                             "Coulomb friction per axis, at the tee's origin; idiom: a pivot joint, a disc, and a gear "
                             "joint",
                             &ChipmunkSwitches::table_friction},
    Switch<ChipmunkSwitches>{"drag",
                             "damping at the tee's origin, implicit; idiom: a share of the body's velocities is kept",
                             &ChipmunkSwitches::drag},
    Switch<ChipmunkSwitches>{"slop", "overlaps of `collision_slop` are left; idiom: of 0.1 m, Chipmunk's default",
                             &ChipmunkSwitches::slop},
    Switch<ChipmunkSwitches>{"order", "bodies move after collisions are solved; idiom: before, as Chipmunk moves them",
                             &ChipmunkSwitches::order},
};

}  // namespace chipmunk

/// One world. The tee is one rigid body of two boxes, the pusher a disc that does not turn. Servo and damping are
/// implicit, as in pusht_task/mapping.hpp. Dry friction acts along each axis of the table: a groove joint for each,
/// which may use so much force and never pulls back. Bodies move after their collision was solved, as in the reference.
class ChipmunkWorld : public Simulator {
 public:
  static constexpr double kStartTolerance = 1e-12;  ///< [m, rad, m/s, rad/s]

  explicit ChipmunkWorld(const ChipmunkParameters& parameters = {});
  /// Builds its scene, of this substep [s], with `make_scene` at every reset; a test gives scenes with errors.
  using MakeScene = std::function<std::unique_ptr<chipmunk::Scene>()>;
  explicit ChipmunkWorld(MakeScene make_scene, double substep = kSubstep);
  ~ChipmunkWorld() override;

 private:
  /// Builds the scene anew: Chipmunk remembers contacts and their order.
  void doReset(const WorldState& state) override;
  void doStep(const Action& action) override;
  WorldState doState() const override;

  MakeScene make_scene_;
  int substeps_;  ///< in a control step
  std::unique_ptr<chipmunk::Scene> scene_;
};

}  // namespace pusht
