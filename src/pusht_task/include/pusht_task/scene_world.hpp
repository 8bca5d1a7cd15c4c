// SPDX-License-Identifier: BSD-3-Clause
/// World in an engine by others, which has rigid bodies, boxes and forces that are constant in a substep.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "pusht_task/constants.hpp"
#include "pusht_task/mapping.hpp"
#include "pusht_task/physics.hpp"
#include "pusht_task/simulator.hpp"
#include "pusht_task/types.hpp"

namespace pusht {

/// Parameters that every scene has. A choice of the mapping is on as in the reference's scene, off as users of the
/// engine write it.
struct SceneParameters {
  bool servo = true;           ///< the task's soft servo, implicit in a substep
  bool table_friction = true;  ///< along each axis of the table, where it acts in the task
  bool drag = true;            ///< where the table acts in the task, implicit in a substep
  double substep = kSubstep;   ///< [s] a value of substepDescriptor()
};

/// Bodies, walls and frictions of an episode. Its numbers are data and its laws virtual, so that a test can plant an
/// error in either and see it found. For worldOf(), a kind's scene also has `Parameters`, derived from SceneParameters,
/// a constructor from these and Physics, `kTitle` (the engine's name for people) and `kStartTolerance`
/// (Simulator::startTolerance()).
class Scene {
 public:
  Scene(const SceneParameters& parameters, const Physics& physics) : mapping_(parameters), physics_(physics) {}
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
  virtual ~Scene() = default;

  /// Puts the bodies in, at `state`. Returns what the world's state is until its first step: `state` as the engine can
  /// represent it, so that a start in it changes no bit.
  virtual WorldState start(const WorldState& state) = 0;
  /// Moves on by a substep, with the pusher commanded to a velocity [m/s], or a position of the table frame [m].
  void substep(const Eigen::Vector2d& command);
  /// State of the bodies.
  virtual WorldState state() const = 0;

  /// Says which position of `state` is out of the engine's range; empty if none.
  virtual std::string faultOfPositions(const WorldState& /*state*/) const { return ""; }
  /// Says which body is so fast that the engine slows it down; empty if none.
  virtual std::string faultOfSpeeds() const { return ""; }

 protected:
  /// Add what the task's mapping has; start() of a derived scene calls each once.
  virtual void addWalls();
  virtual void addTableFriction();
  /// Damps the tee in the substep that comes; does nothing with `drag` off, where start() gives the engine's damping.
  virtual void applyDrag();

  virtual void addWall(const PlacedBox& box) = 0;
  /// Adds Coulomb friction along each axis of the table, at a point of the tee [m], and on its yaw.
  virtual void addFrictionPerAxis(const Eigen::Vector2d& point) = 0;
  /// Adds the engine's own friction between table and tee.
  virtual void addIdiomaticFriction() = 0;
  /// Drives the pusher in the substep that comes; with `servo` off, by the engine's own motor.
  virtual void applyServo(const Eigen::Vector2d& command) = 0;
  /// Damps the tee at a point of its body [m] in the substep that comes.
  virtual void applyDragAt(const Eigen::Vector2d& point) = 0;
  /// Solves and moves by a substep.
  virtual void advance() = 0;

  /// Mass of the pusher [kg], enlarged to make its servo implicit; the plain mass with `servo` off.
  double pusherMass() const;
  /// Inertia of the tee, enlarged to make its damping implicit; the plain one with `drag` off.
  TeeInertia teeInertia() const;
  const Physics& physics() const { return physics_; }

 private:
  /// [m] Where the table acts, in the tee's frame.
  Eigen::Vector2d tablePoint() const;

  SceneParameters mapping_;
  Physics physics_;
};

/// One world. Every reset builds its scene anew, because engines remember contacts, impulses and their order. A reset
/// or a substep after which the scene has a fault throws SimulationFault with it.
class SceneWorld : public Simulator {
 public:
  using MakeScene = std::function<std::unique_ptr<Scene>()>;

  /// World of scenes from `make_scene`, of this substep [s]. Name, tolerance and task are those of a Simulator.
  SceneWorld(const std::string& name, double start_tolerance, double substep, MakeScene make_scene,
             const Task& task = fullCircle());

 private:
  void doReset(const WorldState& state) override;
  void doStep(const Action& action) override;
  WorldState doState() const override { return start_ ? *start_ : scene_->state(); }
  void requireNone(const std::string& fault, const char* when) const;

  std::string name_;
  int substeps_;  ///< in a control step
  MakeScene make_scene_;
  std::unique_ptr<Scene> scene_;
  std::optional<WorldState> start_;  ///< until the first step
};

/// World of a kind's scenes, with the kind's parameters, and with `physics` in place of the task's. Engines that a
/// process must make ready are made so by their kind, when it loads a model: outside of a kind, the caller does it
/// first.
template <class SceneOfKind>
std::unique_ptr<SceneWorld> worldOf(const typename SceneOfKind::Parameters& parameters, const Physics& physics,
                                    const Task& task = fullCircle()) {
  return std::make_unique<SceneWorld>(
      SceneOfKind::kTitle, SceneOfKind::kStartTolerance, parameters.substep,
      [parameters, physics] { return std::make_unique<SceneOfKind>(parameters, physics); }, task);
}

/// World of a kind's scenes, likewise, with the task's physics.
template <class SceneOfKind>
std::unique_ptr<SceneWorld> worldOf(const typename SceneOfKind::Parameters& parameters = {},
                                    const Task& task = fullCircle()) {
  return worldOf<SceneOfKind>(parameters, task.physics, task);
}

}  // namespace pusht
