// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/quantities.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "pusht_task/constants.hpp"
#include "pusht_task/gym_pusht.hpp"
#include "pusht_task/task.hpp"
#include "sim2sim_protocol/divergence.hpp"
#include "sim2sim_protocol/first_divergence.hpp"
#include "sim2sim_protocol/pushes.hpp"

namespace sim2sim {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr Divergence kNoDivergence{kNone, kNone};

const std::vector<pusht::WorldState>& statesOf(const RolloutView& view) { return view.rollout.trace().states; }

/// Steps that both have, the initial state included.
std::size_t commonSteps(const RolloutView& view) {
  return std::min(statesOf(view).size(), view.reference.states.size());
}

/// Number of states up to a horizon [control steps]; 0 if either rollout is shorter.
std::size_t statesWithin(const RolloutView& view, int horizon) {
  const auto count = static_cast<std::size_t>(horizon) + 1;
  return commonSteps(view) < count ? 0 : count;
}

/// Over the steps up to a horizon, if both have them.
Divergence earlyDivergence(const RolloutView& view, int horizon) {
  const std::size_t count = statesWithin(view, horizon);
  Divergence sum;
  for (std::size_t k = 0; k < count; ++k) {
    sum += divergence(view.reference.states[k], statesOf(view)[k]);
  }
  return count == 0 ? kNoDivergence : sum / count;
}

/// Over the first `count` states.
Divergence nullDivergence(const RolloutView& view, std::size_t count) {
  Divergence sum;
  std::size_t rest = 0;  // where the tee that does not move is
  for (std::size_t k = 0; k < count; ++k) {
    sum += divergence(view.reference.states[k], view.reference.states[rest]);
    if (view.reset_every > 0 && k % static_cast<std::size_t>(view.reset_every) == 0) {
      rest = k;
    }
  }
  return count == 0 ? kNoDivergence : sum / count;
}

Divergence nullDivergence(const RolloutView& view) { return nullDivergence(view, commonSteps(view)); }

Divergence earlyNullDivergence(const RolloutView& view, int horizon) {
  return nullDivergence(view, statesWithin(view, horizon));
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

PushFigures pushesOf(const RolloutView& view) {
  return pushFigures(view.reference, view.rollout.trace(), view.reset_every, view.rollout.task());
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

double earlyPositionDivergence(const RolloutView& view) { return earlyDivergence(view, kEarlySteps).position; }
double earlyAngleDivergence(const RolloutView& view) { return earlyDivergence(view, kEarlySteps).angle; }
double fiveSecondsPositionDivergence(const RolloutView& view) {
  return earlyDivergence(view, kFiveSecondSteps).position;
}
double fiveSecondsAngleDivergence(const RolloutView& view) { return earlyDivergence(view, kFiveSecondSteps).angle; }

double nullPositionDivergence(const RolloutView& view) { return nullDivergence(view).position; }
double nullAngleDivergence(const RolloutView& view) { return nullDivergence(view).angle; }
double earlyNullPositionDivergence(const RolloutView& view) { return earlyNullDivergence(view, kEarlySteps).position; }
double earlyNullAngleDivergence(const RolloutView& view) { return earlyNullDivergence(view, kEarlySteps).angle; }
double fiveSecondsNullPositionDivergence(const RolloutView& view) {
  return earlyNullDivergence(view, kFiveSecondSteps).position;
}
double fiveSecondsNullAngleDivergence(const RolloutView& view) {
  return earlyNullDivergence(view, kFiveSecondSteps).angle;
}

double largestCoverage(const RolloutView& view) {
  double largest = 0.0;
  for (const pusht::WorldState& state : statesOf(view)) {
    largest = std::max(largest, pusht::coverageOf(state, view.rollout.task()));
  }
  return largest;
}
double finalCoverage(const RolloutView& view) { return pusht::coverageOf(statesOf(view).back(), view.rollout.task()); }

double coveredAtBest(const RolloutView& view) {
  return largestCoverage(view) > pusht::gym_pusht::kSuccessCoverage ? 1.0 : 0.0;
}
double coveredAtEnd(const RolloutView& view) {
  return finalCoverage(view) > pusht::gym_pusht::kSuccessCoverage ? 1.0 : 0.0;
}
double withinWorldModels(const RolloutView& view) {
  constexpr double kPosition = 0.02;                    // [m]
  constexpr double kAngle = 20.0 / 180.0 * pusht::kPi;  // [rad]
  const std::vector<pusht::WorldState>& states = statesOf(view);
  return std::any_of(states.begin(), states.end(),
                     [&](const pusht::WorldState& state) {
                       const pusht::PoseError error = pusht::poseError(state, view.rollout.task());
                       return error.position < kPosition && error.angle < kAngle;
                     })
             ? 1.0
             : 0.0;
}

double growthRateOf(const RolloutView& view) { return growthRate(view.reference, view.rollout.trace()); }

double absorbedPositionDivergence(const RolloutView& view) { return absorbed(view).position; }
double absorbedAngleDivergence(const RolloutView& view) { return absorbed(view).angle; }

double anchorPositionError(const RolloutView& view) { return anchorError(view).position; }
double anchorAngleError(const RolloutView& view) { return anchorError(view).angle; }

double pushDirectionError(const RolloutView& view) { return pushesOf(view).direction_error; }
double pushesMissed(const RolloutView& view) { return pushesOf(view).missed; }
double pushesTurned(const RolloutView& view) { return pushesOf(view).turned; }
double pushSize(const RolloutView& view) { return pushesOf(view).size; }

}  // namespace sim2sim
