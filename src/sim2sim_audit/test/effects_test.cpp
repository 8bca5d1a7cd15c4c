// SPDX-License-Identifier: BSD-3-Clause
// Whether estimated effects are of the right size: against the divergence that faults make in replays in MuJoCo.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdio>
#include <string>
#include <vector>

#include "planted_faults.hpp"
#include "pusht_testing/golden.hpp"
#include "pusht_testing/long_tests.hpp"
#include "replay.hpp"
#include "sim2sim_audit/audit.hpp"

namespace sim2sim::testing {
namespace {

/// The scripted expert's episodes of the golden vectors, as a world without a fault runs them.
std::vector<EpisodeToReplay> expertEpisodes(const WorldFactory& clean) {
  constexpr std::size_t kEpisodes = 10;
  const auto world = clean();
  std::vector<EpisodeToReplay> episodes;
  for (const auto& golden : pusht::testing::loadGolden("expert_actions.json", "cases")) {
    world->reset(pusht::testing::worldPose(golden.at("start_tee_xyyaw_pusher_xy")));
    EpisodeToReplay episode = {{world->state()}, {}};
    for (const auto& action : golden.at("actions")) {
      episode.actions.push_back(pusht::testing::action(action));
      world->step(episode.actions.back());
      episode.states.push_back(world->state());
    }
    episodes.push_back(episode);
    if (episodes.size() == kEpisodes) {
      break;
    }
  }
  return episodes;
}

/// A kind without a fault: what it measures, and the expert's episodes in it.
struct CleanKind {
  explicit CleanKind(const WorldFactory& make) : measurements(measured(make)), episodes(expertEpisodes(make)) {}

  Measurements measurements;
  std::vector<EpisodeToReplay> episodes;
};

/// The table of effects is made from what the long form prints: divergence per unit of the difference. The short one
/// has every third fault.
TEST(Effects, AreOfTheRightSize) {
  const CleanKind mujoco(cleanMujoco());
  const CleanKind chipmunk(cleanChipmunk());
  const std::vector<PlantedFault> faults = plantedFaults();
  for (std::size_t i = 0; i < faults.size(); i += pusht::testing::longTests() ? 1 : 3) {
    const PlantedFault& fault = faults[i];
    const bool in_mujoco = static_cast<bool>(fault.in_mujoco);
    const WorldFactory& faulty = in_mujoco ? fault.in_mujoco : fault.in_chipmunk;
    if (!faulty) {
      continue;
    }
    const CleanKind& clean = in_mujoco ? mujoco : chipmunk;
    const double divergence = divergenceInReplays(*faulty(), clean.episodes);
    const std::vector<Comparison> findings = compare(clean.measurements, measured(faulty), {}, 1e-12).findings();
    ASSERT_FALSE(findings.empty()) << fault.name;
    const Comparison& first = findings.front();
    const double per_unit = divergence / (first.effect / describe(first.property).effect);
    std::printf("%-40s %-24s divergence %9.3g m, estimated %9.3g m, per unit %9.3g\n", fault.name.c_str(),
                describe(first.property).key, divergence, first.effect, per_unit);
    constexpr double kSize = 1e-4;    // [m] smaller ones need no order
    constexpr double kFactor = 10.0;  // an order of magnitude either way
    if (isContract(first.property) || divergence < kSize) {
      continue;
    }
    EXPECT_LT(first.effect, kFactor * divergence) << fault.name;
    EXPECT_GT(first.effect, divergence / kFactor) << fault.name;
  }
}

}  // namespace
}  // namespace sim2sim::testing
