// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_chipmunk/chipmunk_world.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "pusht_chipmunk/chipmunk_kind.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/testing/batch_simulator_suite.hpp"
#include "pusht_task/testing/golden.hpp"
#include "pusht_task/testing/simulator_suite.hpp"

namespace pusht {
namespace testing {
namespace {

std::vector<Subject> subjects() {
  return {{chipmunkKind()},
          {chipmunkKind(), {{"iterations", "10"}, {"collision_slop", "0.001"}, {"overlap_left", "0.5"}}}};
}

}  // namespace

INSTANTIATE_TEST_SUITE_P(Chipmunk, SimulatorSuite, ::testing::ValuesIn(subjects()));
INSTANTIATE_TEST_SUITE_P(Chipmunk, BatchSimulatorSuite, ::testing::ValuesIn(subjects()));

}  // namespace testing

namespace {

/// As in the reference: 0.2 kg, servo 20, damping 0.5, implicit in the velocity.
TEST(ChipmunkWorld, PusherServoInFreeSpaceHasItsClosedForm) {
  ChipmunkWorld world;
  WorldState start;
  start.tee_position = {0.25, 0.25};
  world.reset(start);
  world.step({0.5F, -0.25F});
  constexpr double kPull = 20.0 / 0.2;
  constexpr double kRate = 20.5 / 0.2;
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();
  for (int i = 0; i < kSubstepsPerControlStep; ++i) {
    velocity += kSubstep * (kPull * Eigen::Vector2d(0.5, -0.25) - kRate * velocity) / (1.0 + kSubstep * kRate);
  }
  EXPECT_LE((world.state().pusher_velocity - velocity).norm(), 1e-12);
}

/// A tee that slides loses to damping and dry friction what an implicit step takes, axis by axis.
TEST(ChipmunkWorld, TableStopsTheTee) {
  ChipmunkWorld world;
  WorldState start;
  start.pusher_position = {0.3, 0.3};
  start.tee_velocity = {0.0, -0.5};  // along the line of both centres: it does not turn
  world.reset(start);
  world.step({0.0F, 0.0F});
  constexpr double kMass = kBarMass + kStemMass;
  double velocity = 0.5;
  for (int i = 0; i < kSubstepsPerControlStep; ++i) {
    velocity = std::max(0.0, velocity - kSubstep * (4.0 * velocity + 1.2) / (kMass + kSubstep * 4.0));
  }
  EXPECT_EQ(velocity, 0.0) << "or the test would show nothing of dry friction";
  EXPECT_NEAR(world.state().tee_velocity.y(), 0.0, 1e-12);
  EXPECT_NEAR(world.state().tee_yaw_rate, 0.0, 1e-12);
  EXPECT_LT(world.state().tee_position.y(), -0.002);
  const WorldState stopped = world.state();
  world.step({0.0F, 0.0F});
  EXPECT_NEAR(world.state().tee_position.y(), stopped.tee_position.y(), 1e-12) << "it stays where it is";
}

TEST(ChipmunkWorld, WallsHoldThePusher) {
  ChipmunkWorld world;
  WorldState start;
  start.tee_position = {-0.2, -0.2};
  world.reset(start);
  for (int i = 0; i < 20; ++i) {
    world.step({1.0F, 0.0F});
  }
  EXPECT_NEAR(world.state().pusher_position.x(), kWallInnerFace - kPusherRadius, 2e-3);
}

/// How far the tee ends from where it ended in the reference, by episode: ours, and one that never moves [m].
TEST(ChipmunkWorld, FollowsTheReferenceThroughExpertEpisodes) {
  ChipmunkWorld world;
  std::vector<double> errors;
  std::vector<double> of_null;
  for (const auto& golden : testing::loadGolden("expert_actions.json", "cases")) {
    const WorldState start = testing::worldPose(golden.at("start_tee_xyyaw_pusher_xy"));
    world.reset(start);
    double error = 0.0;
    double null_error = 0.0;
    const auto steps = golden.at("actions").size();
    for (std::size_t step = 0; step < steps; ++step) {
      world.step(testing::action(golden.at("actions").at(step)));
      const WorldState reference = testing::worldPose(golden.at("tee_xyyaw_pusher_xy").at(step));
      error += (world.state().tee_position - reference.tee_position).norm() / static_cast<double>(steps);
      null_error += (start.tee_position - reference.tee_position).norm() / static_cast<double>(steps);
    }
    errors.push_back(error);
    of_null.push_back(null_error);
  }
  const auto median = [](std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    return values[values.size() / 2];
  };
  RecordProperty("median_error_mm", std::to_string(1e3 * median(errors)));
  EXPECT_LT(median(errors), 0.1 * median(of_null));
}

TEST(ChipmunkKind, TakesItsParameters) {
  ParameterSet parameters = chipmunkKind().defaults();
  const auto trajectory = [](const ParameterSet& chosen) {
    const auto world = chipmunkKind().load(chosen).make_world();
    return testing::chaseFrom(*world, spawn(3), 60);
  };
  const std::vector<WorldState> usual = trajectory(parameters);
  for (const auto& [name, value] :
       {std::pair("iterations", "1"), std::pair("collision_slop", "0.001"), std::pair("overlap_left", "0.5")}) {
    ParameterSet changed = parameters;
    changed.set(name, value);
    EXPECT_NE(trajectory(changed).back(), usual.back()) << name;
  }
}

}  // namespace
}  // namespace pusht
