// SPDX-License-Identifier: BSD-3-Clause
#include "buttons.hpp"

namespace pusht_rviz {
namespace {

std::string whyNoStart(const Situation& situation) {
  if (!situation.reachable || !situation.compares) {
    return "waiting for the evaluator";
  }
  if (situation.busy || situation.asked) {
    return "a run is under way: cancel it, or wait for its end";
  }
  return situation.waits_for.empty() ? situation.refusal : situation.waits_for;
}

}  // namespace

Buttons buttonsFor(const Situation& situation) {
  const bool plays = situation.busy || situation.replay;
  Buttons buttons;
  buttons.why_not = whyNoStart(situation);
  buttons.start = !situation.replay && buttons.why_not.empty();
  buttons.resumes = situation.paused;
  buttons.pause = situation.reachable && (plays || situation.paused);
  buttons.step = situation.reachable && plays && situation.paused;
  buttons.cancel = situation.reachable && situation.busy && !situation.replay && !situation.cancelling;
  buttons.rate = situation.reachable;
  return buttons;
}

}  // namespace pusht_rviz
