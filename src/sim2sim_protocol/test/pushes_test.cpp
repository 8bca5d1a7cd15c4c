// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/pushes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>

#include "pusht_task/physics.hpp"

namespace sim2sim {
namespace {

using pusht::kPi;
using pusht::Trace;
using pusht::WorldState;

/// Pose of a tee [m, m, rad].
struct Pose {
  double x;
  double y = 0.0;
  double yaw = 0.0;
};

WorldState teeIn(const Pose& pose) {
  WorldState state;
  state.tee_position = {pose.x, pose.y};
  state.tee_yaw = pusht::wrapAngle(pose.yaw);
  return state;
}

/// Trace whose tee rests at `begin` and in between, and is at each of `ends` after so many windows.
Trace jumping(int window, const Pose& begin, std::initializer_list<Pose> ends) {
  Trace trace;
  trace.states.push_back(teeIn(begin));
  for (const Pose& end : ends) {
    trace.states.insert(trace.states.end(), static_cast<std::size_t>(window) - 1, trace.states.back());
    trace.states.push_back(teeIn(end));
  }
  trace.actions.resize(trace.states.size() - 1);
  return trace;
}

/// The numbers of test_other_answers() in test_pushes.py of sim2sim_study, far from the target.
TEST(Pushes, AreWhatTheStudyCallsThem) {
  const Trace reference = jumping(5, {0.20}, {{0.21}, {0.22}, {0.23}, {0.2319}});
  const Trace engine = jumping(5, {0.20}, {{0.21}, {0.19}, {0.22, 0.002}, {0.9}});
  const PushFigures figures = pushFigures(reference, engine, 5);
  EXPECT_EQ(figures.pushes, 3) << "1.9 mm in five steps are none";
  EXPECT_NEAR(figures.direction_error, (0.0 + kPi + kPi / 2.0) / 3.0, 1e-7);
  EXPECT_DOUBLE_EQ(figures.missed, 1.0 / 3.0);
  EXPECT_DOUBLE_EQ(figures.turned, 1.0 / 2.0) << "of those that are not missed";
  EXPECT_NEAR(figures.size, (0.0 + std::log(2.0) + std::log(0.2)) / 3.0, 1e-12);
}

TEST(Pushes, BeginAtTheReferencesState) {
  const Trace reference = jumping(1, {0.20}, {{0.201}, {0.202}});
  const Trace engine = jumping(1, {0.20}, {{0.2005}, {0.2015}});  // as it was before it was put back
  const PushFigures figures = pushFigures(reference, engine, 1);
  EXPECT_EQ(figures.pushes, 2) << "0.4 mm in one step are enough";
  EXPECT_NEAR(figures.size, std::log(0.5), 1e-9);
  EXPECT_EQ(figures.turned, 0.0);
}

TEST(Pushes, HaveABoundedSize) {
  const Trace reference = jumping(5, {0.20}, {{0.21}});
  EXPECT_NEAR(pushFigures(reference, jumping(5, {0.20}, {{0.20}}), 5).size, -std::log(20.0), 1e-12);
  EXPECT_NEAR(pushFigures(reference, jumping(5, {0.20}, {{0.90}}), 5).size, kLargestPushSize, 1e-12);
  EXPECT_DOUBLE_EQ(kLargestPushSize, std::log(kLargestPushRatio));
}

/// An engine's tee that has been in tolerance for five steps within a window has reached the target.
TEST(Pushes, EndAtASuccess) {
  const Trace reference = jumping(10, {0.05}, {{0.031}});
  Trace engine = jumping(10, {0.05}, {{0.20}});
  const auto stays = [&](int steps) {
    for (int step = 1; step < 10; ++step) {
      engine.states[static_cast<std::size_t>(step)] = teeIn({step <= steps ? 0.02 : 0.20});
    }
    return pushFigures(reference, engine, 10);
  };
  EXPECT_NEAR(stays(4).size, std::log(0.15 / 0.019), 1e-9);
  EXPECT_EQ(stays(4).turned, 1.0);
  EXPECT_NEAR(stays(5).size, std::log(0.03 / 0.019), 1e-9);
  EXPECT_EQ(stays(5).turned, 0.0);
}

TEST(Pushes, WithoutOneThereIsNoFigure) {
  const Trace still = jumping(5, {0.20}, {{0.20}, {0.20}});
  const Trace moving = jumping(5, {0.20}, {{0.21}, {0.22}});
  for (const PushFigures& figures : {pushFigures(still, moving, 5), pushFigures(moving, moving, 11)}) {
    EXPECT_EQ(figures.pushes, 0);
    for (const double figure : {figures.direction_error, figures.missed, figures.turned, figures.size}) {
      EXPECT_TRUE(std::isnan(figure));
    }
  }
  const PushFigures all_missed = pushFigures(moving, jumping(5, {0.20}, {{0.20}, {0.21}}), 5);
  EXPECT_EQ(all_missed.missed, 1.0);
  EXPECT_DOUBLE_EQ(all_missed.direction_error, kPi / 2.0);
  EXPECT_TRUE(std::isnan(all_missed.turned)) << "there is none that is not missed";
}

TEST(TeeDisplacement, IsThatOfTheCenterOfMass) {
  const double center = pusht::kCenterOfMassOffset;
  const Pose turned = {-center * std::sin(0.5), -center + center * std::cos(0.5), 0.5};
  EXPECT_NEAR((teeDisplacement(teeIn({0.0}), teeIn(turned)) - Eigen::Vector3d(0.0, 0.0, 0.022)).norm(), 0.0, 1e-12);
  const Eigen::Vector3d across = teeDisplacement(teeIn({0.0, 0.0, kPi - 0.1}), teeIn({0.0, 0.0, kPi + 0.1}));
  EXPECT_NEAR(across.z(), 0.0088, 1e-12) << "the short way";
}

TEST(TeeDisplacement, HasTheRadiusOfGyrationOfTheTask) {
  const pusht::Physics physics;
  const double center = physics.tee_first_moment / physics.tee_mass;
  EXPECT_NEAR(kGyration, std::sqrt(physics.tee_second_moment / physics.tee_mass - center * center), 1e-4);
}

}  // namespace
}  // namespace sim2sim
