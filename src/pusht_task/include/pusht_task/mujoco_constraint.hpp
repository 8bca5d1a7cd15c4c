// SPDX-License-Identifier: BSD-3-Clause
/// MuJoCo's soft constraints, with the defaults of solref and solimp: chapter "Computation" of its documentation.
#pragma once

namespace pusht::mujoco_constraint {

constexpr double kTimeConstant = 0.02;                               ///< [s] its damping ratio is 1
constexpr double kImpedance = 0.9;                                   ///< [-] at no violation
constexpr double kMostImpedance = 0.95;                              ///< [-] from a violation of kWidth on
constexpr double kWidth = 0.001;                                     ///< [m]
constexpr double kDamping = 2.0 / (kMostImpedance * kTimeConstant);  ///< [1/s]
constexpr double kStiffness = 0.25 * kDamping * kDamping;            ///< [1/s^2]

/// [-] Compliance in units of the inverse inertia.
constexpr double complianceOf(double impedance) { return (1.0 - impedance) / impedance; }

}  // namespace pusht::mujoco_constraint
