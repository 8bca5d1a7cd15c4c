// SPDX-License-Identifier: BSD-3-Clause
/// PushT as a Chipmunk space. Its numbers are data and its laws virtual, so that a test can plant an error in either
/// and see it found.
#pragma once

#include <chipmunk/chipmunk.h>

#include <memory>
#include <vector>

#include "chipmunk_world.hpp"
#include "pusht_task/mapping.hpp"
#include "pusht_task/physics.hpp"
#include "pusht_task/types.hpp"

namespace pusht::chipmunk {

struct Free {
  void operator()(cpSpace* space) const { cpSpaceFree(space); }
  void operator()(cpBody* body) const { cpBodyFree(body); }
  void operator()(cpShape* shape) const { cpShapeFree(shape); }
  void operator()(cpConstraint* constraint) const { cpConstraintFree(constraint); }
};
template <class T>
using Owned = std::unique_ptr<T, Free>;

/// Bodies, walls and frictions, built anew for every reset.
class Scene {
 public:
  explicit Scene(const ChipmunkParameters& parameters, const Physics& physics = {});
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
  virtual ~Scene() = default;

  /// Puts the bodies in and moves them to `state`.
  void start(const WorldState& state);
  /// Moves on by a substep, with the pusher commanded to a velocity [m/s].
  void substep(const cpVect& command);
  WorldState state() const;

 protected:
  virtual void addWalls();
  virtual void addDryFriction();
  /// Sets servo and damping for the substep that comes.
  virtual void applyForces(const cpVect& command);

  void addBox(cpBody* body, const PlacedBox& box);
  /// Adds a constraint that never pulls back, and uses at most `force` [N, or N m].
  void addFriction(cpConstraint* constraint, double force);
  void applyServo(const cpVect& command);

  /// [m] of the tee's center of mass from its origin, in table axes.
  cpVect teeArm() const;
  cpVect teeVelocity() const;
  cpBody* table() const { return cpSpaceGetStaticBody(space_.get()); }
  cpBody* tee() const { return tee_; }
  const Physics& physics() const { return physics_; }

 private:
  cpBody* addBody(double mass, double moment);
  cpBody* addPusherBody();
  cpBody* addTeeBody();
  void addShape(cpShape* shape);

  const ChipmunkSwitches& switches() const { return parameters_.switches; }

  Physics physics_;
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

}  // namespace pusht::chipmunk
