// SPDX-License-Identifier: BSD-3-Clause
// Every kind of the suite against the task's own figures. What a kind does otherwise on purpose, it declares.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "chipmunk_kind.hpp"
#include "pusht_engine/rigid_body_kind.hpp"
#include "pusht_engine/two_mass_kind.hpp"
#include "pusht_mujoco/mujoco_kind.hpp"
#include "pusht_task/error.hpp"
#include "sim2sim_audit/task_figures.hpp"

namespace sim2sim::testing {
namespace {

class AgainstTask : public ::testing::TestWithParam<const pusht::SimulatorKind& (*)()> {
 protected:
  AgainstTask() : kind_(GetParam()()) {}

  const pusht::SimulatorKind& kind_;
};

std::string nameOfKind(const ::testing::TestParamInfo<AgainstTask::ParamType>& info) { return info.param().name; }

TEST_P(AgainstTask, DiffersOnlyWhereItsKindSaysSo) {
  const Audit audit = auditAgainstTask({kind_.title, kind_.load(kind_.defaults()).make_world, kind_.departures}, 0);
  for (const Comparison& finding : audit.findings()) {
    EXPECT_TRUE(finding.is_declared) << causeOf(finding) << "\n" << textOf(audit);
  }
  EXPECT_FALSE(audit.hasContractErrors());
}

/// A departure that the kind does not have, or that no audit knows, is no departure.
TEST_P(AgainstTask, HasTheDeparturesThatItsKindDeclares) {
  const Audit audit = auditAgainstTask({kind_.title, kind_.load(kind_.defaults()).make_world, kind_.departures}, 0);
  for (const std::string& departure : kind_.departures) {
    const auto declared = std::find_if(audit.comparisons.begin(), audit.comparisons.end(),
                                       [&](const Comparison& one) { return describe(one.property).key == departure; });
    ASSERT_NE(declared, audit.comparisons.end()) << departure;
    EXPECT_NE(declared->verdict, PropertyVerdict::kSame) << departure;
  }
}

TEST(Departures, AreKeysOfProperties) {
  const Measurements task = figuresOf(pusht::fullCircle());
  EXPECT_THAT([&] { compare(task, task, {}, 0.0, {"tee_frictoin_x"}); },
              ::testing::ThrowsMessage<pusht::InvalidInput>(::testing::HasSubstr("departure 'tee_frictoin_x'")));
}

INSTANTIATE_TEST_SUITE_P(Kinds, AgainstTask,
                         ::testing::Values(pusht::mujocoKind, pusht::chipmunkKind, pusht::rigidBodyKind,
                                           pusht::twoMassKind),
                         nameOfKind);

}  // namespace
}  // namespace sim2sim::testing
