// SPDX-License-Identifier: BSD-3-Clause
/// PushT as a space of Chipmunk 7, the engine behind pymunk and gym-pusht.
#pragma once

#include <chipmunk/chipmunk.h>

#include <array>
#include <cstdint>
#include <vector>

#include "chipmunk_types.hpp"
#include "pusht_task/scene_kind.hpp"
#include "pusht_task/scene_world.hpp"

namespace pusht {

/// What Chipmunk can be told of its solver, and the choices of the mapping: false is the idiom, which demos and manual
/// of Chipmunk have. The task's masses, forces and frictions are those of pusht_task.
struct ChipmunkParameters : SceneParameters {
  bool slop = true;
  bool order = true;
  std::int64_t iterations = 30;  ///< of the contact solver in a substep
  double collision_slop = 1e-4;  ///< [m] overlap that is left alone
  double overlap_left = 0.0018;  ///< [-] share of an overlap that is left after a second
};

/// Scene of Chipmunk. The tee is one rigid body of two boxes, the pusher a disc that does not turn. Servo and damping
/// are implicit, as in pusht_task/mapping.hpp. Dry friction acts along each axis of the table: a groove joint for each,
/// which may use so much force and never pulls back. Bodies move after their collision was solved, as in the reference.
class ChipmunkScene : public Scene {
 public:
  using Parameters = ChipmunkParameters;
  static constexpr const char* kTitle = "Chipmunk";
  static constexpr double kStartTolerance = 1e-12;  ///< [m, rad, m/s, rad/s]

  /// Descriptions of all switches.
  static constexpr std::array kSwitches = {
      Switch<Parameters>{"servo",
                         "a soft servo of 20 N s/m up to 30 N, implicit; idiom: a pivot joint to a body that moves as "
                         "commanded, as stiff as 30 N allow",
                         &Parameters::servo},
      Switch<Parameters>{"table_friction",
                         "Coulomb friction per axis, at the tee's origin; idiom: a pivot joint, a disc, and a gear "
                         "joint",
                         &Parameters::table_friction},
      Switch<Parameters>{"drag",
                         "damping at the tee's origin, implicit; idiom: a share of the body's velocities is kept",
                         &Parameters::drag},
      Switch<Parameters>{"slop", "overlaps of `collision_slop` are left; idiom: of 0.1 m, Chipmunk's default",
                         &Parameters::slop},
      Switch<Parameters>{"order", "bodies move after collisions are solved; idiom: before, as Chipmunk moves them",
                         &Parameters::order},
  };

  /// Descriptions of the solver's numbers.
  static constexpr std::array kNumbers = {
      SolverNumber<Parameters>{"iterations", "", "sweeps of the contact solver in a substep", &Parameters::iterations,
                               1, 1000, "more sweeps make no visible difference"},
      SolverNumber<Parameters>{"collision_slop", "m", "overlap that the solver leaves alone",
                               &Parameters::collision_slop, 0.0, 0.01, "more is a third of the tee's width"},
      SolverNumber<Parameters>{"overlap_left", "", "share of an overlap that is left after a second",
                               &Parameters::overlap_left, 0.0, 1.0, "it is a share"},
  };

  explicit ChipmunkScene(const ChipmunkParameters& parameters, const Physics& physics = {});

  WorldState start(const WorldState& state) override;
  WorldState state() const override;

 protected:
  void addWall(const PlacedBox& box) override { addBox(table(), box); }
  void addFrictionPerAxis(const Eigen::Vector2d& point) override;
  void addIdiomaticFriction() override;
  void applyServo(const Eigen::Vector2d& command) override;
  void applyDragAt(const Eigen::Vector2d& point) override;
  void advance() override;

  /// Adds a constraint that never pulls back, and uses at most `force` [N, or N m].
  void addFriction(cpConstraint* constraint, double force);

  cpBody* table() const { return cpSpaceGetStaticBody(space_.get()); }
  cpBody* tee() const { return tee_; }

 private:
  cpBody* addBody(double mass, double moment);
  cpBody* addPusherBody();
  cpBody* addTeeBody();
  void addShape(cpShape* shape);
  void addBox(cpBody* body, const PlacedBox& box);

  /// [m] of the tee's center of mass from a point of its body, in table axes.
  cpVect teeArm(const cpVect& point) const;
  /// [m/s] of a point of the tee's body.
  cpVect teeVelocity(const cpVect& point) const;

  ChipmunkParameters parameters_;
  double tee_keeps_ = 1.0;     ///< [-] share of the tee's velocities that is kept in a substep
  cpBody* command_ = nullptr;  ///< moves as commanded; none with a servo
  cpBody* pusher_ = nullptr;
  cpBody* tee_ = nullptr;
  std::vector<Owned<cpBody>> bodies_;
  std::vector<Owned<cpShape>> shapes_;
  std::vector<Owned<cpConstraint>> constraints_;
  Owned<cpSpace> space_;  // last, hence freed first: it looks at its bodies then
};

}  // namespace pusht
