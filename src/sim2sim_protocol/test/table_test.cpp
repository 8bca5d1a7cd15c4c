// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "run_episodes.hpp"
#include "sim2sim_protocol/results/attribution.hpp"
#include "sim2sim_protocol/results/attribution_files.hpp"
#include "sim2sim_protocol/results/metrics.hpp"
#include "sim2sim_protocol/results/text.hpp"

namespace sim2sim {
namespace {

using ::testing::AnyOf;
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

TEST(TableOfAnAttribution, SaysWhereAllOffIsFartherThanATeeThatNeverMoves) {
  const auto gap = [](const char* title, double all_off, double null_model) {
    AttributedGap result{"", title, "m", all_off, 0.01, {Share{}}};
    result.null_model = {null_model, std::nullopt};
    return result;
  };
  Attribution attribution{"MuJoCo", "engine", "expert", 30, "", 2, 0, {"drag"}, {}};
  attribution.gaps = {gap("position, open loop", 0.2, 0.1), gap("angle, open loop", 0.05, 0.1),
                      gap("success, closed loop", 0.5, std::nan(""))};
  EXPECT_THAT(table(attribution),
              HasSubstr("\n(all off is farther from MuJoCo than a tee that never moves: position, open "
                        "loop; shares of such a gap say little of a good engine)\n"));
  EXPECT_THAT(table(attribution), HasSubstr("leave_one_out in attribution.json, plot_sweep --costs"));
  attribution.gaps.front().all_off = 0.05;
  attribution.orders = 40;  // without all combinations no switch is left out alone
  EXPECT_THAT(table(attribution), Not(AnyOf(HasSubstr("farther"), HasSubstr("leave_one_out"))));
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
  const Summary few = summarize(bare(), episodesWith(kFewestPairs - 1, 5, 3));
  EXPECT_FALSE(few.mean(kEngineReplay, "mean_position_divergence").interval);
  EXPECT_TRUE(metrics(configuration, few).at("mean_pos_divergence_interval_m").is_null());
  EXPECT_THAT(table(configuration, few), HasSubstr("most need 10 episodes, divergences and differences 20"));
  const Summary enough = summarize(bare(), episodesWith(kFewestPairs, 5, 3));
  EXPECT_TRUE(enough.mean(kEngineReplay, "mean_position_divergence").interval);
  EXPECT_GT(enough.mean(kEngineReplay, "mean_position_divergence").interval->low, 0.0);
}

TEST(Table, SaysIfFewEpisodesCarryAMean) {
  std::vector<EpisodeResult> episodes = episodesAgainstNull(-0.05);
  EXPECT_THAT(table(bareConfiguration(), summarize(bare(), episodes)), Not(HasSubstr("carry")));
  for (EpisodeResult& episode : episodes) {  // two of 40 are 4 m of 4.38 m, 91 %
    episode.rollouts[kEngineReplay].at("mean_position_divergence") = episode.index < 2 ? 2.0 : 0.01;
  }
  EXPECT_THAT(table(bareConfiguration(), summarize(bare(), episodes)),
              HasSubstr("\n    largest 5 % carry   91 % of the mean\n"));
  episodes.resize(19);
  EXPECT_THAT(table(bareConfiguration(), summarize(bare(), episodes)), Not(HasSubstr("carry"))) << "too few to say";
}

/// A horizon has the episodes that last so long, and its own null model.
TEST(Table, LeadsWithTheHorizonThatEpisodesHaveInCommon) {
  std::vector<EpisodeResult> episodes = episodesAgainstNull(-0.05);
  const auto text = [&] { return table(bareConfiguration(), summarize(bare(), episodes)); };
  EXPECT_THAT(text(), Not(HasSubstr("first 2 s"))) << "no episode lasts as long";
  for (EpisodeResult& episode : episodes) {
    RolloutResult& replay = episode.rollouts[kEngineReplay];
    for (const char* horizon : {"early_", "early_5s_"}) {
      if (horizon == std::string("early_") || episode.index < 30) {
        replay.at(std::string(horizon) + "position_divergence") = 0.02 + 1e-4 * episode.index;
        replay.at(std::string(horizon) + "angle_divergence") = 0.2;
        replay.at(std::string(horizon) + "null_position_divergence") = 0.01;
        replay.at(std::string(horizon) + "null_angle_divergence") = 0.3 + 0.01 * (episode.index % 2);
      }
    }
  }
  EXPECT_THAT(text(), HasSubstr("angle\n  first 2 s             0.0220 m ["));
  EXPECT_THAT(text(), HasSubstr("] (!)"));
  EXPECT_THAT(text(), HasSubstr("\n    - null model        +0.0120 m ["));
  EXPECT_THAT(text(), HasSubstr("\n  first 5 s (n 30)      0.0215 m ["));
  EXPECT_THAT(text(), HasSubstr("\n  whole episode         0.0510 m ["));
  EXPECT_LT(text().find("first 5 s"), text().find("whole episode"));
  const nlohmann::json json = metrics(bareConfiguration(), summarize(bare(), episodes));
  EXPECT_EQ(json.at("engine_replay_early_5s_position_divergence_episodes"), 30);
  EXPECT_EQ(json.at("engine_replay_early_position_divergence_beats_null"), false);
  EXPECT_EQ(json.at("engine_replay_early_angle_divergence_beats_null"), true);
  EXPECT_EQ(json.at("mean_pos_divergence_episodes"), 40);
}

/// Replays nearer to the reference than its variants over 2 s, farther away over whole episodes, in position.
std::vector<EpisodeResult> episodesWithVariants(const RunConfiguration& configuration) {
  std::vector<EpisodeResult> episodes = episodesAgainstNull(-0.05);
  for (EpisodeResult& episode : episodes) {
    RolloutResult& replay = episode.rollouts[kEngineReplay];
    replay.at("early_position_divergence") = 0.001;
    replay.at("early_angle_divergence") = 0.2 + 0.001 * (episode.index % 2);
    replay.at("early_null_position_divergence") = 0.01;
    replay.at("early_null_angle_divergence") = 0.1;
    RolloutResult variant = replay;
    variant.success = episode.index < 15;
    variant.at("mean_position_divergence") = 0.005;
    variant.at("early_position_divergence") = 0.05;
    episode.rollouts.resize(configuration.protocol.rolloutNames().size(), variant);
  }
  return episodes;
}

TEST(Table, SaysOverWhichHorizonTheEngineIsFartherThanModelVariants) {
  RunConfiguration configuration = bareConfiguration();
  configuration.reference = {"mujoco", "MuJoCo"};
  configuration.engine = {"two_mass", "two-mass engine"};
  configuration.protocol.model_variants = {"timestep=0.005", "cone=elliptic:impratio=10.0"};
  configuration.protocol.closed_variants = {"timestep=0.005"};
  const std::string text = table(configuration, summarize(configuration.protocol, episodesWithVariants(configuration)));
  EXPECT_THAT(text, HasSubstr("\nMuJoCo, its variants           position, whole episode         angle, whole episode\n"
                              "  timestep=0.005               0.0050 m ["));
  EXPECT_THAT(text, HasSubstr("\n  cone=elliptic:impratio=10.0  0.0050 m ["));
  EXPECT_THAT(text,
              HasSubstr("\nIn position, over the first 2 s, the two-mass engine is nearer to MuJoCo than MuJoCo's "
                        "largest model variant.\n"
                        "In angle, over the first 2 s, it is not shown whether the two-mass engine is farther "
                        "from MuJoCo than MuJoCo's largest model variant.\n"
                        "In position, over the whole episode, the two-mass engine is farther from MuJoCo than "
                        "MuJoCo's largest model variant.\n"
                        "In angle, over the whole episode, it is not shown whether the"));
  EXPECT_THAT(text, HasSubstr("\nMuJoCo, its variants           success, closed loop            less reference\n"
                              "  timestep=0.005               15  0.375 ["));
  EXPECT_LT(text.rfind("its variants"), text.find("(!) not shown")) << "footnotes come last";
}

TEST(Table, HeadsClosedLoopsInModelVariantsAlone) {
  RunConfiguration configuration = bareConfiguration();
  configuration.reference = {"mujoco", "MuJoCo"};
  configuration.protocol.closed_variants = {"timestep=0.005"};
  const std::string text = table(configuration, summarize(configuration.protocol, episodesWithVariants(configuration)));
  EXPECT_THAT(text, HasSubstr("\nMuJoCo, its variants    success, closed loop            less reference\n"
                              "  timestep=0.005        15  0.375 ["));
  EXPECT_THAT(text, Not(HasSubstr("model variant.")));
}

TEST(Table, ShowsMultiplesOfTheFloorWithIntervals) {
  EXPECT_EQ(timesText(68.4, Interval{9.3, 416.0}), "68 times [9.3, 420]");
  EXPECT_EQ(timesText(99.6, Interval{2e-5, 99.4}), "100 times [0.00002, 99]") << "no exponent";
  EXPECT_EQ(timesText(1.26, std::nullopt), "1.3 times");
  EXPECT_EQ(timesText(std::nan(""), std::nullopt), "undefined");
}

/// Twenty episodes with a state-reset replay, in which the engine misses `missed` of the pushes.
std::vector<EpisodeResult> episodesWithPushes(double missed) {
  std::vector<EpisodeResult> episodes = episodesWith(20, 12, 1);
  for (EpisodeResult& episode : episodes) {
    RolloutResult replay = episode.rollouts[kEngineReplay];
    replay.at("pushes_missed") = missed;
    replay.at("pushes_turned") = missed < 1.0 ? 0.43 : std::nan("");
    replay.at("push_direction_error") = 1.25;
    episode.rollouts.push_back(replay);
  }
  return episodes;
}

/// In Gaffke's bound one more episode, at 0 or 1, has the weight 1 - 0.025^(1/20) = 0.168.
TEST(Table, SaysWhatBecomesOfPushes) {
  RunConfiguration configuration = bareConfiguration();
  configuration.reference = {"mujoco", "MuJoCo"};
  configuration.protocol.reanchor = {5};
  const auto text = [&](double missed) {
    return table(configuration, summarize(configuration.protocol, episodesWithPushes(missed)));
  };
  EXPECT_THAT(text(0.18), HasSubstr("\npushes, open loop\n"
                                    "  in 5 steps            direction error 1.2500 rad ["));
  EXPECT_THAT(text(0.18), HasSubstr("\n    missed              in the mean episode 18 % [15, 32] of those that move "
                                    "MuJoCo's tee miss here; of the others 43 % [36, 53] move it the other way\n"));
  EXPECT_LT(text(0.18).find("pushes, open loop"), text(0.18).find("divergence, open loop"));
  EXPECT_THAT(text(1.0), HasSubstr(" 100 % [83, 100] of those that move MuJoCo's tee miss here\n"));
  EXPECT_THAT(text(std::nan("")), Not(HasSubstr("pushes"))) << "the reference's tee does not move";
  configuration.reference = {"two_mass", "two-mass engine"};
  EXPECT_THAT(text(0.0), HasSubstr(" 0 % [0, 17] of those that move the two-mass engine's tee miss here;"));
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
