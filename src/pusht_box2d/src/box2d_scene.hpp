// SPDX-License-Identifier: BSD-3-Clause
/// PushT as a Box2D world. Its numbers are data and its laws virtual, so that a test can plant an error in either and
/// see it found.
#pragma once

#include <box2d/box2d.h>

#include <Eigen/Core>
#include <string>
#include <vector>

#include "box2d_world.hpp"
#include "pusht_task/mapping.hpp"
#include "pusht_task/physics.hpp"
#include "pusht_task/types.hpp"

namespace pusht::box2d {

/// Bodies, walls and frictions, built anew for every reset. Lengths in Box2D are `scale` times those in meters, so
/// forces are that times those in newtons, and moments its square times those in newton meters.
class Scene {
 public:
  explicit Scene(const Box2dParameters& parameters, const Physics& physics = {});
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
  virtual ~Scene() = default;

  /// Puts the bodies in and moves them to `state`.
  void start(const WorldState& state);
  /// Moves on by a substep, with the pusher commanded to a velocity [m/s].
  void substep(const Eigen::Vector2d& command);
  WorldState state() const;
  /// `state` in the precision and the range of Box2D's numbers; a second time it changes no bit.
  WorldState rounded(const WorldState& state) const;
  /// Says which body is as fast as Box2D lets it, from where on velocities are cut off; empty if none.
  std::string faultOfSpeed() const;

 protected:
  virtual void addWalls();
  /// Adds the table's friction on the tee.
  virtual void addTableFriction();
  /// Sets servo and damping for the substep that comes.
  virtual void applyForces(const Eigen::Vector2d& command);

  /// Adds a box, with its skin within its sides if `switches().scale`.
  void addBox(b2Body* body, const PlacedBox& box);
  /// Adds Coulomb friction along each axis of the table, at a point of the tee [m], and on its yaw.
  void addFrictionPerAxis(const Eigen::Vector2d& point);
  /// Adds friction of a disc at a point of the tee [m].
  void addFrictionOfDisc(const Eigen::Vector2d& point);
  void applyServo(const Eigen::Vector2d& command);
  /// Damps the tee at a point of its body [m].
  void applyDrag(const Eigen::Vector2d& point);

  b2World& world() { return world_; }
  b2Body* table() const { return table_; }
  b2Body* tee() const { return tee_; }
  const Physics& physics() const { return physics_; }
  const Box2dSwitches& switches() const { return parameters_.switches; }

 private:
  struct NamedBody {
    const char* name;
    b2Body* body;
  };

  b2Body* addBody(const char* name, b2BodyDef def, double mass);
  void addPusher(const WorldState& state);
  void addTee(const WorldState& state);
  /// Adds a body that slides along an axis of the table with the tee's point, against friction [N].
  void addSlider(const b2Vec2& axis, const b2Vec2& point, double friction, double yaw_friction);
  void addMotor();

  /// Moves a body on with its velocities [s].
  static void moveOn(b2Body& body, float time);

  // Forces and rates in the units of Box2D, for a step in which they do what they would do in a substep.
  float rate(double per_second) const { return static_cast<float>(per_second * parameters_.substep / step_); }
  float force(double newtons) const { return rate(newtons * scale_); }
  float moment(double newton_meters) const { return rate(newton_meters * scale_ * scale_); }
  b2Vec2 toBox2d(const Eigen::Vector2d& vector) const;
  Eigen::Vector2d toEigen(const b2Vec2& vector) const;
  Eigen::Vector2d roundedVector(const Eigen::Vector2d& vector) const { return toEigen(toBox2d(vector)); }

  Physics physics_;
  Box2dParameters parameters_;
  double scale_;  ///< [1/m] lengths of Box2D in a meter
  double step_;   ///< [s] what Box2D is told of a substep's length
  b2World world_;
  b2Body* table_ = nullptr;
  b2Body* pusher_ = nullptr;
  b2Body* tee_ = nullptr;
  b2MotorJoint* motor_ = nullptr;  ///< of the pusher; none with a servo
  std::vector<NamedBody> bodies_;  ///< those that move
};

}  // namespace pusht::box2d
