// SPDX-License-Identifier: BSD-3-Clause
// Every kind of the suite against the task's own figures. What a kind does otherwise on purpose, it declares here.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <string>
#include <vector>

#include "pusht_chipmunk/chipmunk_kind.hpp"
#include "pusht_engine/rigid_body_kind.hpp"
#include "pusht_engine/two_mass_kind.hpp"
#include "pusht_mujoco/mujoco_kind.hpp"
#include "sim2sim_audit/task_figures.hpp"

namespace sim2sim::testing {
namespace {

/// Kind, and the properties in which it differs from the task on purpose.
struct Declared {
  const pusht::SimulatorKind& (*kind)();
  std::vector<Property> differences;
};

void PrintTo(const Declared& declared, std::ostream* out) {  // NOLINT(readability-identifier-naming)
  *out << declared.kind().name;
}

/// The two-mass engine: two discs and point masses, drag on both, a servo that knows no force, no frictions, no walls.
const std::vector<Property> kOfTwoMass = {
    Property::kServoGain,    Property::kServoLimit,    Property::kPusherDamping,   Property::kPusherMass,
    Property::kTeeMass,      Property::kTeeMoment,     Property::kTeeDamping,      Property::kTeeYawDamping,
    Property::kTeeFrictionX, Property::kTeeFrictionY,  Property::kTeeYawFriction,  Property::kDampingPoint,
    Property::kCenterOfMass, Property::kPusherRadius,  Property::kBarHalfLength,   Property::kBarHalfWidth,
    Property::kStemEnd,      Property::kStemHalfWidth, Property::kContactFriction, Property::kWallUp,
    Property::kWallDown,     Property::kWallRight,     Property::kWallLeft,        Property::kHiddenState};

class AgainstTask : public ::testing::TestWithParam<Declared> {};

TEST_P(AgainstTask, DiffersWhereItsKindSaysSo) {
  const pusht::SimulatorKind& kind = GetParam().kind();
  const Audit audit = auditAgainstTask({kind.title, kind.load(kind.defaults()).make_world}, 0);
  for (const Comparison& finding : audit.findings()) {
    EXPECT_THAT(GetParam().differences, ::testing::Contains(finding.property)) << causeOf(finding) << "\n"
                                                                               << textOf(audit);
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, AgainstTask,
                         ::testing::Values(Declared{pusht::mujocoKind, {}}, Declared{pusht::chipmunkKind, {}},
                                           Declared{pusht::rigidBodyKind, {}},
                                           Declared{pusht::twoMassKind, kOfTwoMass}));

}  // namespace
}  // namespace sim2sim::testing
