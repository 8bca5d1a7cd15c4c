// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/first_divergence.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "pusht_engine/two_mass_engine.hpp"
#include "pusht_mujoco/mujoco_world.hpp"
#include "pusht_policy/scripted_expert.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_testing/refusal.hpp"

namespace sim2sim {
namespace {

using Eigen::Vector2d;
using pusht::kPi;
using pusht::Trace;
using pusht::WorldState;
using pusht::testing::refusalOf;

const double kNaN = std::nan("");
constexpr double kInfinity = std::numeric_limits<double>::infinity();

WorldState world(const Vector2d& pusher, const Vector2d& tee = {0.0, 0.0}, double yaw = 0.0) {
  WorldState state;
  state.pusher_position = pusher;
  state.tee_position = tee;
  state.tee_yaw = pusht::wrapAngle(yaw);
  return state;
}

/// Turned about the table's origin, then moved.
WorldState transformed(const WorldState& state, double turn, const Vector2d& shift) {
  const Eigen::Rotation2Dd rotation(turn);
  return world(rotation * state.pusher_position + shift, rotation * state.tee_position + shift, state.tee_yaw + turn);
}

Trace traceOf(const std::vector<WorldState>& states) {
  Trace trace;
  trace.states = states;
  trace.actions.resize(states.empty() ? 0 : states.size() - 1);
  return trace;
}

/// A state for each of `values`.
Trace traceOf(const std::vector<double>& values, const std::function<WorldState(double)>& state) {
  std::vector<WorldState> states(values.size());
  std::transform(values.begin(), values.end(), states.begin(), state);
  return traceOf(states);
}

/// A tee that is at `offsets` [m] along x, and a pusher that stays away from it.
Trace teeAt(const std::vector<double>& offsets) {
  return traceOf(offsets, [](double offset) { return world({0.0, 0.3}, {offset, 0.0}); });
}

/// Trace of a tee at rest that is turned from `yaw` by `angles` [rad].
Trace teeTurnedBy(const std::vector<double>& angles, double yaw = 0.0) {
  return traceOf(angles, [&](double angle) { return world({0.0, 0.3}, {0.0, 0.0}, yaw + angle); });
}

/// Trace with as many states as `other`, all alike.
Trace resting(const Trace& other, double yaw = 0.0) {
  return teeTurnedBy(std::vector<double>(other.states.size(), 0.0), yaw);
}

TEST(Bound, IsTheTasksToleranceByDefault) {
  EXPECT_EQ(Bound().position, 0.03);
  EXPECT_EQ(Bound().angle, 0.20);
  EXPECT_NO_THROW(Bound().validate());
  EXPECT_NO_THROW(kNoticeable.validate());
}

TEST(Bound, RefusesWhatIsNoBound) {
  EXPECT_EQ(refusalOf([] { Bound{0.0, 0.2}.validate(); }), "bound position 0.0: must be finite and above 0 [m]");
  EXPECT_EQ(refusalOf([] { Bound{0.03, -1.0}.validate(); }), "bound angle -1.0: must be finite and above 0 [rad]");
  const Trace trace = teeAt({0.0, 0.0});
  for (const double bad : {0.0, -0.03, kNaN, kInfinity, -kInfinity}) {
    for (const Bound& bound : {Bound{bad, 0.2}, Bound{0.03, bad}}) {
      EXPECT_THROW(bound.validate(), pusht::InvalidInput) << bad;
      EXPECT_THROW(firstDivergenceOf(trace, trace, bound), pusht::InvalidInput) << bad;
      EXPECT_THROW(growthRate(trace, trace, bound), pusht::InvalidInput) << bad;
    }
  }
}

TEST(Bound, IsUsedByWhicheverIsMore) {
  EXPECT_DOUBLE_EQ((Bound{0.5, 2.0}.used({0.25, 0.5})), 0.5);
  EXPECT_DOUBLE_EQ((Bound{0.5, 2.0}.used({0.25, 3.0})), 1.5);
}

TEST(Cause, HasItsNamesInOneTable) {
  std::set<std::string> names;
  std::set<std::string> labels;
  for (std::size_t i = 0; i < kCauses.size(); ++i) {
    EXPECT_EQ(static_cast<std::size_t>(kCauses[i].cause), i);
    EXPECT_EQ(&nameOf(kCauses[i].cause), &kCauses[i]);
    EXPECT_EQ(std::string(kCauses[i].name).find_first_not_of("abcdefghijklmnopqrstuvwxyz_"), std::string::npos);
    names.insert(kCauses[i].name);
    labels.insert(kCauses[i].label);
  }
  EXPECT_EQ(names.size(), kCauses.size());
  EXPECT_EQ(labels.size(), kCauses.size());
  EXPECT_EQ(static_cast<std::size_t>(Cause::kFree) + 1, kCauses.size());
  EXPECT_STREQ(nameOf(Cause::kSlidingOnStem).name, "sliding_on_stem");
  EXPECT_STREQ(nameOf(Cause::kSlidingOnStem).label, "sliding on stem");
  EXPECT_STREQ(nameOf(FirstBody::kPusher), "pusher");
  EXPECT_STREQ(nameOf(FirstBody::kTee), "tee");
  EXPECT_STREQ(nameOf(FirstBody::kBoth), "both");
}

/// The pusher has a radius of 0.015 m. It touches the bar's top at y 0.03, its underside at y -0.03, and the stem's
/// sides at x +-0.03, all for a tee at the origin.
struct Step {
  const char* name;
  WorldState before;
  WorldState after;
  Cause cause;
};

std::vector<Step> stepsInTheOpen() {
  const Vector2d on_bar(0.02, 0.03);
  const Vector2d on_stem(0.03, -0.08);
  const Vector2d in_corner(-0.03, -0.03);
  const Vector2d away(0.0, 0.2);
  const auto shifted = [](const Vector2d& pusher, const Vector2d& shift) { return world(pusher + shift, shift); };
  return {
      {"approach", world(away), world({0.0, 0.1}), Cause::kFree},
      {"beside it, 0.1 mm away", world({0.0, 0.0301}), world({0.01, 0.0301}), Cause::kFree},
      {"the tee moves by 0.9 mm", world(away), world(away, {0.0, -0.0009}), Cause::kFree},
      {"the tee moves by 1.1 mm", world(away), world(away, {0.0, -0.0011}), Cause::kTeeAlone},
      {"the end of the stem moves by 0.9 mm", world(away), world(away, {0.0, 0.0}, 0.0009 / 0.105), Cause::kFree},
      {"the end of the stem moves by 1.1 mm", world(away), world(away, {0.0, 0.0}, -0.0011 / 0.105), Cause::kTeeAlone},
      {"meets the bar", world(away), world(on_bar), Cause::kContactBegins},
      {"meets the stem", world({0.1, -0.08}), world(on_stem), Cause::kContactBegins},
      {"meets the corner", world({-0.1, -0.1}), world(in_corner), Cause::kContactBegins},
      {"from box to box", world({0.06, -0.03}), world(on_stem), Cause::kContactBegins},
      {"leaves the bar", world(on_bar), world(away), Cause::kContactEnds},
      {"leaves the corner", world(in_corner), world({-0.1, -0.1}), Cause::kContactEnds},
      {"the tee is kicked off", world(on_bar), world(on_bar, {0.0, -0.01}), Cause::kContactEnds},
      {"rests on the bar", world(on_bar), world(on_bar), Cause::kStickingOnBar},
      {"pushes the bar", world(on_bar), shifted(on_bar, {0.01, -0.04}), Cause::kStickingOnBar},
      {"pushes into the bar", world(on_bar), world({0.02, 0.028}), Cause::kStickingOnBar},
      {"creeps 4.9 mm along the bar", world(on_bar), world({0.0249, 0.03}), Cause::kStickingOnBar},
      {"slides 5.1 mm along the bar", world(on_bar), world({0.0251, 0.03}), Cause::kSlidingOnBar},
      {"slides back", world(on_bar), world({0.0149, 0.03}), Cause::kSlidingOnBar},
      {"the bar slides along it", world(on_bar), world(on_bar, {0.0051, 0.0}), Cause::kSlidingOnBar},
      {"pushes the stem", world(on_stem), shifted(on_stem, {-0.03, 0.0}), Cause::kStickingOnStem},
      {"creeps 4.9 mm along the stem", world(on_stem), world({0.03, -0.0849}), Cause::kStickingOnStem},
      {"slides 5.1 mm along the stem", world(on_stem), world({0.03, -0.0851}), Cause::kSlidingOnStem},
      {"pushes in the corner", world(in_corner), shifted(in_corner, {0.02, 0.02}), Cause::kCorner},
      {"creeps out of the corner", world(in_corner), world({-0.034, -0.03}), Cause::kStickingOnBar},
      {"slides out of the corner", world(in_corner), world({-0.036, -0.03}), Cause::kSlidingOnBar},
      {"slides into the corner", world({-0.03, -0.036}), world(in_corner), Cause::kSlidingOnStem},
      // The tee turns by 1 rad, and 15 mm of the bar pass the pusher: it rolls. Or none pass, and it slides.
      {"rolls along the bar", world(on_bar), transformed(world({0.035, 0.03}), 1.0, {0.0, 0.0}), Cause::kStickingOnBar},
      {"turns on the spot", world(on_bar), transformed(world(on_bar), 1.0, {0.0, 0.0}), Cause::kSlidingOnBar},
  };
}

TEST(CauseIn, SaysWhatHappens) {
  for (const Step& step : stepsInTheOpen()) {
    EXPECT_EQ(nameOf(causeIn(step.before, step.after)).label, nameOf(step.cause).label) << step.name;
  }
}

TEST(CauseIn, CoversEveryCauseInThisTest) {
  std::set<Cause> seen = {Cause::kWall};
  for (const Step& step : stepsInTheOpen()) {
    seen.insert(step.cause);
  }
  EXPECT_EQ(seen.size(), kCauses.size());
}

TEST(CauseIn, IsTheSameInATurnedAndMovedWorld) {
  for (const Step& step : stepsInTheOpen()) {
    for (const double turn : {0.5, kPi / 2.0, 2.5, -kPi, -1.3}) {
      const auto there = [&](const WorldState& state) { return transformed(state, turn, {0.07, -0.11}); };
      EXPECT_EQ(nameOf(causeIn(there(step.before), there(step.after))).label, nameOf(step.cause).label)
          << step.name << ", turned by " << turn;
    }
  }
}

TEST(CauseIn, IsTheSameInAMirror) {
  const auto mirrored = [](const WorldState& state) {
    return world({-state.pusher_position.x(), state.pusher_position.y()},
                 {-state.tee_position.x(), state.tee_position.y()}, -state.tee_yaw);
  };
  for (const Step& step : stepsInTheOpen()) {
    EXPECT_EQ(nameOf(causeIn(mirrored(step.before), mirrored(step.after))).label, nameOf(step.cause).label)
        << step.name;
  }
}

/// The inner faces are at 0.39 m: the pusher's center is at 0.375 then.
TEST(CauseIn, IsTheWallWheneverOneIsTouched) {
  const WorldState open = world({0.3, 0.2});
  for (const double turn : {0.0, kPi / 2.0, kPi, -kPi / 2.0}) {
    const auto there = [&](const WorldState& state) { return transformed(state, turn, {0.0, 0.0}); };
    const WorldState pusher_at_wall = there(world({0.375, 0.2}));
    EXPECT_EQ(causeIn(there(open), pusher_at_wall), Cause::kWall);
    EXPECT_EQ(causeIn(pusher_at_wall, there(open)), Cause::kWall);
    EXPECT_EQ(causeIn(there(open), there(world({0.374, 0.2}))), Cause::kFree);
    // Pushed by its bar, with the stem's end at the wall: the wall comes first.
    const WorldState tee_at_wall = there(world({0.255, 0.0}, {0.285, 0.0}, kPi / 2.0));
    EXPECT_EQ(causeIn(tee_at_wall, tee_at_wall), Cause::kWall);
    const WorldState tee_near_wall = there(world({0.254, 0.0}, {0.284, 0.0}, kPi / 2.0));
    EXPECT_EQ(causeIn(tee_near_wall, tee_near_wall), Cause::kStickingOnBar);
  }
}

TEST(FirstDivergenceOf, IsTheFirstStepBeyondTheBound) {
  const Trace other = teeAt({0.0, 0.01, 0.029, 0.031, 0.02, 0.2});
  const auto first_divergence = firstDivergenceOf(resting(other), other);
  ASSERT_TRUE(first_divergence);
  EXPECT_EQ(first_divergence->step, 3);
}

TEST(FirstDivergenceOf, HoldsTheBoundItself) {
  const Trace at = teeAt({0.0, 0.25});
  const Trace beyond = teeAt({0.0, std::nextafter(0.25, 1.0)});
  EXPECT_FALSE(firstDivergenceOf(resting(at), at, {0.25, 1.0}));
  EXPECT_TRUE(firstDivergenceOf(resting(beyond), beyond, {0.25, 1.0}));
  const Trace turned = teeTurnedBy({0.0, 0.5});
  const Trace turned_beyond = teeTurnedBy({0.0, std::nextafter(0.5, 1.0)});
  EXPECT_FALSE(firstDivergenceOf(resting(turned), turned, {1.0, 0.5}));
  EXPECT_TRUE(firstDivergenceOf(resting(turned_beyond), turned_beyond, {1.0, 0.5}));
}

TEST(FirstDivergenceOf, SeesTheAngleAlone) {
  const Trace other = teeTurnedBy({0.0, 0.1, -0.21});
  EXPECT_EQ(firstDivergenceOf(resting(other), other)->step, 2);
}

TEST(FirstDivergenceOf, TakesAnglesTheShortWay) {
  const Trace other = teeTurnedBy({0.0, 0.15, 0.19}, kPi - 0.1);
  EXPECT_FALSE(firstDivergenceOf(resting(other, kPi - 0.1), other));
}

TEST(FirstDivergenceOf, LooksAtTheStepsThatBothHave) {
  const Trace other = teeAt({0.0, 0.01, 0.02, 0.5});
  for (const std::size_t states : {0U, 1U, 3U}) {
    Trace shorter = resting(other);
    shorter.states.resize(states);
    EXPECT_FALSE(firstDivergenceOf(shorter, other)) << states;
    EXPECT_FALSE(firstDivergenceOf(other, shorter)) << states;
  }
  EXPECT_TRUE(firstDivergenceOf(resting(other), other));
}

TEST(FirstDivergenceOf, DoesNotLookAtTheStart) {
  const Trace other = teeAt({0.5, 0.0, 0.0, 0.04});
  EXPECT_EQ(firstDivergenceOf(resting(other), other)->step, 3);
}

/// The reference pushes the bar in the last step; the other one pushes nothing.
TEST(FirstDivergenceOf, HasItsCauseFromTheReference) {
  const Trace reference =
      traceOf({world({0.02, 0.2}), world({0.02, 0.1}), world({0.02, 0.03}), world({0.02, -0.01}, {0.0, -0.04})});
  const Trace other = traceOf({world({0.02, 0.2}), world({0.02, 0.1}), world({0.1, 0.1}), world({0.1, 0.1})});
  EXPECT_EQ(firstDivergenceOf(reference, other)->cause, Cause::kStickingOnBar);
  EXPECT_EQ(firstDivergenceOf(other, reference)->cause, Cause::kFree);
  EXPECT_EQ(firstDivergenceOf(reference, other)->step, 3);
}

/// The cause is of the step that passes the bound, not of one before or after it.
TEST(FirstDivergenceOf, HasTheCauseOfItsStep) {
  const WorldState away = world({0.0, 0.2});
  const WorldState on_bar = world({0.0, 0.03});
  const Trace reference = traceOf({away, away, on_bar, on_bar, away, away});
  const std::vector<Cause> causes = {Cause::kFree, Cause::kContactBegins, Cause::kStickingOnBar, Cause::kContactEnds,
                                     Cause::kFree};
  for (std::size_t step = 1; step <= causes.size(); ++step) {
    Trace other = reference;
    for (std::size_t later = step; later < other.states.size(); ++later) {
      other.states[later].tee_position.x() += 0.1;
    }
    const auto first_divergence = firstDivergenceOf(reference, other);
    ASSERT_TRUE(first_divergence) << step;
    EXPECT_EQ(first_divergence->step, static_cast<int>(step));
    EXPECT_EQ(nameOf(first_divergence->cause).label, nameOf(causes[step - 1]).label) << step;
  }
}

/// Offsets of pusher and tee from the reference, step by step, and the body that differs first.
struct Lead {
  const char* name;
  std::vector<double> pusher;  // [m]
  std::vector<double> tee;     // [m]
  std::vector<double> angle;   // [rad]
  FirstBody first;
};

TEST(FirstDivergenceOf, SaysWhoWasTheFirst) {
  for (const Lead& lead : std::vector<Lead>{
           {"pusher", {0, 0.002, 0.002, 0}, {0, 0, 0.002, 0.1}, {0, 0, 0, 0}, FirstBody::kPusher},
           {"tee", {0, 0, 0, 0.1}, {0, 0, 0.002, 0.1}, {0, 0, 0, 0}, FirstBody::kTee},
           {"tee, by its yaw", {0, 0, 0.1, 0.1}, {0, 0, 0, 0.1}, {0, 0.01, 0, 0}, FirstBody::kTee},
           {"yaw and pusher", {0, 0, 0.002, 0.1}, {0, 0, 0, 0.1}, {0, 0, 0.01, 0}, FirstBody::kBoth},
           {"all at once", {0, 0, 0, 0.1}, {0, 0, 0, 0.1}, {0, 0, 0, 0}, FirstBody::kBoth},
           {"below 1 mm", {0, 0.0009, 0.0009, 0}, {0, 0, 0.002, 0.1}, {0, 0.009, 0, 0}, FirstBody::kTee},
           {"never elsewhere again", {0, 0.002, 0, 0}, {0, 0, 0, 0.1}, {0, 0, 0, 0}, FirstBody::kPusher},
           {"the start", {0.01, 0, 0, 0}, {0, 0, 0, 0.1}, {0, 0, 0, 0}, FirstBody::kTee},
       }) {
    Trace other;
    for (std::size_t k = 0; k < lead.pusher.size(); ++k) {
      other.states.push_back(world({0.0, 0.3 - lead.pusher[k]}, {-lead.tee[k], 0.0}, lead.angle[k]));
    }
    const auto first_divergence = firstDivergenceOf(resting(other), other);
    ASSERT_TRUE(first_divergence) << lead.name;
    EXPECT_EQ(first_divergence->step, 3) << lead.name;
    EXPECT_STREQ(nameOf(first_divergence->first), nameOf(lead.first)) << lead.name;
  }
}

TEST(FirstDivergenceOf, SaysWhoWasTheFirstInABoundBelowOneMillimeter) {
  Trace other = teeAt({0.0, 0.0002});
  EXPECT_EQ(firstDivergenceOf(resting(other), other, {0.0001, 0.1})->first, FirstBody::kTee);
  other.states[1].pusher_position.x() += 0.0002;
  EXPECT_EQ(firstDivergenceOf(resting(other), other, {0.0001, 0.1})->first, FirstBody::kBoth);
  const Trace turned = teeTurnedBy({0.0, 0.002});
  EXPECT_EQ(firstDivergenceOf(resting(turned), turned, {0.1, 0.001})->first, FirstBody::kTee);
}

TEST(FirstDivergenceOf, SaysNothingOfTheSame) {
  const Trace trace = teeAt({0.0, 0.1, 0.2});
  EXPECT_FALSE(firstDivergenceOf(trace, trace, {1e-300, 1e-300}));
}

/// Offsets of `start` times exp(rate k).
std::vector<double> exponential(double start, double rate, int steps) {
  std::vector<double> offsets;
  for (int k = 0; k <= steps; ++k) {
    offsets.push_back(start * std::exp(rate * k));
  }
  return offsets;
}

TEST(GrowthRate, IsThatOfAnExponential) {
  for (const double rate : {0.3, 0.05, 0.0, -0.1}) {
    const Trace moved = teeAt(exponential(1e-6, rate, 20));
    EXPECT_NEAR(growthRate(resting(moved), moved), rate, 1e-9);
    EXPECT_NEAR(growthRate(moved, resting(moved)), rate, 1e-9);
    const Trace turned = teeTurnedBy(exponential(1e-5, rate, 20));
    EXPECT_NEAR(growthRate(resting(turned), turned), rate, 1e-9);
  }
}

/// A push in one step of eight, by a factor of 100: the growth of a step on average, 0.58, whenever the push comes. The
/// slope of a line through the logarithms would be 0.31 for a push in the first or last step and 0.77 in the middle.
TEST(GrowthRate, IsTheMeanGrowthOfAStep) {
  for (const std::size_t pushed : {1U, 4U, 8U}) {
    std::vector<double> offsets(9, 1e-6);
    for (std::size_t k = pushed; k < offsets.size(); ++k) {
      offsets[k] = 1e-4;
    }
    const Trace other = teeAt(offsets);
    EXPECT_NEAR(growthRate(resting(other), other), std::log(100.0) / 8.0, 1e-9) << pushed;
  }
}

TEST(GrowthRate, EndsWhereTheBoundIsPassed) {
  const double rate = std::log(0.03 / 3e-6) / 3.0;
  for (const std::vector<double>& offsets : std::vector<std::vector<double>>{
           {3e-6, 1e-5, 1e-3, 0.031}, {3e-6, 1e-5, 1e-3, 0.3}, {3e-6, 1e-5, 1e-3, 0.031, 1e-9, 0.0, 0.5}}) {
    const Trace other = teeAt(offsets);
    EXPECT_NEAR(growthRate(resting(other), other), rate, 1e-9);
  }
  const Trace other = teeAt({3e-6, 1e-5, 1e-3, 0.031});
  EXPECT_NEAR(growthRate(resting(other), other, {0.1, 1.0}), std::log(0.031 / 3e-6) / 3.0, 1e-9) << "a wider bound";
  EXPECT_NEAR(growthRate(resting(other), other, {1e-4, 1.0}), std::log(1e-4 / 3e-6) / 2.0, 1e-9) << "a narrower one";
}

TEST(GrowthRate, LooksAtTheStepsThatBothHave) {
  const Trace other = teeAt({1e-6, 1e-6, 4e-6, 1e-3, 1e-3});
  Trace reference = resting(other);
  reference.states.resize(3);
  EXPECT_NEAR(growthRate(reference, other), std::log(4.0) / 2.0, 1e-9);
}

TEST(GrowthRate, EndsWhereADifferenceVanishes) {
  const Trace late = teeAt({1e-6, 5e-7, 0.0, 1e-3});
  EXPECT_NEAR(growthRate(resting(late), late), -std::log(2.0), 1e-9);
  const Trace at_once = teeAt({1e-6, 0.0, 0.0, 1e-3});
  EXPECT_TRUE(std::isnan(growthRate(resting(at_once), at_once)));
}

TEST(GrowthRate, IsNoneWithoutADifferenceThatCanGrow) {
  for (const std::vector<double>& offsets :
       std::vector<std::vector<double>>{{}, {1e-6}, {0.0, 0.0, 0.0}, {0.0, 1e-6, 1e-5}, {0.04, 0.05}}) {
    const Trace other = teeAt(offsets);
    EXPECT_TRUE(std::isnan(growthRate(resting(other), other))) << offsets.size();
  }
}

/// The expert in MuJoCo, and what other worlds do with its actions.
class RealEpisodes : public ::testing::Test {
 protected:
  static constexpr int kEpisodes = 5;

