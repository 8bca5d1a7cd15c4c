// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "run_episodes.hpp"
#include "sim2sim_protocol/results/metrics.hpp"

namespace sim2sim {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// Replays that are 0.01 m worse than a tee that never moves, in every episode but for a small scatter.
std::vector<EpisodeResult> episodesAgainstNull(double difference) {
  std::vector<EpisodeResult> episodes = episodesWith(40, 20, 10);
  for (EpisodeResult& episode : episodes) {
    for (RolloutResult& rollout : episode.rollouts) {
      rollout.quantities.fill(std::nan(""));
    }
    RolloutResult& replay = episode.rollouts[kEngineReplay];
    replay.at("null_position_divergence") = 0.1 + 0.001 * (episode.index % 3);
    replay.at("mean_position_divergence") =
        replay.at("null_position_divergence") + difference + 1e-4 * (episode.index % 2);
    replay.at("null_angle_divergence") = 1.0;
    replay.at("mean_angle_divergence") = 0.5 + 0.001 * (episode.index % 2);
  }
  return episodes;
}

TEST(Table, MarksADivergenceThatDoesNotBeatTheNullModel) {
  const RunConfiguration configuration = bareConfiguration();
  const Summary worse = summarize(bare(), episodesAgainstNull(0.01));
  EXPECT_EQ(worse.baselines[kEngineReplay][0].beatsNull(), false);
  EXPECT_EQ(worse.baselines[kEngineReplay][1].beatsNull(), true);
  EXPECT_NEAR(worse.baselines[kEngineReplay][0].minus_null.value, 0.01005, 1e-12);
  EXPECT_NEAR(worse.baselines[kEngineReplay][1].share_of_null, 0.5005, 1e-9);
  EXPECT_THAT(table(configuration, worse), HasSubstr("(!) not shown to be less than that of a tee that never moves"));
  EXPECT_THAT(divergences(worse, ", "), HasSubstr("] (!), 0.5005 rad"));
  EXPECT_EQ(metrics(configuration, worse).at("mean_pos_divergence_beats_null"), false);
  EXPECT_EQ(metrics(configuration, worse).at("mean_ang_divergence_beats_null"), true);

  const Summary better = summarize(bare(), episodesAgainstNull(-0.01));
  EXPECT_EQ(better.baselines[kEngineReplay][0].beatsNull(), true);
  EXPECT_EQ(table(configuration, better).find("(!)"), std::string::npos);
}

/// Floors of 10 episodes, in the first `unmoved` of which the reference does exactly what it did.
std::vector<EpisodeResult> episodesWithFloors(int unmoved) {
  std::vector<EpisodeResult> episodes = episodesWith(10, 5, 3);
  for (EpisodeResult& episode : episodes) {
    for (const double moved : {1e-9, 1e-6}) {
      RolloutResult floor = episode.rollouts[kEngineReplay];
      floor.at("mean_position_divergence") = episode.index < unmoved ? 0.0 : moved;
      floor.at("mean_angle_divergence") = 0.0;
      episode.rollouts.push_back(floor);
    }
  }
  return episodes;
}

TEST(Table, SaysIfTheReferenceDoesNotSeeTheSmallestShift) {
  RunConfiguration configuration;
  const auto text = [&configuration](int unmoved) {
    return table(configuration, summarize(configuration.protocol, episodesWithFloors(unmoved)));
  };
  EXPECT_THAT(text(6), HasSubstr("exactly 0 in 6 of 10 episodes: the reference does not see so small a shift"));
  EXPECT_THAT(text(5), Not(HasSubstr("exactly 0")));
}

TEST(Table, GivesNoIntervalBelowTheFewestEpisodes) {
  const RunConfiguration configuration = bareConfiguration();
  const Summary few = summarize(bare(), episodesWith(kFewestEpisodes - 1, 5, 3));
  EXPECT_FALSE(few.mean(kEngineReplay, "mean_position_divergence").interval);
  EXPECT_TRUE(metrics(configuration, few).at("mean_pos_divergence_interval_m").is_null());
  EXPECT_THAT(table(configuration, few), HasSubstr("most need 10 episodes"));
  const Summary enough = summarize(bare(), episodesWith(kFewestEpisodes, 5, 3));
  EXPECT_TRUE(enough.mean(kEngineReplay, "mean_position_divergence").interval);
  EXPECT_GT(enough.mean(kEngineReplay, "mean_position_divergence").interval->low, 0.0);
}

TEST(Table, ShowsRatesWithIntervals) {
  RunConfiguration configuration = bareConfiguration();
  configuration.reference = {"mujoco", "MuJoCo"};
  configuration.engine = {"two_mass", "two-mass engine"};
  const Summary summary = summarize(bare(), episodesWith(50, 31, 10));
  const std::string text = table(configuration, summary);
  EXPECT_THAT(text, HasSubstr("MuJoCo (reference)"));
  EXPECT_THAT(text, HasSubstr("two-mass engine"));
  EXPECT_THAT(text, HasSubstr("31  0.620 [0.482, 0.741]"));
  EXPECT_THAT(text, HasSubstr("10  0.200 [0.112, 0.330]"));
  EXPECT_THAT(text, HasSubstr("32 %"));
  configuration.engine = {"mine", "my own"};
  EXPECT_THAT(table(configuration, summary), HasSubstr("my own\n"));
}

}  // namespace
}  // namespace sim2sim
