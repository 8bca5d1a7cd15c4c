// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/journal.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "pusht_testing/temporary_folder.hpp"
#include "run_episodes.hpp"

namespace sim2sim {
namespace {

/// A run that goes on says of its first episodes what it would have said in one piece.
TEST(Journal, KeepsWhatEpisodesCsvHasNot) {
  const pusht::testing::TemporaryFolder folder;
  const nlohmann::json identity = {{"seed", 0}};
  Protocol protocol = bare();
  protocol.episodes = 2;
  FinishedEpisode episode{episodesWith(1, 1, 0).front()};
  episode.result.rollouts[kReferenceClosed].limited_commands = 7;
  episode.result.rollouts[kEngineClosed].limited_commands = 9;
  Journal(folder / "journal", protocol, identity).add(episode);

  const Journal again(folder / "journal", protocol, identity);
  ASSERT_EQ(again.kept().size(), 1U);
  const EpisodeResult& kept = again.kept().front().result;
  EXPECT_EQ(kept.rollouts[kReferenceClosed].limited_commands, 7);
  EXPECT_EQ(kept.rollouts[kEngineClosed].limited_commands, 9);
  EXPECT_EQ(kept.rollouts[kReferenceClosed].success, true);
}

}  // namespace
}  // namespace sim2sim
