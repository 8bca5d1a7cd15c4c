// SPDX-License-Identifier: BSD-3-Clause
/// How far two traces of the tee are apart.
#pragma once

#include <cstddef>
#include <vector>

#include "pusht_task/rollout.hpp"

namespace sim2sim {

/// Distance of two tees in position and yaw.
struct Divergence {
  double position = 0.0;  ///< [m] distance of the tee origins
  double angle = 0.0;     ///< [rad] absolute difference of the yaws, wrapped, in [0, pi]

  Divergence& operator+=(const Divergence& other);
  Divergence operator/(std::size_t count) const;
};

/// Divergence of the tees of two states.
Divergence divergence(const pusht::WorldState& a, const pusht::WorldState& b);

/// At every step that both traces have, the start included.
std::vector<Divergence> divergenceBySteps(const pusht::Trace& a, const pusht::Trace& b);

/// Mean over the steps that both traces have, the start included.
Divergence meanDivergence(const pusht::Trace& a, const pusht::Trace& b);

}  // namespace sim2sim
