// SPDX-License-Identifier: BSD-3-Clause
/// Frictions of a tee that slides without turning, by a closed form.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "sim2sim_audit/bench.hpp"

namespace sim2sim {

/// Viscous and Coulomb friction per mass, from the momentum that slides at several speeds lose in a control step: loss
/// = damping * distance + friction * time, whatever the integrator, as long as the tee still slides. Slides along the
/// line of the tee's two centers do not turn it.
struct SlideLaw {
  double damping;   ///< [1/s]
  double friction;  ///< [m/s^2]
  double rest;      ///< [m/s] root mean square of the lost velocity that the law does not explain
};

/// Law of slides along `direction` (a unit vector in the table frame). None if no two slides stay on the table and
/// are still under way after a step.
std::optional<SlideLaw> slideLaw(Bench& bench, const Eigen::Vector2d& direction);

/// Laws along x, along y and askew, at 45 degrees.
using SlideLaws = std::array<std::optional<SlideLaw>, 3>;
SlideLaws slideLaws(Bench& bench);

/// [-] Coulomb friction askew over that along an axis: 1 for a disc, the root of 2 for a limit along each axis. None
/// where slides do not tell.
std::optional<double> shapeOf(const SlideLaws& slides);

}  // namespace sim2sim
