// SPDX-License-Identifier: BSD-3-Clause
/// The tee alone on its table as a few numbers, to be fitted to what a world's tee does.
#pragma once

#include <Eigen/Core>

#include "pusht_task/physics.hpp"
#include "pusht_task/types.hpp"

namespace sim2sim {

/// How an engine computes the motion of a tee. Damping acts at the end of a substep in all of them.
enum class TeeIntegrator {
  kJoints,          ///< velocities of the origin; friction at rest gives way as MuJoCo's constraints do
  kImplicitJoints,  ///< the same, with centrifugal forces at the end of the substep, as MuJoCo's `implicit`
  kBody             ///< velocities of the center of mass, as engines of rigid bodies do; friction at rest holds
};

/// Parts of the model that are no numbers.
struct TeeModelForm {
  TeeIntegrator integrator = TeeIntegrator::kImplicitJoints;
  bool disc_friction = false;    ///< one limit in every direction; else one along each axis of the table
  int substeps = 10;             ///< in a control step
  bool smooth_friction = false;  ///< fades as tanh(speed / smoothing); else Coulomb's, which holds at rest
  bool moves_first = false;  ///< bodies move in a substep before their velocities change, as Chipmunk's do; of kBody
};

/// Numbers of a tee, per its mass: no motion of a tee alone shows more. Points are on the body's axis, as distances
/// from the tee origin along body -y.
struct TeeNumbers {
  static constexpr Eigen::Index kCount = 11;
  using Vector = Eigen::Matrix<double, kCount, 1>;

  double center_of_mass;  ///< [m]
  double moment;          ///< [m^2] of inertia about the center of mass
  double damping;         ///< [1/s]
  double yaw_damping;     ///< [m^2/s]
  double friction_x;      ///< [m/s^2] Coulomb, along each axis of the table; of a disc, its limit is their mean
  double friction_y;      ///< [m/s^2]
  double yaw_friction;    ///< [m^2/s^2]
  double damping_point;   ///< [m]
  double friction_point;  ///< [m]
  double smoothing;       ///< [m/s] of friction that is smooth
  double yaw_smoothing;   ///< [rad/s]

  /// Numbers of a task of this physics.
  static TeeNumbers of(const pusht::Physics& physics);

  /// Multiples of typical numbers, for a solver.
  Vector toVector() const;
  static TeeNumbers fromVector(const Vector& vector);
  /// Typical numbers, in the order of the vector.
  static Vector scale();
};

/// Pose and velocity of a tee.
struct TeeMotion {
  Eigen::Vector3d pose;      ///< [m, m, rad] the yaw is not wrapped
  Eigen::Vector3d velocity;  ///< per second

  static TeeMotion of(const pusht::WorldState& state);
};

/// Motion a control step later: Newton and Euler, friction by Gauss-Seidel.
TeeMotion controlStep(const TeeNumbers& numbers, const TeeModelForm& form, TeeMotion motion);

}  // namespace sim2sim
