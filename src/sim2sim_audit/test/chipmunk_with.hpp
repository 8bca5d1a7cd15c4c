// SPDX-License-Identifier: BSD-3-Clause
/// Worlds of Chipmunk with other numbers in the scene, other laws, or other substeps.
#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <memory>

#include "chipmunk_scene.hpp"
#include "chipmunk_world.hpp"
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
  return [physics] {
    return std::make_unique<pusht::ChipmunkWorld>(
        [physics] { return std::make_unique<pusht::chipmunk::Scene>(pusht::ChipmunkParameters(), physics); });
  };
}

/// A choice of the mapping made as Chipmunk's users make it.
inline WorldFactory chipmunkWithout(bool pusht::ChipmunkSwitches::*choice) {
  pusht::ChipmunkParameters parameters;
  parameters.switches.*choice = false;
  return [parameters] { return std::make_unique<pusht::ChipmunkWorld>(parameters); };
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
struct DragAtTheCenter : pusht::chipmunk::Scene {
  explicit DragAtTheCenter(const pusht::ChipmunkParameters& parameters) : Scene(parameters, moved(parameters)) {}

  /// The mass that makes the damping implicit sits where the damping acts.
  static Physics moved(const pusht::ChipmunkParameters& parameters) {
    Physics physics;
    const double added = parameters.substep * physics.tee_damping;  // [kg]
    physics.tee_first_moment += added * pusht::kCenterOfMassOffset;
    physics.tee_second_moment += added * pusht::kCenterOfMassOffset * pusht::kCenterOfMassOffset;
    return physics;
  }
  void addDryFriction() override {
    const cpVect center = cpv(0.0, -pusht::kCenterOfMassOffset);
    const double far = 1000.0;  // [m]
    addFriction(cpGrooveJointNew(table(), tee(), cpv(0.0, -far), cpv(0.0, far), center), physics().tee_friction[0]);
    addFriction(cpGrooveJointNew(table(), tee(), cpv(-far, 0.0), cpv(far, 0.0), center), physics().tee_friction[1]);
    addFriction(cpSimpleMotorNew(table(), tee(), 0.0), physics().tee_yaw_friction);
  }
  void applyForces(const cpVect& command) override {
    applyServo(command);
    cpBodySetForce(tee(), cpvmult(cpBodyGetVelocity(tee()), -physics().tee_damping));
    cpBodySetTorque(tee(), -physics().tee_yaw_damping * cpBodyGetAngularVelocity(tee()));
  }
};

/// Friction of the table with one limit in all directions.
struct FrictionOfADisc : pusht::chipmunk::Scene {
  using Scene::Scene;
  void addDryFriction() override {
    addFriction(cpPivotJointNew2(table(), tee(), cpvzero, cpvzero), physics().tee_friction[0]);
    addFriction(cpSimpleMotorNew(table(), tee(), 0.0), physics().tee_yaw_friction);
  }
};

/// Contacts that give half of the velocity back.
struct Bouncing : pusht::chipmunk::Scene {
  using Scene::Scene;
  void applyForces(const cpVect& command) override {
    const auto set = [](cpShape* shape, void* /*none*/) {
      cpShapeSetElasticity(shape, std::sqrt(0.5));  // Chipmunk multiplies those of two shapes
    };
    cpSpaceEachShape(cpBodyGetSpace(tee()), set, nullptr);
    Scene::applyForces(command);
  }
};

/// One wall 5 mm too far out.
struct WallTooFar : pusht::chipmunk::Scene {
  using Scene::Scene;
  void addWalls() override {
    for (pusht::PlacedBox wall : pusht::wallBoxes(physics())) {
      if (wall.x > 0.0) {
        wall.x += 0.005;
      }
      addBox(table(), wall);
    }
  }
};

template <class FaultyScene>
inline WorldFactory chipmunkOf() {
  return [] {
    return std::make_unique<pusht::ChipmunkWorld>(
        [] { return std::make_unique<FaultyScene>(pusht::ChipmunkParameters()); });
  };
}

/// A world of Chipmunk that counts its own substeps.
class ChipmunkOfSubsteps : public pusht::Simulator {
 public:
  /// `held`: substeps after which the command becomes 0.
  explicit ChipmunkOfSubsteps(int substeps, int held = std::numeric_limits<int>::max())
      : Simulator("", pusht::ChipmunkWorld::kStartTolerance), substeps_(substeps), held_(held) {}

 private:
  void doReset(const WorldState& state) override {
    scene_ = std::make_unique<pusht::chipmunk::Scene>(pusht::ChipmunkParameters());
    scene_->start(state);
  }
  void doStep(const pusht::Action& action) override {
    for (int i = 0; i < substeps_; ++i) {
      scene_->substep(i < held_ ? cpv(action[0], action[1]) : cpvzero);
    }
  }
  WorldState doState() const override { return scene_->state(); }

  int substeps_;
  int held_;
  std::unique_ptr<pusht::chipmunk::Scene> scene_;
};

}  // namespace sim2sim::testing
