// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/quantities.hpp"

#include <algorithm>
#include <cmath>

#include "sim2sim_protocol/divergence.hpp"
#include "sim2sim_protocol/first_divergence.hpp"

namespace sim2sim {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr Divergence kNoDivergence{kNone, kNone};

const std::vector<pusht::WorldState>& statesOf(const RolloutView& view) { return view.rollout.trace().states; }

/// Steps that both have, the initial state included.
std::size_t commonSteps(const RolloutView& view) {
  return std::min(statesOf(view).size(), view.reference.states.size());
}

/// Over the first kEarlySteps, if both have them.
Divergence earlyDivergence(const RolloutView& view) {
  constexpr std::size_t kCount = kEarlySteps + 1;
  if (commonSteps(view) < kCount) {
    return kNoDivergence;
  }
  Divergence sum;
  for (std::size_t k = 0; k < kCount; ++k) {
    sum += divergence(view.reference.states[k], statesOf(view)[k]);
  }
  return sum / kCount;
}

Divergence nullDivergence(const RolloutView& view) {
  Divergence sum;
  std::size_t rest = 0;  // where the tee that does not move is
  for (std::size_t k = 0; k < commonSteps(view); ++k) {
    sum += divergence(view.reference.states[k], view.reference.states[rest]);
    if (view.reset_every > 0 && k % static_cast<std::size_t>(view.reset_every) == 0) {
      rest = k;
    }
  }
  return sum / commonSteps(view);
}

/// Divergence of the replay minus that of the closed loop.
Divergence absorbed(const RolloutView& view) {
  const std::size_t count = std::min(commonSteps(view), view.replay->states.size());
  Divergence replay;
  Divergence closed;
  for (std::size_t k = 0; k < count; ++k) {
    replay += divergence(view.reference.states[k], view.replay->states[k]);
    closed += divergence(view.reference.states[k], statesOf(view)[k]);
  }
  return Divergence{replay.position - closed.position, replay.angle - closed.angle} / count;
}

Divergence anchorError(const RolloutView& view) {
  const auto every = static_cast<std::size_t>(view.reset_every);
  Divergence sum;
  std::size_t count = 0;
  for (std::size_t k = every; k < commonSteps(view); k += every) {
    sum += divergence(view.reference.states[k], statesOf(view)[k]);
    ++count;
  }
  return count == 0 ? kNoDivergence : sum / count;
}

}  // namespace

double finalPositionError(const RolloutView& view) { return view.rollout.error().position; }
double finalAngleError(const RolloutView& view) { return view.rollout.error().angle; }

double meanPositionDivergence(const RolloutView& view) {
  return meanDivergence(view.reference, view.rollout.trace()).position;
}
double meanAngleDivergence(const RolloutView& view) {
  return meanDivergence(view.reference, view.rollout.trace()).angle;
}

double earlyPositionDivergence(const RolloutView& view) { return earlyDivergence(view).position; }
double earlyAngleDivergence(const RolloutView& view) { return earlyDivergence(view).angle; }

double nullPositionDivergence(const RolloutView& view) { return nullDivergence(view).position; }
double nullAngleDivergence(const RolloutView& view) { return nullDivergence(view).angle; }

double growthRateOf(const RolloutView& view) { return growthRate(view.reference, view.rollout.trace()); }

double absorbedPositionDivergence(const RolloutView& view) { return absorbed(view).position; }
double absorbedAngleDivergence(const RolloutView& view) { return absorbed(view).angle; }

double anchorPositionError(const RolloutView& view) { return anchorError(view).position; }
double anchorAngleError(const RolloutView& view) { return anchorError(view).angle; }

}  // namespace sim2sim
