// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_engine/two_mass_engine.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "pusht_engine/two_mass_kind.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/rollout.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_testing/convergence_suite.hpp"
#include "pusht_testing/golden.hpp"
#include "pusht_testing/kind_suites.hpp"
#include "pusht_testing/scenarios.hpp"

namespace pusht::testing {
namespace {

/// Two masses, discs, drag: none of the table's friction, no friction in contacts, no walls.
PhysicsOfKind physicsOf(const TwoMassParameters& parameters) {
  PhysicsOfKind physics;
  Physics& numbers = physics.numbers;
  numbers.tee_second_moment = kStemMass * kStemOffset * kStemOffset;
  numbers.tee_damping = numbers.tee_yaw_damping = numbers.tee_yaw_friction = 0.0;
  numbers.tee_friction = {0.0, 0.0};
  physics.drag_rate = parameters.block_damp;
  numbers.pusher_mass = parameters.pusher_mass;
  numbers.servo_gain = two_mass::kServoGain * parameters.pusher_mass;
  numbers.servo_limit = std::numeric_limits<double>::infinity();
  numbers.pusher_damping = 0.0;
  physics.implicit_servo = false;
  numbers.contact_friction = 0.0;
  physics.walls = false;
  physics.discs = true;
  numbers.bar_half_length = numbers.bar_half_width = two_mass::kBarRadius;
  numbers.stem_half_length = numbers.stem_half_width = two_mass::kStemRadius;

  physics.free_position = 5e-4;  // it turns for long, and the integrator is of first order
  physics.free_yaw = 6e-3;
  physics.free_speed = 5e-3;
  const double give = 0.58 * 0.6 / parameters.baumgarte;  // [m] of the link, pushed at 0.6 m/s (two_mass::kParameters)
  physics.push_position = 1.3 * give;
  physics.push_speed = 1.5 * give;        // [m/s] it comes back slowly
  physics.contact_position = 0.5 * give;  // pushed at 0.2 m/s
  return physics;
}

std::vector<Subject> subjects() {
  std::vector<Subject> subjects = {{twoMassKind(), {}, physicsOf({})}};
  for (const auto& [name, value] : {std::pair("block_damp", 1.0), {"pusher_mass", 0.5}, {"baumgarte", 20.0}}) {
    TwoMassParameters parameters;
    for (const two_mass::Parameter& parameter : two_mass::kParameters) {
      if (parameter.name == std::string(name)) {
        parameters.*parameter.value = value;
      }
    }
    subjects.push_back({twoMassKind(), {{name, shortestText(value)}}, physicsOf(parameters)});
  }
  return subjects;
}

/// Its substep is fixed: the engine is the course's, bit for bit. In the hit its link gives way.
std::vector<ConvergenceSubject> convergence() {
  return {
      {{twoMassKind(), {}, physicsOf({})},
       "",
       {{"servo", 4.517e-3}, {"slide", 0.06995}, {"slide to rest", 2.914e-3}, {"spin", 6.302e-4}, {"hit", 7.089e-3}}}};
}

}  // namespace
}  // namespace pusht::testing

PUSHT_TEST_SIMULATOR_KIND(TwoMass, subjects());
PUSHT_TEST_CONVERGENCE(TwoMass, convergence());

