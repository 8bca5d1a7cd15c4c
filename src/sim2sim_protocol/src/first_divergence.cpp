// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/first_divergence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "pusht_task/contact.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"

namespace sim2sim {
namespace {

using pusht::Part;
using pusht::WorldState;

void requirePositive(const char* field, double value, const char* unit) {
  if (!(std::isfinite(value) && value > 0.0)) {
    throw pusht::InvalidInput(std::string("bound ") + field + " " + pusht::shortestText(value) +
                              ": must be finite and above 0 [" + unit + "]");
  }
}

bool passes(const Divergence& divergence, const Bound& bound) { return bound.used(divergence) > 1.0; }

Cause causeOnBox(Part box, const WorldState& before, const WorldState& after, const pusht::Task& task) {
  const bool sliding = std::abs(pusht::slipDistance(before, after, box, task)) > kSlidingSpeed * pusht::kControlStep;
  if (box == Part::kBar) {
    return sliding ? Cause::kSlidingOnBar : Cause::kStickingOnBar;
  }
  return sliding ? Cause::kSlidingOnStem : Cause::kStickingOnStem;
}

/// Which body is noticeably elsewhere; none: neither.
std::optional<FirstBody> apart(const WorldState& a, const WorldState& b, const Bound& noticeable) {
  const bool pusher = (a.pusher_position - b.pusher_position).norm() > noticeable.position;
  const bool tee = passes(divergence(a, b), noticeable);
  if (!pusher && !tee) {
    return std::nullopt;
  }
  return pusher && tee ? FirstBody::kBoth : pusher ? FirstBody::kPusher : FirstBody::kTee;
}

}  // namespace

void Bound::validate() const {
  requirePositive("position", position, "m");
  requirePositive("angle", angle, "rad");
}

double Bound::used(const Divergence& divergence) const {
  return std::max(divergence.position / position, divergence.angle / angle);
}

Cause causeIn(const WorldState& before, const WorldState& after, const pusht::Task& task) {
  if (pusht::wallGapsOf(before, task).touches() || pusht::wallGapsOf(after, task).touches()) {
    return Cause::kWall;
  }
  const Part start = pusht::contactsOf(before, task).part();
  const Part end = pusht::contactsOf(after, task).part();
  if (start == Part::kNone && end == Part::kNone) {
    return passes(divergence(before, after), kNoticeable) ? Cause::kTeeAlone : Cause::kFree;
  }
  if (end == Part::kNone) {
    return Cause::kContactEnds;
  }
  switch (const Part throughout = pusht::common(start, end)) {
    case Part::kNone:
      return Cause::kContactBegins;
    case Part::kCorner:
      return Cause::kCorner;
    default:
      return causeOnBox(throughout, before, after, task);
  }
}

std::optional<FirstDivergence> firstDivergenceOf(const pusht::Trace& reference, const pusht::Trace& other,
                                                 const Bound& bound, const pusht::Task& task) {
  bound.validate();
  const Bound noticeable{std::min(kNoticeable.position, bound.position), std::min(kNoticeable.angle, bound.angle)};
  const std::size_t states = std::min(reference.states.size(), other.states.size());
  std::optional<FirstBody> first;
  for (std::size_t step = 1; step < states; ++step) {
    const WorldState& ours = reference.states[step];
    const WorldState& theirs = other.states[step];
    first = first ? first : apart(ours, theirs, noticeable);
    if (first && passes(divergence(ours, theirs), bound)) {
      return FirstDivergence{static_cast<int>(step), causeIn(reference.states[step - 1], ours, task), *first};
    }
  }
  return std::nullopt;
}

double growthRate(const pusht::Trace& reference, const pusht::Trace& other, const Bound& bound) {
  bound.validate();
  std::vector<double> used;  // up to where the difference vanishes or passes the bound
  for (const Divergence& step : divergenceBySteps(reference, other)) {
    const double share = bound.used(step);
    if (share == 0.0) {
      break;
    }
    used.push_back(std::min(share, 1.0));
    if (share > 1.0) {
      break;
    }
  }
  if (used.size() < 2) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  return std::log(used.back() / used.front()) / static_cast<double>(used.size() - 1);
}

}  // namespace sim2sim
