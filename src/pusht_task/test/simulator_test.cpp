// SPDX-License-Identifier: BSD-3-Clause
// What the interface refuses of a simulator, ours or foreign.
#include "pusht_task/simulator.hpp"

#include <gmock/gmock.h>

#include <limits>
#include <string>
#include <vector>

#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"

namespace pusht {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// Is after a reset and after a step where the test says.
class Puppet : public Simulator {
 public:
  using Simulator::Simulator;

  WorldState after_reset;
  WorldState after_step;

 private:
  void doReset(const WorldState& /*state*/) override { state_ = after_reset; }
  void doStep(const Action& /*action*/) override { state_ = after_step; }
  WorldState doState() const override { return state_; }

  WorldState state_;
};

template <class Function>
std::string faultOf(const Function& function) {
  try {
    function();
  } catch (const SimulationFault& fault) {
    return fault.what();
  }
  return "none";
}

WorldState teeAt(double x, double yaw) {
  WorldState state;
  state.tee_position.x() = x;
  state.tee_yaw = yaw;
  return state;
}

TEST(Simulators, MustStartWhereTheyAreTold) {
  Puppet puppet("/mine");
  const auto reset = [&](const WorldState& found) {
    puppet.after_reset = found;
    return faultOf([&] { puppet.reset(teeAt(0.1, 3.0)); });
  };
  EXPECT_EQ(reset(teeAt(0.1 + 1e-7, 3.0)), "none") << "in single precision";
  EXPECT_EQ(reset(teeAt(0.11, 3.0)), "/mine: reset: tee_x 0.11: must be within 1e-06 of 0.1");
  EXPECT_EQ(reset(teeAt(0.1, 0.5)), "/mine: reset: tee_yaw 0.5: must be within 1e-06 of 3.0");
  EXPECT_THAT(reset(teeAt(0.1, 3.0 + 2.0 * kPi)), HasSubstr("must be in [-pi, pi)"));
  WorldState moving = teeAt(0.1, 3.0);
  moving.tee_velocity.y() = 0.2;
  EXPECT_EQ(reset(moving), "/mine: reset: tee_vy 0.2: must be within 1e-06 of 0");
  moving.tee_velocity.y() = -0.2;
  EXPECT_EQ(reset(moving), "/mine: reset: tee_vy -0.2: must be within 1e-06 of 0");
  EXPECT_THROW(puppet.step({}), InvalidInput) << "it needs a reset";
}

TEST(Simulators, MayProjectVelocities) {
  Puppet puppet;
  WorldState start;
  start.tee_velocity.y() = 0.2;
  EXPECT_EQ(faultOf([&] { puppet.reset(start); }), "none");
}

TEST(Simulators, MustNotLeaveThePlausibleRange) {
  Puppet puppet("/mine");
  const auto step = [&](const WorldState& found) {
    puppet.after_step = found;
    return faultOf([&] {
      puppet.reset({});
      puppet.step({});
    });
  };
  EXPECT_EQ(step(teeAt(-999.0, -kPi)), "none");
  EXPECT_EQ(step(teeAt(-1.3e59, 0.0)), "/mine: step: tee_x -1.3e+59 m: must be within 1000.0 m");
  EXPECT_THAT(step(teeAt(0.0, kPi)), HasSubstr("tee_yaw 3.141592653589793 rad: must be in [-pi, pi)"));
  WorldState fast;
  fast.pusher_velocity.x() = 1e300;
  EXPECT_THAT(step(fast), HasSubstr("pusher_vx 1e+300 m/s"));
  fast = WorldState();
  fast.tee_yaw_rate = -1e9;
  EXPECT_THAT(step(fast), HasSubstr("tee_yaw_rate"));
}

TEST(Simulators, AreNotToldToStartOutOfRange) {
  Puppet puppet;
  EXPECT_THROW(puppet.reset(teeAt(1e300, 0.0)), InvalidInput);
}

TEST(Simulators, StartAsNearAsTheySay) {
  Puppet puppet("/mine", 1e-12);
  puppet.after_reset = teeAt(0.25 + 1e-9, 0.0);
  EXPECT_THAT(faultOf([&] { puppet.reset(teeAt(0.25, 0.0)); }), HasSubstr("must be within 1e-12 of 0.25"));
  puppet.after_reset = teeAt(0.25 + 1e-13, 0.0);
  EXPECT_EQ(faultOf([&] { puppet.reset(teeAt(0.25, 0.0)); }), "none");
}

TEST(Simulators, SayOfTheirStartsNoMoreThanTheTaskAllows) {
  EXPECT_EQ(Puppet().startTolerance(), kStartTolerance);
  for (const double bad : {0.0, -1e-9, 1.1e-6, std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(Puppet("/mine", bad), InvalidInput) << bad;
  }
  EXPECT_THAT([] { checkedStartTolerance(0.1); },
              ThrowsMessage<InvalidInput>("start_tolerance 0.1: must be above 0 and at most 1e-06"));
}

}  // namespace
}  // namespace pusht