namespace pusht {

namespace {

using two_mass::kBar;
using two_mass::kStem;

TwoMassParameters parametersOf(const nlohmann::json& values) {
  TwoMassParameters result;
  result.pusher_mass = values.value("pusher_mass", result.pusher_mass);
  result.block_damp = values.value("block_damp", result.block_damp);
  result.baumgarte = values.value("baumgarte", result.baumgarte);
  return result;
}

void expectRow(const two_mass::BodyVectors<double>& found, const nlohmann::json& row) {
  constexpr double kTolerance = 1e-9;
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(found[i / 2][static_cast<Eigen::Index>(i % 2)], row.at(i).get<double>(), kTolerance);
  }
}

/// Every step of every case and set of parameters, clipping and stepping on after success included.
TEST(TwoMassEngine, MatchesTheGoldenTrajectories) {
  int successes = 0;
  for (const auto& golden : testing::loadGolden("pusht_golden.json", "cases")) {
    const auto& actions = golden.at("actions");
    for (const auto& expected : golden.at("engine")) {
      SCOPED_TRACE("seed " + golden.at("seed").dump() + " parameters " + expected.at("knobs").dump());
      TwoMassEngine engine(parametersOf(expected.at("knobs")));
      Rollout rollout = begin(engine, spawn(golden.at("seed").get<std::uint64_t>()));
      for (std::size_t step = 0;; ++step) {
        expectRow(engine.bodies().positions, expected.at("q_pusher_bar_stem").at(step));
        expectRow(engine.bodies().velocities, expected.at("v_pusher_bar_stem").at(step));
        EXPECT_NEAR(wrapAngle(engine.state().tee_yaw - expected.at("yaw").at(step).get<double>()), 0.0, 1e-9);
        ASSERT_FALSE(HasFailure()) << "first at step " << step;
        if (step == actions.size()) {
          break;
        }
        advance(rollout, engine, testing::action(actions.at(step)));
        EXPECT_EQ(rollout.success(), expected.at("success").at(step).get<bool>());
      }
      successes += rollout.success() ? 1 : 0;
    }
  }
  EXPECT_GT(successes, 0) << "the golden cases must exercise the latch";
}

/// [m] The link's worst length error while the tee is chased for 30 s, or left alone while it spins.
double worstLinkError(bool chased) {
  double worst = 0.0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    TwoMassEngine engine;
    WorldState start = testing::movingState(seed);
    if (!chased) {
      start.pusher_position = {10.0, 10.0};
    }
    engine.reset(start);
    for (int i = 0; i < kHorizon; ++i) {
      engine.step(chased ? testing::chase(engine.state()) : Action{});
      const double length = (engine.bodies().positions[kBar] - engine.bodies().positions[kStem]).norm();
      worst = std::max(worst, std::abs(length - kStemOffset));
    }
  }
  return worst;
}

TEST(TwoMassEngine, LinkKeepsItsLengthInFreeMotion) { EXPECT_LT(worstLinkError(false), 0.01 * kStemOffset); }

/// Under full-speed impacts of 4 kg the link gives way, but it neither collapses nor flies apart.
TEST(TwoMassEngine, LinkLengthErrorStaysBoundedUnderImpacts) {
  const double worst = worstLinkError(true);
  EXPECT_LT(worst, 0.5 * kStemOffset);
  EXPECT_GT(worst, 1e-6) << "the push must load the link";
}

// Symmetries: physics has no preferred direction or hand, so the image of a motion is the motion of the image.

struct Image {
  Eigen::Matrix2d matrix;
  double turn;  // [rad] added to the yaw
  double hand;  // -1 if the image is mirrored

  WorldState operator()(const WorldState& s) const {
    WorldState image;
    image.pusher_position = matrix * s.pusher_position;
    image.pusher_velocity = matrix * s.pusher_velocity;
    image.tee_position = matrix * s.tee_position;
    image.tee_velocity = matrix * s.tee_velocity;
    image.tee_yaw = wrapAngle(hand * s.tee_yaw + turn);
    image.tee_yaw_rate = hand * s.tee_yaw_rate;
    return image;
  }
};

class Symmetry : public ::testing::TestWithParam<Image> {};

TEST_P(Symmetry, TheImageOfAMotionIsTheMotionOfTheImage) {
  const Image& image = GetParam();
  double traveled = 0.0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    TwoMassEngine engine;
    TwoMassEngine mirror;
    WorldState start = testing::movingState(seed);
    start.pusher_position = start.tee_position + 0.06 * start.pusher_position.normalized();  // soon in contact
    start.pusher_velocity = -start.pusher_position.normalized();
    engine.reset(start);
    mirror.reset(image(start));
    for (int i = 0; i < 5; ++i) {
      engine.step({0.0F, 0.0F});  // any other action would be rounded to float32 in its image
      mirror.step({0.0F, 0.0F});
    }
    testing::expectNear(mirror.state(), image(engine.state()), 1e-10);
    traveled += (engine.state().tee_position - start.tee_position).norm();
  }
  EXPECT_GT(traveled, 0.1);
}

