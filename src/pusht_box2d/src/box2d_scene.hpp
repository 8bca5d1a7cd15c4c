// SPDX-License-Identifier: BSD-3-Clause
/// PushT as a world of Box2D 2.4, which computes in single precision.
#pragma once

#include <box2d/box2d.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "pusht_task/scene_kind.hpp"
#include "pusht_task/scene_world.hpp"

namespace pusht {

/// Settings of Box2D's solver, and the choices of the mapping: false is the idiom, which the tutorials of Box2D have.
/// The task's masses, forces and frictions are those of pusht_task.
struct Box2dParameters : SceneParameters {
  bool scale = true;
  std::int64_t velocity_iterations = 30;  ///< sweeps of the solver over velocities in a substep
  std::int64_t position_iterations = 10;  ///< most sweeps over overlaps in a substep
};

/// Scene of Box2D. The tee is one rigid body of two boxes, the pusher a disc that does not turn. Servo and damping are
/// implicit, as in pusht_task/mapping.hpp. Lengths in Box2D are `scale` times those in meters, so forces are that times
/// those in newtons, and moments its square times those in newton meters.
class Box2dScene : public Scene {
 public:
  using Parameters = Box2dParameters;
  static constexpr const char* kTitle = "Box2D";
  /// [m, rad, m/s, rad/s] Single precision within kReach, and up to 32 rad/s.
  static constexpr double kStartTolerance = 1e-6;
  static constexpr double kReach = 8.0;  ///< [m] |x| or |y| within which bodies must be

  /// Descriptions of all switches.
  static constexpr std::array kSwitches = {
      Switch<Parameters>{"servo",
                         "a soft servo of 20 N s/m up to 30 N, implicit; idiom: a motor joint, as stiff as 30 N allow",
                         &Parameters::servo},
      Switch<Parameters>{"table_friction",
                         "Coulomb friction per axis, at the tee's origin; idiom: a friction joint, a disc, at its "
                         "center of mass",
                         &Parameters::table_friction},
      Switch<Parameters>{"drag", "damping at the tee's origin, implicit; idiom: linear and angular damping of the body",
                         &Parameters::drag},
      Switch<Parameters>{"scale",
                         "lengths times 100, polygons without their skin; idiom: meters as they are, a skin of 0.01 m",
                         &Parameters::scale},
  };

  /// Descriptions of the solver's numbers.
  static constexpr std::array kNumbers = {
      SolverNumber<Parameters>{"velocity_iterations", "", "sweeps over velocities in a substep",
                               &Parameters::velocity_iterations, 1, 1000, "more sweeps make no visible difference"},
      SolverNumber<Parameters>{"position_iterations", "", "most sweeps over overlaps in a substep",
                               &Parameters::position_iterations, 1, 1000, "more sweeps make no visible difference"},
  };

  explicit Box2dScene(const Box2dParameters& parameters, const Physics& physics = {});

  WorldState start(const WorldState& state) override;
  WorldState state() const override;
  /// Says which body is where single precision does not keep the start tolerance.
  std::string faultOfPositions(const WorldState& state) const override;
  /// Says which body is as fast as Box2D lets it, from where on velocities are cut off.
  std::string faultOfSpeeds() const override;

 protected:
  void addWall(const PlacedBox& box) override { addBox(table_, box); }
  void addFrictionPerAxis(const Eigen::Vector2d& point) override;
  void addIdiomaticFriction() override;
  void applyServo(const Eigen::Vector2d& command) override;
  void applyDragAt(const Eigen::Vector2d& point) override;
  void advance() override;

  /// Adds friction of a disc at a point of the tee [m].
  void addFrictionOfDisc(const Eigen::Vector2d& point);

  b2World& world() { return world_; }
  b2Body* table() const { return table_; }
  b2Body* tee() const { return tee_; }

 private:
  struct NamedBody {
    const char* name;
    b2Body* body;
  };

  b2Body* addBody(const char* name, b2BodyDef def, double mass);
  void addPusher(const WorldState& state);
  void addTee(const WorldState& state);
  /// Adds a box, with its skin within its sides if `scale`.
  void addBox(b2Body* body, const PlacedBox& box);
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
  /// `state` in the precision of Box2D's numbers; a second time it changes no bit.
  WorldState rounded(const WorldState& state) const;

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

}  // namespace pusht
