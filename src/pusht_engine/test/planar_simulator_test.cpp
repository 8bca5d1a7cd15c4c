// SPDX-License-Identifier: BSD-3-Clause
// PlanarSimulator with a minimal physics.
#include "pusht_engine/planar_simulator.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_testing/kind_suites.hpp"

namespace pusht {
namespace {

/// The pusher goes where it is told, and tows a tee that is near by a spring.
struct Tow {
  struct Parameters {
    double stiffness = 100.0;  ///< [1/s^2] of the spring, when it is tight
  };
  using Model = Parameters;

  struct Bodies {
    Eigen::Vector2d pusher, pusher_velocity, tee, tee_velocity;
    double yaw, yaw_rate;
    double tightness;  // [0, 1] of the spring; no state shows it
  };

  static constexpr double kStartTolerance = 1e-12;

  static Model modelOf(const Parameters& parameters) { return parameters; }

  static Bodies bodiesOf(const WorldState& state) {
    return {state.pusher_position,
            state.pusher_velocity,
            state.tee_position,
            state.tee_velocity,
            state.tee_yaw,
            state.tee_yaw_rate,
            0.0};
  }

  static WorldState stateOf(const Bodies& bodies) {
    return {bodies.pusher,       bodies.pusher_velocity, bodies.tee,
            bodies.tee_velocity, wrapAngle(bodies.yaw),  bodies.yaw_rate};
  }

  static int substepsOf(const Model&) { return kSubstepsPerControlStep; }

  static void substep(const Model& model, const Eigen::Vector2d& command, Bodies& bodies) {
    constexpr double kReach = 0.1;  // [m]
    constexpr double kDamping = 0.9;
    constexpr double kTightening = 0.1;
    const Eigen::Vector2d way = bodies.pusher - bodies.tee;
    bodies.tightness += kTightening * ((way.norm() < kReach ? 1.0 : 0.0) - bodies.tightness);
    bodies.pusher_velocity = command;
    bodies.tee_velocity = kDamping * (bodies.tee_velocity + kSubstep * model.stiffness * bodies.tightness * way);
    bodies.yaw_rate *= kDamping;
    bodies.pusher += kSubstep * bodies.pusher_velocity;
    bodies.tee += kSubstep * bodies.tee_velocity;
    bodies.yaw += kSubstep * bodies.yaw_rate;
  }
};

SimulatorKind towKind() {
  SimulatorKind kind;
  kind.name = "tow";
  kind.title = "tow";
  kind.version = "1";
  kind.parameters = {{"stiffness", "1/s^2", "of the spring, when it is tight", Tow::Parameters().stiffness}};
  kind.start_tolerance = Tow::kStartTolerance;
  kind.loader = [](const ParameterSet& set) {
    const Tow::Parameters parameters = {set.get<double>("stiffness")};
    return modelOfWorlds(set, [parameters] { return std::make_unique<PlanarSimulator<Tow>>(parameters); });
  };
  return kind;
}

std::vector<testing::Subject> tows() { return {{towKind()}, {towKind(), {{"stiffness", "20.0"}}}}; }

/// Physics in single precision that claims the start tolerance of double precision.
struct Rounding : Tow {
  static Bodies bodiesOf(const WorldState& state) {
    Bodies bodies = Tow::bodiesOf(state);
    bodies.tee.x() = static_cast<float>(bodies.tee.x());
    return bodies;
  }
};

TEST(PlanarSimulator, MustStartWhereItIsTold) {
  PlanarSimulator<Rounding> world;
  EXPECT_THROW(world.reset(spawn(3)), SimulationFault);
  EXPECT_NO_THROW(world.reset({}));
}

}  // namespace

namespace testing {
INSTANTIATE_TEST_SUITE_P(Tow, SimulatorSuite, ::testing::ValuesIn(tows()));
}  // namespace testing
}  // namespace pusht
