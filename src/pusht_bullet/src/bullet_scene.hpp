// SPDX-License-Identifier: BSD-3-Clause
/// PushT as a world of Bullet, the engine behind PyBullet, in double precision.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "pusht_task/scene_kind.hpp"
#include "pusht_task/scene_world.hpp"

namespace pusht {

/// Settings of Bullet's solver, and its idioms as switches. The task's masses, forces and frictions are those of
/// pusht_task.
struct BulletParameters : SceneParameters {
  bool margin = true;            ///< else Bullet's default
  std::int64_t iterations = 50;  ///< of the constraint solver in a substep
  double overlap_rate = 40.0;    ///< [1/s] of an overlap's decay, about that of MuJoCo's contacts
};

/// Scene of Bullet: a planar task in a three-dimensional engine, with the tee's middle at z = 0. The tee is one rigid
/// body of two convex hulls, the pusher a cylinder that does not turn; both move in a plane and turn about z alone.
/// Servo and damping are implicit, as in pusht_task/mapping.hpp. Friction of the table acts along each of its axes:
/// motors of a 6-DoF constraint that hold velocity 0, each with at most so much force.
class BulletScene : public Scene {
 public:
  using Parameters = BulletParameters;
  static constexpr const char* kTitle = "Bullet";
  static constexpr double kStartTolerance = 1e-12;  ///< [m, rad, m/s, rad/s]

  /// Descriptions of all switches: on as in the scene, off as one writes it after Bullet's examples.
  static constexpr std::array kSwitches = {
      Switch<Parameters>{"servo",
                         "the pusher's soft servo, implicit; idiom: a motor of Bullet that holds the velocity, 30 N",
                         &Parameters::servo},
      Switch<Parameters>{"table_friction",
                         "friction along each axis of the table; idiom: gravity, and friction in contacts with a plane",
                         &Parameters::table_friction},
      Switch<Parameters>{"drag",
                         "damping of the tee at its origin, implicit; idiom: Bullet's damping, as far as it goes",
                         &Parameters::drag},
      Switch<Parameters>{"margin",
                         "the tee collides at its faces, from touch on; idiom: Bullet's default margin, 0.04 m around "
                         "it",
                         &Parameters::margin},
  };

  /// Descriptions of the solver's numbers.
  static constexpr std::array kNumbers = {
      SolverNumber<Parameters>{"iterations", "", "sweeps of the constraint solver in a substep",
                               &Parameters::iterations, 1, 1000, "more sweeps make no visible difference"},
      SolverNumber<Parameters>{"overlap_rate", "1/s", "rate at which overlaps go away", &Parameters::overlap_rate, 0.0,
                               100.0, "a substep of 0.01 s then takes all of it away"},
  };

  explicit BulletScene(const BulletParameters& parameters, const Physics& physics = {});

  WorldState start(const WorldState& state) override;
  WorldState state() const override;
  /// Says whether Bullet would turn the tee by less than its rate says.
  std::string faultOfSpeeds() const override;

 protected:
  void addWall(const PlacedBox& box) override;
  void addFrictionPerAxis(const Eigen::Vector2d& point) override;
  void addIdiomaticFriction() override;
  void applyServo(const Eigen::Vector2d& command) override;
  void applyDragAt(const Eigen::Vector2d& point) override;
  void advance() override;

  btRigidBody& tee() const { return *tee_; }

 private:
  using Body = std::unique_ptr<btRigidBody>;
  using Motors = btGeneric6DofSpring2Constraint;

  /// Configuration with room for the few contacts of this task, in place of megabytes at every reset.
  static btDefaultCollisionConstructionInfo smallPools();
  void addTable();
  void addTee(const WorldState& state);
  void addPusher(const WorldState& state);
  btCollisionShape* addHull(double half_x, double half_y);
  /// Makes a body that moves and turns only as `linear` and the moment about z [kg m^2] let it.
  Body makeBody(double mass, double moment, btCollisionShape* shape, const btTransform& pose, const btVector3& linear);
  /// Adds motors that hold velocity 0 between the table and a body, each with at most so much force [N].
  Motors* addMotors(btRigidBody& body, const btTransform& frame, const std::array<double, 2>& force);
  template <class Shape>
  Shape* keep(std::unique_ptr<Shape> shape);

  /// [m] From the tee's center of mass to a point, which counts from its origin; in body axes.
  btVector3 inTheBody(const Eigen::Vector2d& point) const;
  /// [m] The same in table axes.
  btVector3 teeArm(const Eigen::Vector2d& point) const;

  BulletParameters parameters_;
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

}  // namespace pusht
