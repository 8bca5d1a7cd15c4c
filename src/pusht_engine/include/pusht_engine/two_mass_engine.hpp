// SPDX-License-Identifier: BSD-3-Clause
/// The baseline engine: the tee as two point masses on a rigid link, a disc that pushes it.
#pragma once

#include <array>
#include <cstddef>

#include "pusht_engine/planar_simulator.hpp"
#include "pusht_engine/two_mass_dynamics.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/parameters.hpp"

namespace pusht {

/// Parameters of the two-mass engine. two_mass::kParameters has their meaning and range.
struct TwoMassParameters {
  double pusher_mass = 4.0;  ///< [kg]
  double block_damp = 6.0;   ///< [1/s]
  double baumgarte = 40.0;   ///< [rad/s]

  /// Throws InvalidInput with parameter, value, rule and reason, if a substep with them is not stable.
  void validate() const;
};

namespace two_mass {

/// Description of one parameter.
struct Parameter {
  const char* name;
  const char* unit;
  const char* meaning;
  double TwoMassParameters::*value;
  double least;
  double greatest;
  const char* reason;  ///< why the range ends where it does

  ParameterDescriptor descriptor() const;
};

/// Descriptions of all parameters. The course's come first, in the order of its configuration hash. Reasons of the
/// ranges (h: kSubstep):
/// - pusher_mass: any value is stable. The servo does not depend on it, and each contact sweep multiplies the error of
///   the impulses by (n1.n2)^2 m1 m2 / ((m1 + M)(m2 + M)) < 0.006, because both normals are nearly at right angles.
///   Beyond the range nothing changes any more: the pusher has no inertia, or the tee has none.
/// - block_damp: a substep multiplies the velocity by 1 - h block_damp, which must not be negative.
/// - baumgarte: pushed at v = 1 m/s, the link gives way by up to 0.58 v / baumgarte; that is its length at 9.7.
///   Overlap adds to v: up to about 20, a hard push may still close the link. The world then flies apart, which ends
///   the run. The upper end is greatestBaumgarte(0).
inline constexpr std::array kParameters = {
    Parameter{"pusher_mass", "kg", "inertia of the pusher in contact", &TwoMassParameters::pusher_mass, 1e-6, 1e6,
              "beyond that nothing changes"},
    Parameter{"block_damp", "1/s", "viscous drag rate of the tee, in place of table friction",
              &TwoMassParameters::block_damp, 0.0, 100.0, "more would turn the velocity round in every substep"},
    Parameter{"baumgarte", "rad/s", "stabilization frequency of the tee's link", &TwoMassParameters::baumgarte, 10.0,
              82.8, "a softer link closes under a push, a stiffer one shakes itself apart"},
};

/// [rad/s] Stiffest link that is stable with this drag [1/s]. With x = h baumgarte and c = h block_damp, a small
/// error e of its length and its rate u go as u' = (1 - 2x - c) u - (x^2 / h) e, e' = e + h u'. The eigenvalues are
/// inside the unit circle if x^2 + 4x + 2c < 4 (Jury's criterion).
double greatestBaumgarte(double block_damp);

}  // namespace two_mass

/// Physics for PlanarSimulator.
struct TwoMassPhysics {
  using Parameters = TwoMassParameters;
  using Model = two_mass::Model;
  using Bodies = two_mass::Bodies<double>;

  static constexpr double kStartTolerance = 1e-12;

  static Model modelOf(const TwoMassParameters& parameters);
  /// Bodies with the link at rest length.
  static Bodies bodiesOf(const WorldState& state);
  static WorldState stateOf(const Bodies& bodies);
  static int substepsOf(const Model&) { return kSubstepsPerControlStep; }
  static void substep(const Model& model, const Eigen::Vector2d& command, Bodies& bodies);
};

extern template class PlanarSimulator<TwoMassPhysics>;

/// The baseline. It has no walls, no friction and no continuous collision: its simplifications are the point.
using TwoMassEngine = PlanarSimulator<TwoMassPhysics>;

}  // namespace pusht
