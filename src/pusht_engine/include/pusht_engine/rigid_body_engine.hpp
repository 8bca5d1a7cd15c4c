// SPDX-License-Identifier: BSD-3-Clause
/// An engine between the two-mass engine and MuJoCo: a rigid tee, and a switch for each modeling choice in which the
/// two differ. With all switches on it is MuJoCo's physics of the task's scene.
#pragma once

#include "pusht_engine/planar_simulator.hpp"
#include "pusht_engine/rigid_body_model.hpp"
#include "pusht_task/substeps.hpp"

namespace pusht {

/// Physics for PlanarSimulator.
struct RigidBodyPhysics {
  using Parameters = RigidBodyParameters;
  using Model = rigid_body::Model;
  using Bodies = rigid_body::Bodies;

  static constexpr double kStartTolerance = 1e-12;

  static Model modelOf(const RigidBodyParameters& parameters) { return rigid_body::modelOf(parameters); }
  static Bodies bodiesOf(const WorldState& state);
  static WorldState stateOf(const Bodies& bodies);
  static int substepsOf(const Model& model) { return substepsPerControlStep(model.substep); }
  static void substep(const Model& model, const Eigen::Vector2d& command, Bodies& bodies) {
    rigid_body::substep(model, command, bodies);
  }
};

extern template class PlanarSimulator<RigidBodyPhysics>;

using RigidBodyEngine = PlanarSimulator<RigidBodyPhysics>;

}  // namespace pusht