  static void forEach(const std::function<void(pusht::MujocoWorld&, const Trace&)>& check) {
    pusht::MujocoWorld mujoco(std::make_shared<const pusht::MujocoScene>());
    pusht::ScriptedExpert expert;
    for (int seed = 0; seed < kEpisodes; ++seed) {
      SCOPED_TRACE(seed);
      check(mujoco, pusht::runClosedLoop(mujoco, pusht::spawn(seed), expert, pusht::kHorizon).trace());
    }
  }

  static Trace replay(pusht::Simulator& simulator, const Trace& reference, double offset) {
    WorldState start = reference.states.front();
    start.tee_position.x() += offset;
    pusht::Rollout rollout = pusht::begin(simulator, start);
    for (const pusht::Action& action : reference.actions) {
      pusht::advance(rollout, simulator, action);
    }
    return rollout.trace();
  }
};

/// Its servo is slower than MuJoCo's, so that the pushers are apart after one step in the open.
TEST_F(RealEpisodes, InTheTwoMassEngineThePusherIsTheFirst) {
  pusht::TwoMassEngine engine{pusht::TwoMassParameters()};
  forEach([&](pusht::MujocoWorld&, const Trace& reference) {
    const auto first_divergence = firstDivergenceOf(reference, replay(engine, reference, 0.0));
    ASSERT_TRUE(first_divergence);
    EXPECT_EQ(first_divergence->first, FirstBody::kPusher);
  });
}

/// MuJoCo from a start that is moved by 1e-6 m: what can differ first is the tee.
TEST_F(RealEpisodes, AFloorPartsLateIfAtAllAndGrowsModestly) {
  forEach([&](pusht::MujocoWorld& mujoco, const Trace& reference) {
    const Trace floor = replay(mujoco, reference, 1e-6);
    const auto noticed = firstDivergenceOf(reference, floor, kNoticeable);
    EXPECT_TRUE(!noticed || noticed->first != FirstBody::kPusher);
    EXPECT_TRUE(!noticed || noticed->step > 10);
    const double rate = growthRate(reference, floor);
    EXPECT_GT(rate, -0.1);
    EXPECT_LT(rate, 0.5);
    EXPECT_FALSE(firstDivergenceOf(reference, replay(mujoco, reference, 0.0), {1e-15, 1e-15}));
  });
}

}  // namespace
}  // namespace sim2sim
