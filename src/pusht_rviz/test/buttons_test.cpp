// SPDX-License-Identifier: BSD-3-Clause
#include "buttons.hpp"

#include <gmock/gmock.h>

namespace pusht_rviz {
namespace {

Situation idle() {
  Situation situation;
  situation.reachable = true;
  situation.compares = true;
  return situation;
}

/// "start pause step cancel", those that can be pressed.
std::string enabled(const Situation& situation) {
  const Buttons buttons = buttonsFor(situation);
  return std::string(buttons.start ? "start " : "") + (buttons.pause ? (buttons.resumes ? "resume " : "pause ") : "") +
         (buttons.step ? "step " : "") + (buttons.cancel ? "cancel " : "");
}

TEST(Buttons, WithoutEvaluatorNothingCanBePressed) {
  EXPECT_EQ(enabled({}), "");
  EXPECT_EQ(buttonsFor({}).why_not, "waiting for the evaluator");
  Situation hangs = idle();
  hangs.reachable = false;
  hangs.busy = true;
  EXPECT_EQ(enabled(hangs), "");
  EXPECT_FALSE(buttonsFor(hangs).rate);
}

TEST(Buttons, ARunCanBeStartedPausedSteppedAndCancelled) {
  Situation situation = idle();
  EXPECT_EQ(enabled(situation), "start ");
  situation.asked = true;
  EXPECT_EQ(enabled(situation), "") << "a second click must not ask again";
  situation.busy = true;
  situation.asked = false;
  EXPECT_EQ(enabled(situation), "pause cancel ");
  situation.paused = true;
  EXPECT_EQ(enabled(situation), "resume step cancel ");
  situation.cancelling = true;
  EXPECT_EQ(enabled(situation), "resume step ");
  situation = idle();
  situation.paused = true;
  EXPECT_EQ(enabled(situation), "start resume ") << "the next run would wait";
}

TEST(Buttons, ARefusalStopsTheStart) {
  Situation situation = idle();
  situation.refusal = "seed 42: must be at least 10000";
  EXPECT_EQ(enabled(situation), "");
  EXPECT_EQ(buttonsFor(situation).why_not, situation.refusal);
}

TEST(Buttons, StartWaitsUntilItIsKnownWhatWouldRun) {
  Situation situation = idle();
  situation.waits_for = "engine: waiting for the node to describe chipmunk";
  EXPECT_EQ(enabled(situation), "");
  EXPECT_EQ(buttonsFor(situation).why_not, situation.waits_for);
}

TEST(Buttons, AReplayIsPlayedAndStepped) {
  Situation situation = idle();
  situation.compares = false;
  situation.replay = true;
  EXPECT_EQ(enabled(situation), "pause ");
  situation.paused = true;
  EXPECT_EQ(enabled(situation), "resume step ");
}

}  // namespace
}  // namespace pusht_rviz
