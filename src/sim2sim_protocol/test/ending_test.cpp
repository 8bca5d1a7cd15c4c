// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/ending.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>

#include "pusht_mujoco/mujoco_world.hpp"
#include "pusht_task/loop.hpp"
#include "sim2sim_protocol/first_divergence.hpp"
#include "sim2sim_protocol/results/endings.hpp"
#include "sim2sim_protocol/results/headline.hpp"

namespace sim2sim {
namespace {

using pusht::WorldState;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr int kSteps = 100;  // of a rollout
const Eigen::Vector2d kAway{0.2, 0.2};

WorldState at(const Eigen::Vector2d& tee, const Eigen::Vector2d& pusher = {0.0, 0.3}, double yaw = 0.0) {
  WorldState state;
  state.tee_position = tee;
  state.tee_yaw = yaw;
  state.pusher_position = pusher;
  return state;
}

/// End of a rollout whose state after k control steps is state(k).
RolloutEnding endOf(const std::function<WorldState(int)>& state, int steps = kSteps) {
  pusht::Trace trace;
  for (int step = 0; step <= steps; ++step) {
    trace.states.push_back(state(step));
  }
  trace.actions.resize(static_cast<std::size_t>(steps));
  return endingOf(pusht::Rollout(trace));
}

/// A tee that moves by a centimeter in each of the first `steps`.
RolloutEnding endOfOneThatMoves(int steps) {
  return endOf([&](int step) { return at(kAway - Eigen::Vector2d(0.01 * std::min(step, steps), 0.0)); });
}

TEST(Ending, ATeeThatHasBeenStillForFiveSecondsIsStuck) {
  const RolloutEnding end = endOfOneThatMoves(12);
  EXPECT_EQ(end.ending, Ending::kStuck);
  EXPECT_EQ(end.still_step, 12);
  EXPECT_EQ(end.pusher, PusherEnding::kStill);
  EXPECT_EQ(endOfOneThatMoves(kSteps - kStillSteps).ending, Ending::kStuck);
  EXPECT_EQ(endOfOneThatMoves(kSteps - kStillSteps + 1).ending, Ending::kMoving);
}

TEST(Ending, OfARolloutOfLessThanFiveSecondsIsNotKnown) {
  EXPECT_EQ(endOf([](int) { return at(kAway); }, kStillSteps).ending, Ending::kStuck);
  EXPECT_EQ(endOf([](int) { return at(kAway); }, kStillSteps - 1).ending, Ending::kMoving);
}

TEST(Ending, TurningIsMoving) {
  const auto turned = [](double angle) {
    return endOf([&](int step) { return at(kAway, {0.0, 0.3}, 3.14 + (step < kSteps - 1 ? 0.0 : angle)); }).ending;
  };
  EXPECT_EQ(turned(0.99 * kNoticeable.angle), Ending::kStuck);
  EXPECT_EQ(turned(1.01 * kNoticeable.angle), Ending::kMoving);
}

TEST(Ending, ATeeThatComesBackHasMoved) {
  const RolloutEnding end = endOf([](int step) { return at(step == 70 ? Eigen::Vector2d(0.1, 0.2) : kAway); });
  EXPECT_EQ(end.ending, Ending::kMoving);
  EXPECT_EQ(end.still_step, 71);
}

TEST(Ending, SuccessComesFirstAndThenATeeOffTheTable) {
  EXPECT_EQ(endOf([](int) { return at({0.0, 0.0}); }).ending, Ending::kSuccess);
  const RolloutEnding end = endOf([](int) { return at({0.0, -0.391}); });
  EXPECT_EQ(end.ending, Ending::kLost);
  EXPECT_EQ(end.pusher, PusherEnding::kStill);
}

TEST(Ending, SaysWhatThePusherOfAStuckTeeDoes) {
  const auto pusher = [](const std::function<Eigen::Vector2d(int)>& position) {
    const RolloutEnding end = endOf([&](int step) { return at(kAway, position(step)); });
    EXPECT_EQ(end.ending, Ending::kStuck);
    return end.pusher;
  };
  EXPECT_EQ(pusher([](int step) { return Eigen::Vector2d(0.0, step % 2 == 0 ? 0.3 : 0.3005); }), PusherEnding::kStill);
  EXPECT_EQ(pusher([](int step) { return Eigen::Vector2d(0.0, step % 2 == 0 ? 0.3 : 0.302); }), PusherEnding::kMoving);
  EXPECT_EQ(pusher([](int step) { return Eigen::Vector2d(0.01 * step, 0.3); }), PusherEnding::kLost);
}

/// The bound is far above what a solver does to a tee at rest. One that a pusher leans on is another matter: MuJoCo's
/// friction is soft, so such a tee creeps, and moves.
TEST(Ending, ATeeAtRestIsStillAndOneThatIsLeanedOnCreeps) {
  pusht::MujocoWorld world(std::make_shared<const pusht::MujocoScene>());
  const auto creep = [&](double share_of_friction) {
    const double gap = pusht::kTeeHalfWidth + pusht::kPusherRadius;
    const double lean = share_of_friction * pusht::dynamics::kTeeFriction / pusht::dynamics::kServoGain;  // [m/s]
    pusht::Rollout rollout = begin(world, at({0.0, 0.2}, {0.0, 0.2 + gap + 1e-4}));
    for (int step = 0; step < 2 * kStillSteps; ++step) {
      advance(rollout, world, {0.0F, static_cast<float>(-lean)});
    }
    const std::vector<WorldState>& states = rollout.trace().states;
    return (states.back().tee_position - states[kStillSteps].tee_position).norm();
  };
  EXPECT_LT(creep(0.0), 1e-9);
  EXPECT_GT(creep(0.5), 10.0 * kNoticeable.position);
}

EpisodeResult episode(bool reference, bool engine, Ending ending, PusherEnding pusher, int still_step) {
  EpisodeResult result;
  result.rollouts[kReferenceClosed].success = reference;
  result.rollouts[kEngineClosed].success = engine;
  const auto end = [&](bool success) {
    return success ? RolloutEnding{Ending::kSuccess, 0, PusherEnding::kMoving}
                   : RolloutEnding{ending, still_step, pusher};
  };
  result.rollouts[kReferenceClosed].ending = end(reference);
  result.rollouts[kEngineClosed].ending = end(engine);
  return result;
}

TEST(Endings, AreCountedByRoleAndByPair) {
  const EndingsOfPairs endings = endingsOf({episode(true, true, Ending::kStuck, PusherEnding::kStill, 0),
                                            episode(true, false, Ending::kStuck, PusherEnding::kLost, 30),
                                            episode(true, false, Ending::kMoving, PusherEnding::kMoving, 290),
                                            episode(false, true, Ending::kStuck, PusherEnding::kStill, 50),
                                            episode(false, false, Ending::kStuck, PusherEnding::kMoving, 40),
                                            episode(false, false, Ending::kLost, PusherEnding::kStill, 60)});
  EXPECT_THAT(endings.reference.episodes, ElementsAre(3, 1, 2, 0));
  EXPECT_THAT(endings.engine.episodes, ElementsAre(2, 1, 2, 1));
  EXPECT_THAT(endings.reference.stuck_pushers, ElementsAre(0, 1, 1));
  EXPECT_THAT(endings.engine.stuck_pushers, ElementsAre(1, 0, 1));
  EXPECT_EQ(endings.reference.failures(), 3);
  EXPECT_EQ(endings.reference.median_still_step, 40);
  EXPECT_EQ(endings.engine.median_still_step, 30);
  EXPECT_TRUE(endings.reference.areMostlyStuck());
  EXPECT_FALSE(endings.engine.areMostlyStuck()) << "half are not most";
  EXPECT_EQ(endings.only_reference_engine_stuck, 1);
  EXPECT_EQ(endings.only_engine_reference_stuck, 1);
  EXPECT_EQ(endings.neither_reference_stuck, 1);
  EXPECT_EQ(endings.neither_engine_stuck, 1);
  const nlohmann::json json = toJson(endings.reference, true);
  EXPECT_EQ(json.at("failures"), 3);
  EXPECT_EQ(json.at("stuck").at("share"), 0.666667);
  EXPECT_EQ(json.at("stuck_pusher_still").at("episodes"), 1);
}

TEST(Endings, WithoutFailuresThereIsNoShare) {
  const Endings endings = endingsOf({episode(true, true, Ending::kStuck, PusherEnding::kStill, 0)}, kEngineClosed);
  EXPECT_FALSE(endings.areMostlyStuck());
  EXPECT_FALSE(endings.median_still_step);
  EXPECT_FALSE(toJson(endings, true).at("stuck").contains("share"));
}

RunConfiguration configuration(const char* loop) {
  RunConfiguration made;
  made.protocol.episodes = 40;
  made.reference = {"mujoco", "MuJoCo"};
  made.engine = {"two_mass", "two-mass engine"};
  pusht::ParameterSet set = pusht::plainLoop();
  if (loop != nullptr) {
    set.set("preset", loop);
  }
  made.reference.add(set);
  made.engine.add(set);
  return made;
}

TEST(Endings, StandBeforeTheAnswerWhereMostFailuresAreStuck) {
  EndingsOfPairs endings;
  endings.reference.episodes = {30, 0, 6, 4};
  endings.engine.episodes = {10, 2, 14, 14};
  const Outcomes outcomes = outcomesOf(PairTable{5, 25, 5, 5});
  EXPECT_EQ(
      headlineOf(configuration(nullptr), outcomes, endings).caveat,
      "In a loop without noise most failures are stuck, 6 of 10 in MuJoCo: --loop tracker asks again with a sensor's "
      "noise.");
  endings.engine.episodes = {10, 0, 29, 1};
  const Headline headline = headlineOf(configuration("tracker"), outcomes, endings);
  EXPECT_EQ(headline.caveat,
            "Most failures are stuck, 6 of 10 in MuJoCo and 29 of 30 in the two-mass engine: the tee lies still to the "
            "end.");
  endings.reference.episodes = {31, 0, 6, 3};
  EXPECT_EQ(headlineOf(configuration("tracker"), outcomes, endings).caveat.find("MuJoCo"), std::string::npos)
      << "of nine failures nothing is said";
  EXPECT_THAT(headline.answer, HasSubstr(": with this policy in the loop tracker the two-mass engine keeps "));
}

}  // namespace
}  // namespace sim2sim
