// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/metrics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "run_episodes.hpp"
#include "sim2sim_protocol/results/json.hpp"
#include "sim2sim_protocol/results/table.hpp"

namespace sim2sim {
namespace {

using ::testing::HasSubstr;

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
  EXPECT_THAT(doubt(0, checkpoint), HasSubstr("audit --policy FILE --demonstrations BAG"));
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

/// Closed loops diverge by their own actions, too; the replays of the variants do not.
TEST(Metrics, CompareTheReplayAloneWithReplaysOfModelVariants) {
  RunConfiguration configuration = bareConfiguration();
  configuration.protocol.model_variants = {"timestep=0.005"};
  std::vector<EpisodeResult> episodes = episodesWith(20, 12, 1);
  for (EpisodeResult& episode : episodes) {
    episode.rollouts.push_back(episode.rollouts[kEngineReplay]);
  }
  const nlohmann::json json = metrics(configuration, summarize(configuration.protocol, episodes));
  EXPECT_EQ(json.at("mean_pos_divergence_over_variants"), 1.0);
  EXPECT_EQ(json.at("mean_pos_divergence_over_variants_interval").size(), 2U);
  int multiples = 0;
  for (const auto& [key, value] : json.items()) {
    multiples += key.find("_over_variants") != std::string::npos ? 1 : 0;
    EXPECT_FALSE(key.rfind("engine_closed_", 0) == 0 && key.find("_over_variants") != std::string::npos) << key;
  }
  EXPECT_EQ(multiples, 12) << "six divergences with their intervals";
}

TEST(Decision, HasTheShareAsItWasGiven) {
  EXPECT_THAT(decisionText(TransferBet(0.4999), 0.4999), HasSubstr("does the engine keep 49.99 % of"));
  EXPECT_THAT(decisionText(TransferBet(0.5), 0.5), HasSubstr("does the engine keep 50 % of"));
}

}  // namespace
}  // namespace sim2sim
