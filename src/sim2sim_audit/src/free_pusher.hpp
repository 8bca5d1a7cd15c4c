// SPDX-License-Identifier: BSD-3-Clause
/// The pusher alone on its part of the table.
#pragma once

#include <Eigen/Core>
#include <array>

#include "sim2sim_audit/bench.hpp"

namespace sim2sim::free_pusher {

constexpr double kCommand = 0.25;  ///< [m/s] well within every limit
inline const std::array<Eigen::Vector2d, 2> kAxes = {Eigen::Vector2d(1.0, 0.0), Eigen::Vector2d(0.0, 1.0)};

/// The pusher at rest, 0.28 m from the middle towards `side` along the axes of the table; the tee is out of its way.
pusht::WorldState startFor(const Bench& bench, const Eigen::Vector2d& side);

/// [s] Distance that the pusher coasts under the command 0, per initial velocity along `axis`. For a servo without
/// delay and limit it is mass / (gain + damping), whatever the integrator's substep, if it is implicit.
double timeConstant(Bench& bench, const Eigen::Vector2d& axis);

/// [m] Distance that the pusher moves along `axis` in three control steps from a velocity [m/s], under a command.
double travel(Bench& bench, const Eigen::Vector2d& axis, double velocity, double command);
constexpr int kTravelSteps = 3;

}  // namespace sim2sim::free_pusher