Image rotation(double angle) {
  return {(Eigen::Matrix2d() << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle)).finished(), angle,
          1.0};
}

INSTANTIATE_TEST_SUITE_P(TwoMassEngine, Symmetry,
                         ::testing::Values(Image{(Eigen::Matrix2d() << -1.0, 0.0, 0.0, 1.0).finished(), 0.0, -1.0},
                                           rotation(kPi / 2.0), rotation(0.4)));

const two_mass::Parameter& parameterNamed(const std::string& name) {
  return *std::find_if(two_mass::kParameters.begin(), two_mass::kParameters.end(),
                       [&](const two_mass::Parameter& parameter) { return parameter.name == name; });
}

/// Message of the refusal of these parameters; empty if they are accepted.
std::string refusal(const TwoMassParameters& parameters) {
  try {
    TwoMassEngine engine(parameters);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(TwoMassParameters, RefusesWhatIsOutsideTheRangeOfAParameterByName) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const two_mass::Parameter& parameter : two_mass::kParameters) {
    TwoMassParameters parameters;
    parameters.block_damp = 0.0;  // leaves the link its whole range
    for (const double inside : {parameter.least, parameter.greatest}) {
      parameters.*parameter.value = inside;
      EXPECT_EQ(refusal(parameters), "");
    }
    for (const double outside :
         {std::nextafter(parameter.least, -kInfinity), std::nextafter(parameter.greatest, kInfinity), -1.0, kInfinity,
          std::numeric_limits<double>::quiet_NaN()}) {
      parameters.*parameter.value = outside;
      EXPECT_THAT(
          refusal(parameters),
          ::testing::AllOf(::testing::StartsWith(parameter.name + (" " + shortestText(outside)) + ": must be from "),
                           ::testing::HasSubstr(parameter.unit), ::testing::HasSubstr(parameter.reason)));
    }
  }
}

TEST(TwoMassParameters, RefusesALinkThatIsTooStiffForItsDrag) {
  for (const double damp : {0.0, 6.0, 60.0, 100.0}) {
    TwoMassParameters parameters;
    parameters.block_damp = damp;
    const double greatest = std::min(two_mass::greatestBaumgarte(damp), parameterNamed("baumgarte").greatest);
    parameters.baumgarte = 0.999 * greatest;
    EXPECT_EQ(refusal(parameters), "");
    parameters.baumgarte = 1.001 * greatest;
    EXPECT_THAT(refusal(parameters),
                ::testing::StartsWith("baumgarte " + shortestText(parameters.baumgarte) + ": must be "));
  }
}

// The ranges are those in which the integration itself is stable: just inside it is, just outside it is not.

/// Model of any parameters, those that are refused too.
two_mass::Model modelWith(const TwoMassParameters& parameters) {
  return {{parameters.pusher_mass, kBarMass, kStemMass},
          {1.0 / parameters.pusher_mass, 1.0 / kBarMass, 1.0 / kStemMass},
          parameters.block_damp,
          parameters.baumgarte};
}

/// A tee at the origin with its stem on +x, `stretch` [m] longer than it should be; the pusher is far away.
two_mass::Bodies<double> stretchedTee(double stretch) {
  two_mass::Bodies<double> bodies;
  bodies.velocities.fill(Eigen::Vector2d::Zero());
  bodies.positions = {Eigen::Vector2d(-1.0, 0.0), Eigen::Vector2d(0.0, 0.0),
                      Eigen::Vector2d(kStemOffset + stretch, 0.0)};
  return bodies;
}

