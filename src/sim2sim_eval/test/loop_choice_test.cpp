// SPDX-License-Identifier: BSD-3-Clause
/// The loop as a part of a side of a comparison: settings, record, key of the kept reference.
#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "pusht_policy/policy_choice.hpp"
#include "pusht_testing/refusal.hpp"
#include "sim2sim_eval/batch/loaded_run.hpp"
#include "sim2sim_eval/batch/simulators.hpp"

namespace sim2sim {
namespace {

using pusht::testing::refusalOf;

TEST(LoopOfARole, IsSetBesideItsSimulator) {
  const SimulatorChoice choice = chooseSimulator("two_mass", {"loop.action_delay=2", "loop.hold=1", "block_damp=20"});
  EXPECT_EQ(textOf(choice), "two_mass:block_damp=20.0:loop.action_delay=2");
  EXPECT_EQ(simulatorFromText(textOf(choice)), choice);
  EXPECT_FALSE(choice == chooseSimulator("two_mass", {"block_damp=20"}));
  EXPECT_EQ(textOf(chooseSimulator("two_mass", {"loop.preset=tracker", "loop.observation_delay=1"})),
            "two_mass:loop.preset=tracker");
  const SimulatorRecord record = LoadedSimulator(choice).record();
  EXPECT_EQ(titleOf(record), "two-mass engine, block_damp 20.0, loop.action_delay 2");
  EXPECT_EQ(record.parameters.at("loop.hold"), 1) << "set, though it is the default";
  EXPECT_EQ(record.units.at("loop.action_delay"), "control steps");
  EXPECT_FALSE(LoadedSimulator(choice).simulatorRecord().parameters.contains("loop.hold"));
  EXPECT_EQ(refusalOf([&] { requireNoLoop(choice, "an audit"); }),
            "loop.action_delay 2: must be left out: an audit has no policy in a loop");
  EXPECT_EQ(refusalOf([&] { chooseSimulator("two_mass", {"loop.action_delay=-1"}); }),
            "loop: action_delay -1: must be from 0 to 100 [control steps]");
}

TEST(LoopOfASide, IsPartOfTheReferencesKey) {
  const auto key = [](const std::vector<std::string>& reference, const std::vector<std::string>& engine) {
    const SimulatorChoice chosen = chooseSimulator("two_mass", engine);
    const LoadedRun run({pusht::kExpertPolicy}, chooseSimulator("two_mass", reference), {chosen}, RunOptions());
    return run.referenceKey(RunOptions());
  };
  EXPECT_NE(key({"loop.action_delay=1"}, {}), key({}, {}));
  EXPECT_EQ(key({}, {"loop.action_delay=1"}), key({}, {})) << "what the engine does is not in the reference";
}

}  // namespace
}  // namespace sim2sim
