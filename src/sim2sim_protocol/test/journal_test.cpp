// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/journal.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "pusht_task/files.hpp"
#include "pusht_testing/temporary_folder.hpp"
#include "run_episodes.hpp"
#include "sim2sim_protocol/results/result_files.hpp"
#include "sim2sim_protocol/results/run_folder.hpp"

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

/// A run that goes on has finished episodes from its first status on, also if it is killed while it loads.
TEST(RunFolder, SaysFromTheFirstMomentHowManyEpisodesAreKept) {
  const pusht::testing::TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "out";
  Protocol protocol = bare();
  protocol.episodes = 2;
  const auto begin = [&](int kept) {
    RunFolder run(path, false, "compare", true);
    run.begin({}, protocol);
    const nlohmann::json status = nlohmann::json::parse(pusht::readFile(path / kStatusFile, "status"));
    EXPECT_EQ(status.at("episodes_finished"), kept);
    if (kept == 0) {
      run.journal()->add({episodesWith(1, 1, 0).front()});
    }
  };
  begin(0);
  begin(1);
}

}  // namespace
}  // namespace sim2sim
