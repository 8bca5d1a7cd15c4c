// SPDX-License-Identifier: BSD-3-Clause
// Worlds with one, two and three faults at once: each is named, none hides behind another, none is taken for another.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <ostream>
#include <string>
#include <vector>

#include "chipmunk_with.hpp"
#include "composed_world.hpp"
#include "faulty.hpp"
#include "planted_faults.hpp"
#include "pusht_engine/two_mass_engine.hpp"
#include "pusht_testing/long_tests.hpp"
#include "sim2sim_audit/task_figures.hpp"

namespace sim2sim::testing {
namespace {

using P = Property;
using pusht::WorldState;

const std::vector<Property> kNoTeeWalls = {P::kTeeAtWallUp, P::kTeeAtWallDown, P::kTeeAtWallRight, P::kTeeAtWallLeft};

std::vector<Property> operator+(std::vector<Property> a, const std::vector<Property>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// World with faults, and the properties that name them.
struct World {
  std::string name;
  WorldFactory make;
  std::vector<Property> named_by;
};

std::ostream& operator<<(std::ostream& out, const World& world) { return out << world.name; }

/// Substeps of 1 ms.
Composition fine() {
  Composition composition;
  composition.substeps = 100;
  return composition;
}

Composition withExplicitServo(Composition composition) {
  composition.is_servo_explicit = true;
  return composition;
}

Composition withoutTeeWalls(Composition composition) {
  composition.has_tee_walls = false;
  return composition;
}

Composition withSmoothFriction(Composition composition) {
  composition.friction = smoothed(0.1, 1.0);
  return composition;
}

Composition withHeavyTee(Composition composition) {
  composition.change = [](RigidModel& model) {
    model.tee_mass *= 1.3;
    model.tee_moment *= 1.3;
  };
  return composition;
}

/// Friction that falls with the speed (Stribeck's), which is none of the audit's laws.
Composition withStribeckFriction(Composition composition) {
  composition.friction = [](const Eigen::Vector3d& velocities) -> Eigen::Vector3d {
    const double more = 1.0 + std::exp(-4.0 * velocities.head<2>().squaredNorm());
    return more * smoothed(0.05, 0.5)(velocities);
  };
  return composition;
}

WorldFactory late(const WorldFactory& make) {
  InterfaceFault fault;
  fault.delay = 1;
  return [=] { return std::make_unique<Faulty>(make(), fault); };
}

WorldFactory withVelocitiesTimes(double factor, const WorldFactory& make) {
  InterfaceFault fault;
  const auto times = [](double by) {
    return [by](WorldState state) {
      state.pusher_velocity *= by;
      state.tee_velocity *= by;
      state.tee_yaw_rate *= by;
      return state;
    };
  };
  fault.start = times(1.0 / factor);
  fault.report = times(factor);
  return [=] { return std::make_unique<Faulty>(make(), fault); };
}

std::vector<World> worlds() {
  const std::vector<Property> heavy = {P::kTeeMass, P::kTeeMoment};
  return {
      {"short substeps", composed(fine()), {}},
      {"explicit servo", composed(withExplicitServo(fine())), {P::kServoLag}},
      {"no walls for the tee", composed(withoutTeeWalls(fine())), kNoTeeWalls},
      {"smooth friction", composed(withSmoothFriction(fine())), {P::kFrictionSmoothing}},
      {"no law", composed(withStribeckFriction(fine())), {P::kTeeLaw}},
      {"explicit servo, no walls for the tee", composed(withExplicitServo(withoutTeeWalls(fine()))),
       std::vector<Property>{P::kServoLag} + kNoTeeWalls},
      {"explicit servo, smooth friction",
       composed(withExplicitServo(withSmoothFriction(fine()))),
       {P::kServoLag, P::kFrictionSmoothing}},
      {"explicit servo, heavy tee", composed(withExplicitServo(withHeavyTee(fine()))),
       std::vector<Property>{P::kServoLag} + heavy},
      {"no law, no walls for the tee", composed(withStribeckFriction(withoutTeeWalls(fine()))),
       std::vector<Property>{P::kTeeLaw} + kNoTeeWalls},
      {"late, no walls for the tee", late(composed(withoutTeeWalls(fine()))),
       std::vector<Property>{P::kDelay} + kNoTeeWalls},
      {"explicit servo, smooth friction, no walls for the tee",
       composed(withExplicitServo(withSmoothFriction(withoutTeeWalls(fine())))),
       std::vector<Property>{P::kServoLag, P::kFrictionSmoothing} + kNoTeeWalls},
      {"smooth friction, heavy tee, no walls for the tee",
       composed(withSmoothFriction(withHeavyTee(withoutTeeWalls(fine())))),
       std::vector<Property>{P::kFrictionSmoothing} + heavy + kNoTeeWalls},
      {"velocities times 2, explicit servo, no walls for the tee",
       withVelocitiesTimes(2.0, composed(withExplicitServo(withoutTeeWalls(fine())))),
       std::vector<Property>{P::kPusherVelocityFactor, P::kTeeVelocityFactor, P::kYawRateFactor} + kNoTeeWalls},
  };
}

class SeveralFaults : public ::testing::TestWithParam<World> {};

TEST_P(SeveralFaults, AreEachNamedAndNoOther) {
  const Audit audit = auditAgainstTask({GetParam().name, GetParam().make}, 0);
  std::vector<Property> found;
  for (const Comparison& finding : audit.findings()) {
    found.push_back(finding.property);
  }
  EXPECT_THAT(found, ::testing::UnorderedElementsAreArray(GetParam().named_by)) << textOf(audit);
}

/// The last ones have what the others have; the long form takes all.
std::vector<World> chosenWorlds() {
  constexpr std::ptrdiff_t kShort = 5;
  std::vector<World> all = worlds();
  if (!pusht::testing::longTests()) {
    all.erase(all.begin(), all.end() - kShort);
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(Worlds, SeveralFaults, ::testing::ValuesIn(chosenWorlds()));

const Comparison& comparisonIn(const Audit& audit, Property property) {
  return audit.comparisons.at(static_cast<std::size_t>(property));
}

/// Discs have no sizes of boxes. What does not hang on them is told.
TEST(OtherShapes, AreCalledThat) {
  const Audit audit = auditAgainstTask({"discs", [] { return std::make_unique<pusht::TwoMassEngine>(); }}, 0);
  EXPECT_THAT(textOf(audit), ::testing::HasSubstr("the tee is not two boxes"));
  for (const Property size : {P::kPusherRadius, P::kBarHalfLength, P::kBarHalfWidth, P::kStemEnd, P::kStemHalfWidth}) {
    EXPECT_EQ(comparisonIn(audit, size).verdict, PropertyVerdict::kCannotTell) << describe(size).key;
  }
  EXPECT_EQ(comparisonIn(audit, P::kTeeDamping).verdict, PropertyVerdict::kDiffers);
  EXPECT_EQ(comparisonIn(audit, P::kWallUp).verdict, PropertyVerdict::kDiffers);
}

/// A tee with a bar of 50 mm.
TEST(OtherShapes, AreNotTouchedAtADepthThatIsSaid) {
  const WorldFactory make = chipmunkWith([](Physics& physics) { physics.bar_half_length = 0.025; });
  const Audit audit = auditAgainstTask({"short bar", make}, 0);
  EXPECT_THAT(
      comparisonIn(audit, P::kPusherRadius).reason,
      ::testing::HasSubstr("not touched with the pusher's center at (46, 0) mm in its axes, where it is 29 mm"));
}

}  // namespace
}  // namespace sim2sim::testing
