// SPDX-License-Identifier: BSD-3-Clause
/// An engine between the two-mass engine and MuJoCo: a rigid tee, and a switch for each modelling choice in which the
/// two differ. With all switches on it is MuJoCo's physics of this scene.
#pragma once

#include <cstddef>

#include "pusht_engine/planar_simulator.hpp"
#include "pusht_engine/rigid_body_dynamics.hpp"
#include "pusht_engine/rigid_body_model.hpp"

namespace pusht {

/// The physics, as PlanarSimulator wants it.
struct RigidBodyPhysics {
  using Parameters = RigidBodyParameters;
  using Model = rigid_body::Model;
  template <class Real>
  using Bodies = rigid_body::Bodies<Real>;

  static constexpr double kStartTolerance = 1e-12;

  static Model modelOf(const RigidBodyParameters& parameters) { return rigid_body::modelOf(parameters); }
  static Bodies<double> bodiesOf(const WorldState& state);
  static WorldState stateOf(const Bodies<double>& bodies);

  template <class Real>
  static void substep(const Model& model, const simd::Vector2<Real>& command, Bodies<Real>& bodies) {
    rigid_body::substep(model, command, bodies);
  }

  template <class One, class Many, class Function>
  static void forEachNumber(One& one, Many& many, Function function) {
    for (std::size_t i = 0; i < rigid_body::kCoordinateCount; ++i) {
      function(one.positions[i], many.positions[i]);
      function(one.velocities[i], many.velocities[i]);
    }
  }
};

extern template class PlanarSimulator<RigidBodyPhysics>;
extern template class PlanarLanes<RigidBodyPhysics>;

using RigidBodyEngine = PlanarSimulator<RigidBodyPhysics>;

/// The same engine for many worlds.
using RigidBodyLanes = PlanarLanes<RigidBodyPhysics>;

}  // namespace pusht
