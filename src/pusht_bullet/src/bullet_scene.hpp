// SPDX-License-Identifier: BSD-3-Clause
/// PushT as a world of Bullet. Its numbers are data and its laws virtual, so that a test can plant an error in either
/// and see it found.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <array>
#include <memory>
#include <vector>

#include "bullet_world.hpp"
#include "pusht_task/mapping.hpp"
#include "pusht_task/physics.hpp"
#include "pusht_task/types.hpp"

namespace pusht::bullet {

/// Bodies, walls and frictions, built anew for every reset. The tee's middle is at z = 0.
class Scene {
 public:
  explicit Scene(const BulletParameters& parameters, const Physics& physics = {});
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
  virtual ~Scene() = default;

  /// Puts the bodies in, in `state`.
  void start(const WorldState& state);
  /// Moves on by a substep, with the pusher commanded to a velocity [m/s].
  void substep(const btVector3& command);
  WorldState state() const;
  /// [rad/s]
  double teeYawRate() const { return tee_->getAngularVelocity().z(); }

 protected:
  virtual void addWalls();
  virtual void addTableFriction();
  /// Sets servo and damping for the substep that comes.
  virtual void applyForces(const btVector3& command);

  void addWall(const PlacedBox& box);
  /// Adds motors that hold velocity 0 between the table and this point of the tee (body axes, from its origin [m]).
  void addFrictionMotors(const btVector3& point, const std::array<double, 2>& force, double moment);
  void applyServo(const btVector3& command);

  /// [m] From the tee's center of mass to its origin, in table axes.
  btVector3 teeArm() const;
  btVector3 teeVelocity() const;
  btRigidBody& tee() const { return *tee_; }
  const Physics& physics() const { return physics_; }

 private:
  using Body = std::unique_ptr<btRigidBody>;
  using Motors = btGeneric6DofSpring2Constraint;

  /// Configuration with room for the few contacts of this task, in place of megabytes at every reset.
  static btDefaultCollisionConstructionInfo smallPools();
  void addTee(const WorldState& state);
  void addPusher(const WorldState& state);
  btCollisionShape* addHull(double half_x, double half_y);
  /// Makes a body that moves and turns only as `linear` and the moment about z [kg m^2] let it.
  Body makeBody(double mass, double moment, btCollisionShape* shape, const btTransform& pose, const btVector3& linear);
  Motors* addMotors(btRigidBody& body, const btTransform& frame, const std::array<double, 2>& force);
  void addTable();
  void addPlane();
  template <class Shape>
  Shape* keep(std::unique_ptr<Shape> shape);

  BulletParameters parameters_;
  Physics physics_;
  double center_ = 0.0;  ///< [m] from the tee's origin to its center of mass in the engine, along body -y

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<Body> walls_;
  Body table_;
  Body tee_;
  Body pusher_;
  std::vector<std::unique_ptr<Motors>> motors_;
  Motors* pusher_motors_ = nullptr;  ///< none with the soft servo
  btDiscreteDynamicsWorld world_;    // last, hence destroyed first: it looks at its bodies then
};

}  // namespace pusht::bullet
