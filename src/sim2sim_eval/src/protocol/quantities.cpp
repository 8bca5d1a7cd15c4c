// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/protocol/quantities.hpp"

#include "sim2sim_eval/protocol/divergence.hpp"

namespace sim2sim {

double finalPositionError(const pusht::Rollout& rollout, const pusht::Trace& /*reference*/) {
  return rollout.error().position;
}

double finalAngleError(const pusht::Rollout& rollout, const pusht::Trace& /*reference*/) {
  return rollout.error().angle;
}

double meanPositionDivergence(const pusht::Rollout& rollout, const pusht::Trace& reference) {
  return meanDivergence(reference, rollout.trace()).position;
}

double meanAngleDivergence(const pusht::Rollout& rollout, const pusht::Trace& reference) {
  return meanDivergence(reference, rollout.trace()).angle;
}

}  // namespace sim2sim
