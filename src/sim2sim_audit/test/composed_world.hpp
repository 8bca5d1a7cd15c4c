// SPDX-License-Identifier: BSD-3-Clause
/// The rigid-body engine with parts of another engine's physics, several at once: an explicit servo, short substeps,
/// another friction, walls that do not hold the tee.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>

#include "pusht_engine/planar_simulator.hpp"
#include "pusht_engine/rigid_body_engine.hpp"
#include "pusht_task/constants.hpp"
#include "rigid_body_dynamics.hpp"
#include "rigid_body_with.hpp"

namespace sim2sim::testing {

/// Friction of the table on the tee's coordinates [N, N, N m], by its velocities [m/s, m/s, rad/s].
using TableLaw = std::function<Eigen::Vector3d(const Eigen::Vector3d& velocities)>;

/// What a composed world does otherwise.
struct Composition {
  int substeps = 10;                                  ///< in a control step
  bool is_servo_explicit = false;                     ///< force at the velocity at a substep's begin
  bool has_tee_walls = true;                          ///< else only the pusher is held by walls
  TableLaw friction{};                                ///< in place of Coulomb's; empty: Coulomb's
  ChangeRigid change = [](RigidModel& /*model*/) {};  ///< of other constants
};

/// The task's Coulomb friction, smoothed below a speed [m/s] and a yaw rate [rad/s].
inline TableLaw smoothed(double speed, double yaw_rate) {
  return [=](const Eigen::Vector3d& velocities) -> Eigen::Vector3d {
    const Eigen::Vector3d most(pusht::dynamics::kTeeFriction, pusht::dynamics::kTeeFriction,
                               pusht::dynamics::kTeeYawFriction);
    return -most.cwiseProduct(
        Eigen::Vector3d(velocities.array() / Eigen::Array3d(speed, speed, yaw_rate)).array().tanh().matrix());
  };
}

/// Physics for PlanarSimulator.
struct ComposedPhysics : pusht::RigidBodyPhysics {
  using Parameters = Composition;
  struct Model : RigidModel {
    Composition composition;
  };

  static Model modelOf(const Composition& composition) {
    Model model = {pusht::rigid_body::modelOf({}), composition};
    model.substep = pusht::kControlStep / composition.substeps;
    model.switches.coulomb = !composition.friction;
    composition.change(model);
    if (composition.is_servo_explicit) {
      model.servo_derivative = 0.0;
    }
    return model;
  }
  static int substepsOf(const Model& model) { return model.composition.substeps; }

  static void substep(const Model& model, const Eigen::Vector2d& command, Bodies& bodies) {
    using namespace pusht::rigid_body;
    auto& [positions, velocities] = bodies;
    const Tee tee = teeOf(model, positions);
    const Matrix mass = massMatrix(model, tee);
    Vector force = smoothForce(model, tee, mass, bodies, command);
    if (model.composition.friction) {
      Eigen::Map<Eigen::Vector3d>(force.data()) +=
          model.composition.friction(Eigen::Map<const Eigen::Vector3d>(velocities.data()));
    }
    const Vector constraint =
        constraintForce(mass, force, constraintsOf(model, tee, contactsOf(model, tee, positions), velocities));
    for (std::size_t i = 0; i < kCoordinateCount; ++i) {
      force[i] += constraint[i];
    }
    const Vector acceleration = implicitAcceleration(model, tee, mass, velocities, force);
    for (std::size_t i = 0; i < kCoordinateCount; ++i) {
      velocities[i] += model.substep * acceleration[i];
      positions[i] += model.substep * velocities[i];
    }
  }

 private:
  static pusht::rigid_body::Contacts contactsOf(const Model& model, const pusht::rigid_body::Tee& tee,
                                                const pusht::rigid_body::Vector& positions) {
    using namespace pusht::rigid_body;
    Contacts kept;
    for (const Contact& contact : findContacts(model, tee, {positions[kPusherX], positions[kPusherY]})) {
      if (model.composition.has_tee_walls || contact.pair != Pair::kTeeWall) {
        kept.add(contact, contact.pair, contact.multiplicity);
      }
    }
    return kept;
  }
};

inline WorldFactory composed(const Composition& composition) {
  return [composition] { return std::make_unique<pusht::PlanarSimulator<ComposedPhysics>>(composition); };
}

}  // namespace sim2sim::testing
