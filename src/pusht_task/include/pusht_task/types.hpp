// SPDX-License-Identifier: BSD-3-Clause
/// Types that pass between simulators, policies and the protocol.
#pragma once

#include <Eigen/Core>
#include <array>
#include <gsl/span>

namespace pusht {

template <class T>
using Span = gsl::span<T>;

/// Poses and velocities of pusher and tee in the table frame: origin at the target, z up.
struct WorldState {
  Eigen::Vector2d pusher_position = Eigen::Vector2d::Zero();  ///< [m]
  Eigen::Vector2d pusher_velocity = Eigen::Vector2d::Zero();  ///< [m/s]
  Eigen::Vector2d tee_position = Eigen::Vector2d::Zero();     ///< [m] of the tee origin, the bar's center
  Eigen::Vector2d tee_velocity = Eigen::Vector2d::Zero();     ///< [m/s] of the tee origin
  double tee_yaw = 0.0;                                       ///< [rad] in [-pi, pi)
  double tee_yaw_rate = 0.0;                                  ///< [rad/s]
};

/// Bitwise equality of values (0.0 equals -0.0; a NaN equals nothing).
bool operator==(const WorldState& a, const WorldState& b);
bool operator!=(const WorldState& a, const WorldState& b);

/// Commanded pusher velocity x, y [m/s], table axes.
using Action = std::array<float, 2>;

/// Pusher x, y; tee x, y; sin, cos of the tee's yaw; target x, y; sin, cos of its yaw [m, -].
using Observation = std::array<float, 10>;

/// Whether all components are finite.
bool isFinite(const WorldState& state);
/// Whether both components are finite.
bool isFinite(const Action& action);

/// `angle` [rad] wrapped to [-pi, pi); one that lies there already keeps its bits.
double wrapAngle(double angle);

}  // namespace pusht
