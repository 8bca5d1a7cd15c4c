// SPDX-License-Identifier: BSD-3-Clause
/// Divergence of two worlds: the difference of their tees' poses.
#pragma once

#include <cstddef>
#include <vector>

#include "pusht_task/rollout.hpp"

namespace sim2sim {

/// Difference of two tee poses, or a mean of such differences.
struct Divergence {
  double position = 0.0;  ///< [m] distance of the tee origins
  double angle = 0.0;     ///< [rad] absolute difference of the yaws, wrapped, in [0, pi]

  Divergence& operator+=(const Divergence& other);
  Divergence operator/(std::size_t count) const;
};

/// Divergence of two states.
Divergence divergence(const pusht::WorldState& a, const pusht::WorldState& b);

/// Divergence at every step that both traces have, the initial state included.
std::vector<Divergence> divergenceBySteps(const pusht::Trace& a, const pusht::Trace& b);

/// Mean divergence over the steps that both traces have, the initial state included.
Divergence meanDivergence(const pusht::Trace& a, const pusht::Trace& b);

}  // namespace sim2sim
