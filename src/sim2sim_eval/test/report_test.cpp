// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/results/report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "sim2sim_eval/batch/comparison.hpp"

namespace sim2sim {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

/// `total` episodes, the first `reference` and `engine` of which succeed.
std::vector<EpisodeResult> episodesWith(int total, int reference, int engine) {
  std::vector<EpisodeResult> episodes;
  for (int i = 0; i < total; ++i) {
    EpisodeResult episode;
    episode.index = i;
    episode.seed = 10'000U + static_cast<std::uint64_t>(i);
    episode.modes[kReferenceClosed].success = i < reference;
    episode.modes[kEngineClosed].success = i < engine;
    episode.modes[kEngineClosed].at("mean_position_divergence") = 0.5;
    episode.modes[kEngineClosed].at("mean_angle_divergence") = 0.5;
    episode.modes[kEngineReplay].success = true;  // must not count
    episode.modes[kEngineReplay].at("mean_position_divergence") = 0.01 * i;
    episode.modes[kEngineReplay].at("mean_angle_divergence") = 0.1 * i;
    episodes.push_back(episode);
  }
  return episodes;
}

TEST(Summarize, CountsTheClosedLoopsAndAveragesTheReplay) {
  const Summary summary = summarize(episodesWith(50, 31, 10));
  EXPECT_EQ(summary.reference.successes, 31);
  EXPECT_EQ(summary.engine.successes, 10);
  EXPECT_NEAR(summary.transfer.value(), 10.0 / 31.0, 1e-15);
  EXPECT_NEAR(summary.mean(kEngineReplay, "mean_position_divergence").value, 0.01 * 24.5, 1e-15);
  EXPECT_NEAR(summary.mean(kEngineReplay, "mean_angle_divergence").value, 0.1 * 24.5, 1e-14);
}

TEST(Summarize, TransferIsUndefinedWithoutReferenceSuccess) {
  const Summary summary = summarize(episodesWith(5, 0, 1));
  EXPECT_FALSE(summary.transfer);
  const RunConfiguration configuration;
  EXPECT_TRUE(metrics(configuration, summary).at("transfer").is_null());
  EXPECT_THAT(table(configuration, summary), HasSubstr("undefined"));
}

TEST(DoubtAboutPolicy, IsRaisedWhereATrainedOneNeverSucceedsAtHome) {
  RunConfiguration configuration;
  configuration.policy = "stale.pt";
  const nlohmann::json checkpoint = {{"policy", {{"sha256", "8997"}}}};
  const auto doubt = [&](int reference_successes, const nlohmann::json& provenance) {
    return doubtAboutPolicy(metrics(configuration, summarize(episodesWith(5, reference_successes, 1))), provenance);
  };
  EXPECT_THAT(doubt(0, checkpoint), HasSubstr("policy stale.pt never succeeds in the reference"));
  EXPECT_EQ(doubt(1, checkpoint), "");
  configuration.policy = "somebody's node";
  for (const char* other : {R"({"policy": {"sha256": ""}})", R"({"policy": {"runs_on": "scripted"}})",
                            R"({"policy": {"sha256": 5}})", R"({"policy": {}})", "{}"}) {
    EXPECT_EQ(doubt(0, nlohmann::json::parse(other)), "") << other;
  }
}

TEST(Metrics, HasTheCoursesKeysAtTheTopSortedAndRounded) {
  RunConfiguration configuration;
  configuration.policy = "some/policy.pt";
  configuration.protocol.first_episode = 5;
  configuration.protocol.episodes = 3;
  configuration.reference = {"mujoco", "MuJoCo"};
  configuration.engine = {"two_mass", "two-mass engine"};
  const std::string text = jsonText(metrics(configuration, summarize(episodesWith(3, 2, 1))));
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
  EXPECT_EQ(json.at("mean_ang_divergence_rad"), 0.1);
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

TEST(EpisodesCsv, HasARowPerEpisodeAndMode) {
  std::istringstream csv(episodesCsv(episodesWith(2, 1, 0)));
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
  EXPECT_THAT(lines[6], StartsWith("1,10001,engine_replay,0,true,0.0,0.0,0.01,0.1"));
}

TEST(Table, ShowsNoDivergenceBelowZero) {
  Summary summary = summarize(episodesWith(2, 1, 1));
  summary.means[kEngineReplay][quantityIndex("mean_angle_divergence")] = {0.038, Interval{-0.447, 0.523}};
  const RunConfiguration configuration;
  EXPECT_THAT(table(configuration, summary), HasSubstr("0.0380 rad [0.0000, 0.5230]"));
  EXPECT_EQ(metrics(configuration, summary).at("mean_ang_divergence_interval_rad").at(0), -0.447) << "as computed";
}

TEST(Table, ShowsRatesWithIntervals) {
  RunConfiguration configuration;
  configuration.reference = {"mujoco", "MuJoCo"};
  configuration.engine = {"two_mass", "two-mass engine"};
  const Summary summary = summarize(episodesWith(50, 31, 10));
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
