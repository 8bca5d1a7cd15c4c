// SPDX-License-Identifier: BSD-3-Clause
// The machinery of worlds and lanes, with the least physics that one can write for it.
#include "pusht_engine/planar_simulator.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/testing/batch_simulator_suite.hpp"
#include "pusht_task/testing/simulator_suite.hpp"

namespace pusht {
namespace {

/// The pusher goes where it is told, and tows a tee that is near by a spring.
struct Tow {
  struct Parameters {
    double stiffness = 100.0;  ///< [1/s^2] of the spring, when it is tight
  };
  using Model = Parameters;

  template <class Real>
  struct Bodies {
    simd::Vector2<Real> pusher, pusher_velocity, tee, tee_velocity;
    Real yaw, yaw_rate;
    Real tightness;  // [0, 1] of the spring; no state shows it
  };

  static constexpr double kStartTolerance = 1e-12;

  static Model modelOf(const Parameters& parameters) { return parameters; }

  static Bodies<double> bodiesOf(const WorldState& state) {
    return {state.pusher_position,
            state.pusher_velocity,
            state.tee_position,
            state.tee_velocity,
            state.tee_yaw,
            state.tee_yaw_rate,
            0.0};
  }

  static WorldState stateOf(const Bodies<double>& bodies) {
    return {bodies.pusher,       bodies.pusher_velocity, bodies.tee,
            bodies.tee_velocity, wrapAngle(bodies.yaw),  bodies.yaw_rate};
  }

  template <class Real>
  static void substep(const Model& model, const simd::Vector2<Real>& command, Bodies<Real>& bodies) {
    constexpr double kReach = 0.1;  // [m]
    constexpr double kDamping = 0.9;
    constexpr double kTightening = 0.1;
    const simd::Vector2<Real> way = bodies.pusher - bodies.tee;
    const Real wanted = simd::select(way.dot(way) < Real(kReach * kReach), Real(1.0), Real(0.0));
    bodies.tightness += kTightening * (wanted - bodies.tightness);
    bodies.pusher_velocity = command;
    bodies.tee_velocity += simd::scaled<Real>(kSubstep * model.stiffness * bodies.tightness, way);
    bodies.tee_velocity = simd::scaled<Real>(kDamping, bodies.tee_velocity);
    bodies.yaw_rate *= kDamping;
    bodies.pusher += simd::scaled<Real>(kSubstep, bodies.pusher_velocity);
    bodies.tee += simd::scaled<Real>(kSubstep, bodies.tee_velocity);
    bodies.yaw += kSubstep * bodies.yaw_rate;
  }

  template <class One, class Many, class Function>
  static void forEachNumber(One& one, Many& many, Function function) {
    for (Eigen::Index axis = 0; axis < 2; ++axis) {
      function(one.pusher[axis], many.pusher[axis]);
      function(one.pusher_velocity[axis], many.pusher_velocity[axis]);
      function(one.tee[axis], many.tee[axis]);
      function(one.tee_velocity[axis], many.tee_velocity[axis]);
    }
    function(one.yaw, many.yaw);
    function(one.yaw_rate, many.yaw_rate);
    function(one.tightness, many.tightness);
  }
};

SimulatorKind towKind() {
  SimulatorKind kind;
  kind.name = "tow";
  kind.title = "tow";
  kind.version = "1";
  kind.parameters = {{"stiffness", "1/s^2", "of the spring, when it is tight", Tow::Parameters().stiffness}};
  kind.start_tolerance = Tow::kStartTolerance;
  kind.load = [](const ParameterSet& parameters) {
    const Tow::Parameters knobs = {parameters.get<double>("stiffness")};
    SimulatorModel model;
    model.parameters = parameters;
    model.make_world = [knobs] { return std::make_unique<PlanarSimulator<Tow>>(knobs); };
    model.make_lanes = [knobs](int lanes) { return std::make_unique<PlanarLanes<Tow>>(lanes, knobs); };
    return model;
  };
  return kind;
}

std::vector<testing::Subject> tows() { return {{towKind()}, {towKind(), {{"stiffness", "20.0"}}}}; }

/// Says that it is in double precision, and is not.
struct Rounding : Tow {
  static Bodies<double> bodiesOf(const WorldState& state) {
    Bodies<double> bodies = Tow::bodiesOf(state);
    bodies.tee.x() = static_cast<float>(bodies.tee.x());
    return bodies;
  }
};

TEST(PlanarSimulator, MustStartWhereItIsTold) {
  PlanarSimulator<Rounding> world;
  EXPECT_THROW(world.reset(spawn(3)), SimulationFault);
  EXPECT_NO_THROW(world.reset({}));
}

TEST(PlanarLanes, MustStartWhereTheyAreTold) {
  PlanarLanes<Rounding> lanes(2);
  lanes.reset(0, {});
  EXPECT_THROW(lanes.reset(1, spawn(3)), SimulationFault);
  EXPECT_THROW(lanes.state(1), SimulationFault);
  lanes.step(std::vector<std::optional<Action>>(2, Action{1.0F, 0.0F}));
  EXPECT_THROW(lanes.state(1), SimulationFault);
  EXPECT_GT(lanes.state(0).pusher_position.x(), 0.0);
  lanes.reset(1, {});
  EXPECT_EQ(lanes.state(1), WorldState());
}

}  // namespace

namespace testing {
INSTANTIATE_TEST_SUITE_P(Tow, SimulatorSuite, ::testing::ValuesIn(tows()));
INSTANTIATE_TEST_SUITE_P(Tow, BatchSimulatorSuite, ::testing::ValuesIn(tows()));
}  // namespace testing
}  // namespace pusht
