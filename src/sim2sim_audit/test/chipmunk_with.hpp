// SPDX-License-Identifier: BSD-3-Clause
/// Worlds of Chipmunk with other numbers in the scene, other laws, or other substeps.
#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <memory>

#include "chipmunk_scene.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/physics.hpp"
#include "sim2sim_audit/bench.hpp"

namespace sim2sim::testing {

using pusht::Physics;
using pusht::WorldState;

using ChangePhysics = std::function<void(Physics&)>;

inline WorldFactory chipmunkWith(const ChangePhysics& change) {
  Physics physics;
  change(physics);
  return [physics] { return pusht::worldOf<pusht::ChipmunkScene>({}, physics); };
}

/// A choice of the mapping made as Chipmunk's users make it.
inline WorldFactory chipmunkWithout(bool pusht::ChipmunkParameters::*choice) {
  pusht::ChipmunkParameters parameters;
  parameters.*choice = false;
  return [parameters] { return pusht::worldOf<pusht::ChipmunkScene>(parameters); };
}

inline ChangePhysics scaled(double Physics::*number, double factor) {
  return [=](Physics& physics) { physics.*number *= factor; };
}

/// The tee's moment about its origin, of a moment about the center of mass that is so many times the task's.
inline void scaleMomentAboutCenter(Physics& physics, double factor) {
  const double of_offset = physics.tee_mass * physics.centerOfMass() * physics.centerOfMass();
  physics.tee_second_moment = of_offset + factor * (physics.tee_second_moment - of_offset);
}

/// Shifts the center of mass, and keeps the moment about it.
inline void shiftCenterOf(Physics& physics, double along_minus_y) {
  const double before = physics.centerOfMass();
  const double after = before + along_minus_y;
  physics.tee_first_moment = physics.tee_mass * after;
  physics.tee_second_moment += physics.tee_mass * (after * after - before * before);
}

/// Friction and damping at the center of mass, as engines have them ready-made.
struct DragAtTheCenter : pusht::ChipmunkScene {
  /// The mass that makes the damping implicit sits where the damping acts.
  DragAtTheCenter(const pusht::ChipmunkParameters& parameters, Physics physics)
      : ChipmunkScene(parameters, moved(parameters.substep * physics.tee_damping, physics)) {}

  /// Physics with so much added mass [kg] moved to the center of mass.
  static Physics moved(double added, Physics physics) {
    physics.tee_first_moment += added * pusht::kCenterOfMassOffset;
    physics.tee_second_moment += added * pusht::kCenterOfMassOffset * pusht::kCenterOfMassOffset;
    return physics;
  }
  void addTableFriction() override { addFrictionPerAxis({0.0, -pusht::kCenterOfMassOffset}); }
  void applyDrag() override { applyDragAt({0.0, -pusht::kCenterOfMassOffset}); }
};

/// Friction of the table with one limit in all directions.
struct FrictionOfADisc : pusht::ChipmunkScene {
  using ChipmunkScene::ChipmunkScene;
  void addTableFriction() override {
    addFriction(cpPivotJointNew2(table(), tee(), cpvzero, cpvzero), physics().tee_friction[0]);
    addFriction(cpSimpleMotorNew(table(), tee(), 0.0), physics().tee_yaw_friction);
  }
};

/// Contacts that give half of the velocity back.
struct Bouncing : pusht::ChipmunkScene {
  using ChipmunkScene::ChipmunkScene;
  WorldState start(const WorldState& state) override {
    WorldState result = ChipmunkScene::start(state);
    const auto set = [](cpShape* shape, void* /*none*/) {
      cpShapeSetElasticity(shape, std::sqrt(0.5));  // Chipmunk multiplies those of two shapes
    };
    cpSpaceEachShape(cpBodyGetSpace(tee()), set, nullptr);
    return result;
  }
};

/// One wall 5 mm too far out.
struct WallTooFar : pusht::ChipmunkScene {
  using ChipmunkScene::ChipmunkScene;
  void addWall(const pusht::PlacedBox& box) override {
    pusht::PlacedBox wall = box;
    wall.x += wall.x > 0.0 ? 0.005 : 0.0;
    ChipmunkScene::addWall(wall);
  }
};

template <class FaultyScene>
inline WorldFactory chipmunkOf() {
  return [] { return pusht::worldOf<FaultyScene>(); };
}

/// A world of Chipmunk that counts its own substeps.
class ChipmunkOfSubsteps : public pusht::Simulator {
 public:
  /// `held`: substeps after which the command becomes 0.
  explicit ChipmunkOfSubsteps(int substeps, int held = std::numeric_limits<int>::max())
      : Simulator("", pusht::ChipmunkScene::kStartTolerance), substeps_(substeps), held_(held) {}

 private:
  void doReset(const WorldState& state) override {
    scene_ = std::make_unique<pusht::ChipmunkScene>(pusht::ChipmunkParameters());
    scene_->start(state);
  }
  void doStep(const pusht::Action& action) override {
    for (int i = 0; i < substeps_; ++i) {
      scene_->substep(i < held_ ? Eigen::Vector2d(action[0], action[1]) : Eigen::Vector2d(0.0, 0.0));
    }
  }
  WorldState doState() const override { return scene_->state(); }

  int substeps_;
  int held_;
  std::unique_ptr<pusht::ChipmunkScene> scene_;
};

}  // namespace sim2sim::testing
