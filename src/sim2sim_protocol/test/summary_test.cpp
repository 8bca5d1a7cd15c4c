// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/summary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "run_episodes.hpp"
#include "sim2sim_protocol/results/metrics.hpp"
#include "sim2sim_protocol/results/table.hpp"
#include "sim2sim_statistics/tails.hpp"

namespace sim2sim {
namespace {

using ::testing::HasSubstr;

TEST(Summarize, CountsTheClosedLoopsAndAveragesTheReplay) {
  const Summary summary = summarize(bare(), episodesWith(50, 31, 10));
  EXPECT_EQ(summary.reference.successes, 31);
  EXPECT_EQ(summary.engine.successes, 10);
  EXPECT_NEAR(summary.outcomes.transfer.value(), 10.0 / 31.0, 1e-15);
  EXPECT_NEAR(summary.mean(kEngineReplay, "mean_position_divergence").value, 0.01 * 24.5, 1e-15);
  EXPECT_NEAR(summary.mean(kEngineReplay, "mean_angle_divergence").value, 0.05 * 24.5, 1e-14);
}

TEST(Summarize, TransferCountsWhatOnlyTheEngineSolves) {
  const Outcomes outcomes = summarize(bare(), episodesWith(50, 10, 31)).outcomes;
  EXPECT_EQ(outcomes.table.second_only, 21);
  EXPECT_NEAR(outcomes.transfer.value(), 31.0 / 10.0, 1e-15);
}

TEST(Summarize, TransferIsUndefinedWithoutReferenceSuccess) {
  const Summary summary = summarize(bare(), episodesWith(5, 0, 1));
  EXPECT_FALSE(summary.outcomes.transfer);
  const RunConfiguration configuration = bareConfiguration();
  EXPECT_TRUE(metrics(configuration, summary).at("transfer").is_null());
  EXPECT_THAT(table(configuration, summary), HasSubstr("undefined"));
}

/// Student's t alone would say that the feedback removes up to 3.4 rad, of pi.
TEST(Summarize, IntervalsOfSignedQuantitiesStayInTheirRange) {
  constexpr int kEpisodes = 30;
  std::vector<double> samples(kEpisodes, pusht::kPi);
  samples.front() = -pusht::kPi;
  const Quantity& quantity = kQuantities[quantityIndex("absorbed_angle_divergence")];
  EXPECT_GT(meanDifference(samples).interval.value().high, pusht::kPi);
  const Interval interval = meanOf(samples, quantity, std::nullopt).interval.value();
  EXPECT_EQ(interval.high, pusht::kPi);
  EXPECT_EQ(interval.low, meanDifference(samples).interval.value().low);
  for (double& sample : samples) {
    sample = -sample;
  }
  EXPECT_EQ(meanOf(samples, quantity, std::nullopt).interval.value().low, -pusht::kPi);
}

/// Replays of which two part by 0.08 m and 0.02 m, floors of which one does; null model 0.1 m, 0.12 m.
std::vector<EpisodeResult> episodesOfWhichFewPart(int total) {
  std::vector<EpisodeResult> episodes = episodesWith(total, 12, 10);
  for (EpisodeResult& episode : episodes) {
    episode.rollouts[kEngineReplay].at("mean_position_divergence") = 1e-6 * (1 + episode.index);
    episode.rollouts[kEngineReplay].at("null_position_divergence") = 0.1 + 0.02 * (episode.index % 2);
    const RolloutResult replay = episode.rollouts[kEngineReplay];
    episode.rollouts.push_back(replay);  // the narrower floor
    episode.rollouts.push_back(replay);
  }
  episodes[3].rollouts[kEngineReplay].at("mean_position_divergence") = 0.08;
  episodes[7].rollouts[kEngineReplay].at("mean_position_divergence") = 0.02;
  episodes[3].rollouts.back().at("mean_position_divergence") = 0.04;
  return episodes;
}

TEST(Summarize, IntervalsHoldWhereFewEpisodesCarryTheMean) {
  const std::vector<EpisodeResult> episodes = episodesOfWhichFewPart(40);
  const std::size_t divergence = quantityIndex("mean_position_divergence");
  const std::size_t floor = episodes.front().rollouts.size() - 1;
  const std::vector<double> samples = samplesOf(episodes, {kEngineReplay, divergence});
  const double extreme = extremeOf(episodes, {kEngineReplay, divergence}).value();
  EXPECT_NEAR(extreme, 0.11, 1e-12) << "the mean of the null model";
  const Summary summary = summarize(Protocol(), episodes);
  const auto expect_same = [](const std::optional<Interval>& found, const std::optional<Interval>& expected) {
    EXPECT_EQ(found.value().low, expected.value().low);
    EXPECT_EQ(found.value().high, expected.value().high);
  };
  expect_same(summary.means[kEngineReplay][divergence].interval, tailMeanInterval(samples, extreme));
  EXPECT_GT(summary.means[kEngineReplay][divergence].interval->high, 0.01);
  const BaselineComparison& baseline = summary.baselines[kEngineReplay].front();
  expect_same(baseline.over_floor_interval,
              tailRatioInterval(samples, samplesOf(episodes, {floor, divergence}), extreme));
  EXPECT_LT(baseline.over_floor_interval->low, baseline.over_floor);
  EXPECT_GT(baseline.over_floor_interval->high, baseline.over_floor);
  EXPECT_FALSE(summary.baselines[floor].front().over_floor_interval) << "the floor over itself";
  EXPECT_NEAR(baseline.share_of_largest, 0.1 / (0.1 + 1e-6 * (820.0 - 12.0)), 1e-12);
  EXPECT_TRUE(baseline.isMostlyOfLargest());
  EXPECT_FALSE(summary.baselines[kEngineReplay].back().isMostlyOfLargest());
}

/// A null model at the anchors is not measured.
TEST(Summarize, GivesAnErrorAtTheAnchorsNoInterval) {
  Protocol protocol = bare();
  protocol.reanchor = {20};
  std::vector<EpisodeResult> episodes = episodesWith(40, 12, 10);
  for (EpisodeResult& episode : episodes) {
    episode.rollouts.push_back(episode.rollouts[kEngineReplay]);
    for (const char* error : {"anchor_position_error", "anchor_angle_error"}) {
      episode.rollouts.back().at(error) = 0.01 * (1 + episode.index % 3);
    }
  }
  const Summary summary = summarize(protocol, episodes);
  for (const char* error : {"anchor_position_error", "anchor_angle_error"}) {
    EXPECT_NEAR(summary.mean(kModeCount, error).value, 0.01 * 79 / 40, 1e-12) << error;
    EXPECT_FALSE(summary.mean(kModeCount, error).interval) << error;
    EXPECT_FALSE(extremeOf(episodes, {kModeCount, quantityIndex(error)})) << error;
  }
  EXPECT_TRUE(summary.mean(kModeCount, "mean_position_divergence").interval);
}

TEST(Summarize, GivesADivergenceNoIntervalBelowTwentyEpisodes) {
  const std::size_t divergence = quantityIndex("mean_position_divergence");
  for (const int total : {19, 20}) {
    const Summary summary = summarize(Protocol(), episodesOfWhichFewPart(total));
    EXPECT_EQ(summary.means[kEngineReplay][divergence].interval.has_value(), total == 20);
    EXPECT_EQ(summary.baselines[kEngineReplay].front().over_floor_interval.has_value(), total == 20);
  }
}

/// Intervals and tests of a run of fixed length do not hold where the episodes decide how many there are.
TEST(Summarize, LeavesOutWhatDoesNotHoldInARunThatMayStop) {
  RunConfiguration configuration;
  configuration.protocol.until_decided = 0.5;
  const std::vector<EpisodeResult> episodes = episodesOfWhichFewPart(40);
  const Summary summary = summarize(configuration.protocol, episodes);
  const nlohmann::json json = metrics(configuration, summary);
  int left_out = 0;
  for (const auto& [key, value] : json.items()) {
    const bool is_interval = key.find("_interval") != std::string::npos;
    const bool is_test = key == "success_difference_p" || key == "success_difference_exact_p" ||
                         key.find("_beats_null") != std::string::npos;
    EXPECT_TRUE(!(is_interval || is_test) || value.is_null()) << key;
    left_out += is_interval || is_test ? 1 : 0;
  }
  EXPECT_GT(left_out, 20);
  EXPECT_EQ(json.at("mean_pos_divergence_m"), metrics({}, summarize({}, episodes)).at("mean_pos_divergence_m"));
  const std::string text = table(configuration, summary);
  EXPECT_THAT(text, HasSubstr("12  0.300 "));
  EXPECT_EQ(text.find("McNemar"), std::string::npos);
  const std::string transfer = transferText(configuration, summary.outcomes);
  EXPECT_THAT(transfer, HasSubstr("["));
  EXPECT_THAT(text, HasSubstr(transfer));
  // Brackets: the headline's and the transfer's, which are the sequence.
  EXPECT_EQ(std::count(text.begin(), text.end(), '['), 2) << text;
}

/// Paired outcomes: reference 31, engine 10, both 10.
TEST(Summarize, PairsTheOutcomes) {
  const Outcomes outcomes = summarize(bare(), episodesWith(50, 31, 10)).outcomes;
  EXPECT_EQ(outcomes.table.both, 10);
  EXPECT_EQ(outcomes.table.first_only, 21);
  EXPECT_EQ(outcomes.table.second_only, 0);
  EXPECT_EQ(outcomes.table.neither, 19);
  EXPECT_NEAR(outcomes.table.difference(), -21.0 / 50.0, 1e-15);
  EXPECT_NEAR(outcomes.p_exact.value(), std::pow(0.5, 20), 1e-18) << "21 of 21 discordant pairs on one side";
  ASSERT_TRUE(outcomes.difference_interval && outcomes.transfer_interval);
  EXPECT_LT(outcomes.difference_interval->high, 0.0);
  EXPECT_LT(outcomes.transfer_interval->high, 1.0);
}

}  // namespace
}  // namespace sim2sim