TEST(StableRange, DragSlowsTheTeeAndNeverTurnsIt) {
  const auto speed_after_a_substep = [](double damp) {
    TwoMassParameters parameters;
    parameters.block_damp = damp;
    two_mass::Bodies<double> bodies = stretchedTee(0.0);
    bodies.velocities[kBar] = bodies.velocities[kStem] = {1.0, 0.0};
    two_mass::substep<double>(modelWith(parameters), {0.0, 0.0}, bodies);
    return bodies.velocities[kBar].x();
  };
  const double greatest = parameterNamed("block_damp").greatest;
  EXPECT_GE(speed_after_a_substep(greatest), 0.0);
  EXPECT_LT(speed_after_a_substep(1.01 * greatest), 0.0);
}

TEST(StableRange, AnErrorOfTheLinkDecaysUpToItsGreatestStiffness) {
  constexpr double kStretch = 1e-9;  // [m]
  // After 30 s, or once it is a thousand times as large.
  const auto error_after_a_while = [](double damp, double baumgarte) {
    TwoMassParameters parameters;
    parameters.block_damp = damp;
    parameters.baumgarte = baumgarte;
    two_mass::Bodies<double> bodies = stretchedTee(kStretch);
    double error = kStretch;
    for (int i = 0; i < kHorizon * kSubstepsPerControlStep && error < 1e3 * kStretch; ++i) {
      two_mass::substep<double>(modelWith(parameters), {0.0, 0.0}, bodies);
      error = std::abs((bodies.positions[kStem] - bodies.positions[kBar]).norm() - kStemOffset);
    }
    return error;
  };
  for (const double damp : {0.0, 6.0, 60.0, 100.0}) {
    const double greatest = two_mass::greatestBaumgarte(damp);
    EXPECT_LT(error_after_a_while(damp, 0.99 * greatest), 1e-3 * kStretch) << damp;
    EXPECT_GE(error_after_a_while(damp, 1.01 * greatest), 1e3 * kStretch) << damp;
  }
}

/// [m/s] How fast the tee gets when a pusher at full speed chases it for 30 s.
double fastestTee(const TwoMassParameters& parameters) {
  double fastest = 0.0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    TwoMassEngine engine(parameters);
    engine.reset(testing::movingState(seed));
    for (int i = 0; i < kHorizon; ++i) {
      engine.step(testing::chase(engine.state()));
      fastest = std::max(fastest, engine.state().tee_velocity.norm());
    }
  }
  return fastest;
}

TEST(StableRange, TheTeeIsNeverMuchFasterThanThePusher) {
  constexpr double kBound = 2.0;  // [m/s]; the pusher's 1 m/s and what contacts add to remove an overlap
  const two_mass::Parameter pusher_mass = parameterNamed("pusher_mass");
  for (const double mass : {pusher_mass.least, 0.05, 4.0, pusher_mass.greatest}) {
    for (const double damp : {0.0, 6.0, 100.0}) {
      for (const double stiffness : {40.0, 0.99 * two_mass::greatestBaumgarte(damp)}) {
        EXPECT_LT(fastestTee({mass, damp, stiffness}), kBound) << mass << " " << damp << " " << stiffness;
      }
    }
  }
}

/// What holds a soft link is too slow for a pusher at full speed: that ends a world, and by name.
TEST(StableRange, ALinkThatCloses) {
  TwoMassParameters soft;
  soft.baumgarte = parameterNamed("baumgarte").least;
  TwoMassEngine engine(soft);
  WorldState start;
  start.tee_yaw = kPi / 2.0;  // the stem is on +x
  start.pusher_position = {-0.05, 0.0};
  start.pusher_velocity = {1.0, 0.0};
  engine.reset(start);
  const auto push = [&] {
    for (int i = 0; i < kHorizon; ++i) {
      engine.step({1.0F, 0.0F});
    }
  };
  EXPECT_THROW(push(), SimulationFault);
}

}  // namespace
}  // namespace pusht
