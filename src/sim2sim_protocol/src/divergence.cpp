// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/divergence.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace sim2sim {

Divergence& Divergence::operator+=(const Divergence& other) {
  position += other.position;
  angle += other.angle;
  return *this;
}

Divergence Divergence::operator/(std::size_t count) const {
  const auto n = static_cast<double>(count);
  return {position / n, angle / n};
}

Divergence divergence(const pusht::WorldState& a, const pusht::WorldState& b) {
  return {(a.tee_position - b.tee_position).norm(), std::abs(pusht::wrapAngle(a.tee_yaw - b.tee_yaw))};
}

std::vector<Divergence> divergenceBySteps(const pusht::Trace& a, const pusht::Trace& b) {
  std::vector<Divergence> steps(std::min(a.states.size(), b.states.size()));
  for (std::size_t k = 0; k < steps.size(); ++k) {
    steps[k] = divergence(a.states[k], b.states[k]);
  }
  return steps;
}

Divergence meanDivergence(const pusht::Trace& a, const pusht::Trace& b) {
  Divergence sum;
  const std::vector<Divergence> steps = divergenceBySteps(a, b);
  for (const Divergence& step : steps) {
    sum += step;
  }
  return sum / steps.size();
}

}  // namespace sim2sim
