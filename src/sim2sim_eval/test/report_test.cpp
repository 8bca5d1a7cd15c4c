// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/testing/decimal_comma.hpp"
#include "sim2sim_eval/batch/comparison.hpp"

namespace sim2sim {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

/// The modes alone.
Protocol bare() {
  Protocol protocol;
  protocol.floor = false;
  return protocol;
}

RunConfiguration bareConfiguration() {
  RunConfiguration configuration;
  configuration.protocol = bare();
  return configuration;
}

/// `total` episodes, the first `reference` and `engine` of which succeed.
std::vector<EpisodeResult> episodesWith(int total, int reference, int engine) {
  std::vector<EpisodeResult> episodes;
  for (int i = 0; i < total; ++i) {
    EpisodeResult episode;
    episode.index = i;
    episode.seed = 10'000U + static_cast<std::uint64_t>(i);
    for (RolloutResult& rollout : episode.rollouts) {
      rollout.at("final_position_error") = 0.0;
      rollout.at("final_angle_error") = 0.0;
    }
    episode.rollouts[kReferenceClosed].success = i < reference;
    episode.rollouts[kEngineClosed].success = i < engine;
    episode.rollouts[kEngineClosed].at("mean_position_divergence") = 0.5;
    episode.rollouts[kEngineClosed].at("mean_angle_divergence") = 0.5;
    episode.rollouts[kEngineReplay].success = true;  // must not count
    episode.rollouts[kEngineReplay].at("mean_position_divergence") = 0.01 * i;
    episode.rollouts[kEngineReplay].at("mean_angle_divergence") = 0.05 * i;
    episodes.push_back(episode);
  }
  return episodes;
}

TEST(Summarize, CountsTheClosedLoopsAndAveragesTheReplay) {
  const Summary summary = summarize(bare(), episodesWith(50, 31, 10));
  EXPECT_EQ(summary.reference.successes, 31);
  EXPECT_EQ(summary.engine.successes, 10);
  EXPECT_NEAR(summary.outcomes.transfer.value(), 10.0 / 31.0, 1e-15);
  EXPECT_NEAR(summary.mean(kEngineReplay, "mean_position_divergence").value, 0.01 * 24.5, 1e-15);
  EXPECT_NEAR(summary.mean(kEngineReplay, "mean_angle_divergence").value, 0.05 * 24.5, 1e-14);
}

TEST(Summarize, TransferIsUndefinedWithoutReferenceSuccess) {
  const Summary summary = summarize(bare(), episodesWith(5, 0, 1));
  EXPECT_FALSE(summary.outcomes.transfer);
  const RunConfiguration configuration = bareConfiguration();
  EXPECT_TRUE(metrics(configuration, summary).at("transfer").is_null());
  EXPECT_THAT(table(configuration, summary), HasSubstr("undefined"));
}

TEST(DoubtAboutPolicy, IsRaisedWhereATrainedOneNeverSucceedsAtHome) {
  RunConfiguration configuration = bareConfiguration();
  configuration.policy = "stale.pt";
  const nlohmann::json checkpoint = {{"policy", {{"sha256", "8997"}}}};
  const auto doubt = [&](int reference_successes, const nlohmann::json& provenance) {
    return doubtAboutPolicy(metrics(configuration, summarize(bare(), episodesWith(5, reference_successes, 1))),
                            provenance);
  };
  EXPECT_THAT(doubt(0, checkpoint), HasSubstr("policy stale.pt never succeeds in the reference"));
  EXPECT_EQ(doubt(1, checkpoint), "");
  configuration.reference = {"chipmunk", "Chipmunk"};
  EXPECT_THAT(doubt(0, checkpoint), HasSubstr("never succeeds in the reference. It looks"));
  configuration.reference = {"mujoco", "MuJoCo"};
  EXPECT_THAT(doubt(0, checkpoint), HasSubstr("in the reference, the simulator it was trained in. It looks"));
  configuration.policy = "somebody's node";
  for (const char* other : {R"({"policy": {"sha256": ""}})", R"({"policy": {"runs_on": "scripted"}})",
                            R"({"policy": {"sha256": 5}})", R"({"policy": {}})", "{}"}) {
    EXPECT_EQ(doubt(0, nlohmann::json::parse(other)), "") << other;
  }
}

TEST(Metrics, HasTheCoursesKeysAtTheTopSortedAndRounded) {
  RunConfiguration configuration = bareConfiguration();
  configuration.policy = "some/policy.pt";
  configuration.protocol.first_episode = 5;
  configuration.protocol.episodes = 3;
  configuration.reference = {"mujoco", "MuJoCo"};
  configuration.engine = {"two_mass", "two-mass engine"};
  const std::string text = jsonText(metrics(configuration, summarize(bare(), episodesWith(3, 2, 1))));
  const nlohmann::json json = nlohmann::json::parse(text);
  EXPECT_EQ(json.at("episodes"), 3);
  EXPECT_EQ(json.at("first_episode"), 5);
  EXPECT_EQ(json.at("reference_simulator"), "mujoco");
  EXPECT_EQ(json.at("engine_simulator"), "two_mass");
  EXPECT_EQ(json.at("seed"), 0);
  EXPECT_EQ(json.at("smoke"), false);
  EXPECT_EQ(json.at("policy"), "some/policy.pt");
  EXPECT_EQ(json.at("mj_success_rate"), 0.666667);
  EXPECT_EQ(json.at("engine_success_rate"), 0.333333);
  EXPECT_EQ(json.at("mean_pos_divergence_m"), 0.01);
  EXPECT_EQ(json.at("mean_ang_divergence_rad"), 0.05);
  EXPECT_EQ(json.at("transfer"), 0.5);
  std::vector<std::string> keys;
  for (const auto& [key, value] : json.items()) {
    keys.push_back("\"" + key + "\"");
  }
  for (std::size_t i = 1; i < keys.size(); ++i) {
    EXPECT_LT(text.find(keys[i - 1]), text.find(keys[i])) << "keys are sorted";
  }
  EXPECT_EQ(text.substr(0, 4), "{\n  ");
  EXPECT_EQ(text.substr(text.size() - 2), "}\n");
}

TEST(Metrics, HaveTheCoursesNamesOfTheReferenceWhereItIsMujoco) {
  RunConfiguration configuration = bareConfiguration();
  for (const char* reference : {"mujoco", "chipmunk"}) {
    configuration.reference = {reference, reference};
    const nlohmann::json json = metrics(configuration, summarize(bare(), episodesWith(20, 12, 1)));
    int of_the_course = 0;
    for (const auto& [key, value] : json.items()) {
      if (key.rfind("mj_", 0) == 0) {
        ++of_the_course;
        EXPECT_EQ(value, json.at("reference_" + key.substr(3))) << key;
      }
    }
    EXPECT_EQ(of_the_course, reference == std::string("mujoco") ? 3 : 0);
    EXPECT_EQ(json.at("reference_successes"), 12);
  }
}

/// Student's t alone would say that the feedback removes up to 3.4 rad, of pi.
TEST(Summarize, IntervalsOfSignedQuantitiesStayInTheirRange) {
  constexpr int kEpisodes = 30;
  std::vector<double> samples(kEpisodes, pusht::kPi);
  samples.front() = -pusht::kPi;
  const Quantity& quantity = kQuantities[quantityIndex("absorbed_angle_divergence")];
  EXPECT_GT(meanDifference(samples).interval.value().high, pusht::kPi);
  const Interval interval = meanOf(samples, quantity).interval.value();
  EXPECT_EQ(interval.high, pusht::kPi);
  EXPECT_EQ(interval.low, meanDifference(samples).interval.value().low);
  for (double& sample : samples) {
    sample = -sample;
  }
  EXPECT_EQ(meanOf(samples, quantity).interval.value().low, -pusht::kPi);
}

TEST(EpisodesCsv, HasARowPerEpisodeAndMode) {
  std::istringstream csv(episodesCsv(bare(), episodesWith(2, 1, 0)));
  std::vector<std::string> lines;
  for (std::string line; std::getline(csv, line);) {
    lines.push_back(line);
  }
  ASSERT_EQ(lines.size(), 1U + 2U * kModeCount);
  // Further quantities come behind these.
  EXPECT_THAT(lines[0], StartsWith("episode,seed,mode,steps,success,final_position_error_m,final_angle_error_rad,"
                                   "mean_position_divergence_m,mean_angle_divergence_rad"));
  EXPECT_THAT(lines[1], StartsWith("0,10000,reference_closed,0,true,0.0,0.0,,"));
  EXPECT_THAT(lines[5], StartsWith("1,10001,engine_closed,0,false,0.0,0.0,0.5,0.5"));
  EXPECT_THAT(lines[6], StartsWith("1,10001,engine_replay,0,true,0.0,0.0,0.01,0.05"));
}

TEST(Files, F24AreTheSameWhereTheUserWritesAComma) {
  std::vector<EpisodeResult> episodes = episodesWith(50, 31, 10);
  episodes[0].seed = 1'234'567;
  const RunConfiguration configuration = bareConfiguration();
  const auto texts = [&] {
    const Summary summary = summarize(bare(), episodes);
    return std::vector<std::string>{jsonText(metrics(configuration, summary)), episodesCsv(bare(), episodes),
                                    jsonText(statistics(configuration, episodes)), table(configuration, summary)};
  };
  const std::vector<std::string> with_point = texts();
  const pusht::testing::DecimalComma locale;
  EXPECT_EQ(texts(), with_point);
  EXPECT_EQ(episodesCsv(bare(), episodesFromCsv(bare(), with_point[1])), with_point[1]);
}

/// As STATISTICS of paired outcomes want it: reference 31, engine 10, both 10.
TEST(Summarize, PairsTheOutcomes) {
  const Outcomes outcomes = summarize(bare(), episodesWith(50, 31, 10)).outcomes;
  EXPECT_EQ(outcomes.table.both, 10);
  EXPECT_EQ(outcomes.table.first_only, 21);
  EXPECT_EQ(outcomes.table.second_only, 0);
  EXPECT_EQ(outcomes.table.neither, 19);
  EXPECT_NEAR(outcomes.table.difference(), -21.0 / 50.0, 1e-15);
  EXPECT_NEAR(outcomes.p_exact, std::pow(0.5, 20), 1e-18) << "21 of 21 discordant pairs on one side";
  ASSERT_TRUE(outcomes.difference_interval && outcomes.transfer_interval);
  EXPECT_LT(outcomes.difference_interval->high, 0.0);
  EXPECT_LT(outcomes.transfer_interval->high, 1.0);
}

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
  EXPECT_EQ(worse.yardsticks[kEngineReplay][0].beatsNull(), false);
  EXPECT_EQ(worse.yardsticks[kEngineReplay][1].beatsNull(), true);
  EXPECT_NEAR(worse.yardsticks[kEngineReplay][0].minus_null.value, 0.01005, 1e-12);
  EXPECT_NEAR(worse.yardsticks[kEngineReplay][1].share_of_null, 0.5005, 1e-9);
  EXPECT_THAT(table(configuration, worse), HasSubstr("(!) not shown to be less than that of a tee that never moves"));
  EXPECT_THAT(divergences(worse, ", "), HasSubstr("] (!), 0.5005 rad"));
  EXPECT_EQ(metrics(configuration, worse).at("mean_pos_divergence_beats_null"), false);
  EXPECT_EQ(metrics(configuration, worse).at("mean_ang_divergence_beats_null"), true);

  const Summary better = summarize(bare(), episodesAgainstNull(-0.01));
  EXPECT_EQ(better.yardsticks[kEngineReplay][0].beatsNull(), true);
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

TEST(Decision, HasTheShareAsItWasGiven) {
  EXPECT_THAT(decisionText(TransferBet(0.4999), 0.4999), HasSubstr("does the engine keep 49.99 % of"));
  EXPECT_THAT(decisionText(TransferBet(0.5), 0.5), HasSubstr("does the engine keep 50 % of"));
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
