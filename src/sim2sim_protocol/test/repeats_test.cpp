// SPDX-License-Identifier: BSD-3-Clause
// Runs whose starts are repeated: results by start.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/loop.hpp"
#include "results/starts.hpp"
#include "run_episodes.hpp"
#include "sim2sim_protocol/results/contrast.hpp"
#include "sim2sim_protocol/results/episodes_csv.hpp"
#include "sim2sim_protocol/results/metrics.hpp"
#include "sim2sim_protocol/results/statistics.hpp"
#include "sim2sim_protocol/results/summary.hpp"
#include "sim2sim_protocol/results/table.hpp"

namespace sim2sim {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kRepeats = 4;

RunConfiguration repeatedConfiguration(int episodes) {
  RunConfiguration configuration = bareConfiguration();
  configuration.protocol.episodes = episodes;
  configuration.protocol.repeats = kRepeats;
  return configuration;
}

/// Each episode of a run, kRepeats times.
std::vector<EpisodeResult> repeated(const std::vector<EpisodeResult>& once) {
  std::vector<EpisodeResult> episodes;
  for (const EpisodeResult& episode : once) {
    for (int i = 0; i < kRepeats; ++i) {
      episodes.push_back(episode);
      episodes.back().index = kRepeats * episode.index + i;
    }
  }
  return episodes;
}

void expectSame(const std::optional<Interval>& found, const std::optional<Interval>& expected) {
  ASSERT_TRUE(found && expected);
  EXPECT_NEAR(found->low, expected->low, 1e-12);
  EXPECT_NEAR(found->high, expected->high, 1e-12);
}

/// Repeats that are all alike make nothing surer.
TEST(RepeatedStarts, AllAlikeAreOneEpisode) {
  const std::vector<EpisodeResult> once = episodesWith(30, 20, 8);
  const RunConfiguration configuration = repeatedConfiguration(120);
  const Summary summary = summarize(configuration.protocol, repeated(once));
  const Summary plain = summarize(bare(), once);
  EXPECT_EQ(summary.episodes, 120);
  EXPECT_EQ(summary.engine.successes, 32);
  EXPECT_EQ(summary.outcomes.starts, 30);
  EXPECT_DOUBLE_EQ(summary.engine.rate, plain.engine.rate);
  const std::size_t position = quantityIndex("mean_position_divergence");
  expectSame(summary.means[kEngineReplay][position].interval, plain.means[kEngineReplay][position].interval);
  expectSame(summary.baselines[kEngineReplay][0].median.interval, plain.baselines[kEngineReplay][0].median.interval);
  expectSame(summary.baselines[kEngineReplay][0].minus_null.interval,
             plain.baselines[kEngineReplay][0].minus_null.interval);
  EXPECT_EQ(summary.baselines[kEngineReplay][0].episodes, 120);
  const auto width = [](const std::optional<Interval>& interval) {
    return interval.value().high - interval.value().low;
  };
  EXPECT_GT(width(summary.engine.interval), width(plain.engine.interval)) << "Student's t";
  EXPECT_GT(width(summary.outcomes.transfer_interval), width(plain.outcomes.transfer_interval));
  EXPECT_GT(width(summary.outcomes.difference_interval), width(plain.outcomes.difference_interval));
  EXPECT_FALSE(summary.outcomes.p_exact);
  EXPECT_EQ(summary.noise.value().engine.repeats.value, 0.0);
  EXPECT_EQ(summary.noise->divergences[0].repeats.value, 0.0);
  EXPECT_GT(summary.noise->divergences[0].starts.value, 0.0);
  EXPECT_FALSE(plain.noise);
}

/// Episodes in which the engine succeeds in the first of two starts always, and in every other repeat of the others.
std::vector<EpisodeResult> noisyEpisodes(int starts) {
  std::vector<EpisodeResult> episodes = repeated(episodesWith(starts, starts, 1));
  for (EpisodeResult& episode : episodes) {
    RolloutResult& replay = episode.rollouts[kEngineReplay];
    replay.at("mean_position_divergence") = 0.1 + 0.02 * (episode.index % 2);
    if (episode.index >= kRepeats) {
      episode.rollouts[kEngineClosed].success = episode.index % 2 == 0;
    }
  }
  return episodes;
}

TEST(RepeatedStarts, SplitTheVariance) {
  const RunConfiguration configuration = repeatedConfiguration(120);
  const Summary summary = summarize(configuration.protocol, noisyEpisodes(30));
  const NoiseSplit& engine = summary.noise.value().engine;
  EXPECT_NEAR(engine.repeats.value, 29.0 / 30.0 / 3.0, 1e-12) << "2 of 4 have the variance 1 / 3, unbiased";
  EXPECT_TRUE(engine.repeats.interval && engine.starts.interval);
  EXPECT_NEAR(summary.noise->divergences[0].repeats.value, 0.0001 * 4.0 / 3.0, 1e-12);
  EXPECT_EQ(summary.noise->divergences[0].starts.value, 0.0);
  const nlohmann::json json = metrics(configuration, summary);
  EXPECT_EQ(json.at("number_of_starts"), 30);
  EXPECT_EQ(json.at("repeats"), kRepeats);
  EXPECT_EQ(protocolFrom(json).repeats, kRepeats) << "what is read again; \"starts\" would be a hash";
  EXPECT_NEAR(json.at("engine_success_variance_repeats").get<double>(), 0.3222, 1e-4);
  EXPECT_EQ(json.at("engine_success_variance_repeats_interval").size(), 2U);
  EXPECT_TRUE(json.at("mean_pos_divergence_variance_starts_interval_m2").is_null());
  const std::string text = table(configuration, summary);
  EXPECT_THAT(text, HasSubstr("variance of repeats"));
  EXPECT_THAT(text, HasSubstr("100 % of the variance"));
  EXPECT_THAT(text,
              HasSubstr("(120 episodes, 4 of each start; in brackets 95 % intervals over other initial states and "
                        "other noise, not"));
  const Summary plain = summarize(bare(), episodesWith(30, 20, 8));
  EXPECT_FALSE(metrics(bareConfiguration(), plain).contains("number_of_starts"));
  EXPECT_THAT(table(bareConfiguration(), plain), Not(HasSubstr("variance")));
}

TEST(RepeatedStarts, WithoutAFigureDoNotCount) {
  std::vector<EpisodeResult> episodes = repeated(episodesWith(3, 2, 1));
  for (std::size_t i = 0; i < episodes.size(); i += 2) {
    episodes[i].rollouts[kEngineReplay].at("mean_position_divergence") = std::nan("");
  }
  const std::vector<EpisodeResult> means = meansOfStarts(repeatedConfiguration(12).protocol, episodes);
  ASSERT_EQ(means.size(), 3U);
  EXPECT_NEAR(means[2].rollouts[kEngineReplay].at("mean_position_divergence"), 0.02, 1e-15)
      << "the mean of two, not four";
}

TEST(RepeatedStarts, TooFewStartsSayNothing) {
  const RunConfiguration configuration = repeatedConfiguration(36);
  const Summary summary = summarize(configuration.protocol, noisyEpisodes(9));
  EXPECT_FALSE(summary.engine.interval || summary.outcomes.p || summary.outcomes.transfer_interval);
  EXPECT_THAT(table(configuration, summary),
              HasSubstr("Cannot say yet: 9 starts can say nothing; it takes 10 or more."));
}

TEST(RepeatedStarts, StatisticsAreByStart) {
  const nlohmann::json json = statistics(repeatedConfiguration(120), noisyEpisodes(30));
  EXPECT_EQ(json.at("number_of_starts"), 30);
  const nlohmann::json& replay = json.at("rollouts").at("engine_replay");
  EXPECT_EQ(replay.at("mean_position_divergence_m").at("episodes"), 120);
  EXPECT_NEAR(replay.at("mean_position_divergence_m").at("standard_deviation").get<double>(), 0.0, 1e-12);
  EXPECT_TRUE(replay.at("parting").at("parted").at("interval").is_null());
  EXPECT_FALSE(statistics(bareConfiguration(), episodesWith(30, 20, 8)).contains("number_of_starts"));
}

/// A run that was interrupted lacks some repeats.
TEST(RepeatedStarts, MayBeIncomplete) {
  std::vector<EpisodeResult> episodes = noisyEpisodes(12);
  episodes.erase(episodes.begin() + 6);
  episodes.back().rollouts[kEngineReplay].at("mean_angle_divergence") = std::numeric_limits<double>::quiet_NaN();
  const Protocol protocol = repeatedConfiguration(48).protocol;
  const std::vector<StartCount> counts = successesByStart(protocol, episodes, kEngineClosed);
  ASSERT_EQ(counts.size(), 12U);
  EXPECT_EQ(counts[1].episodes, kRepeats - 1);
  const auto numbers = meansByStart(protocol, episodes, [](const auto& episode) { return 1.0 * episode.index; });
  EXPECT_EQ(numbers[1], (4.0 + 5.0 + 7.0) / 3.0);
  EXPECT_FALSE(
      std::isnan(meansOfStarts(protocol, episodes).back().rollouts[kEngineReplay].at("mean_angle_divergence")));
  EXPECT_TRUE(summarize(protocol, episodes).engine.interval);
}

TEST(RepeatedStarts, HaveAColumnOfTheirOwn) {
  const Protocol protocol = repeatedConfiguration(8).protocol;
  std::vector<EpisodeResult> episodes = noisyEpisodes(2);
  episodes[6].rollouts[kEngineClosed].ending = RolloutEnding{Ending::kStuck, 41, PusherEnding::kLost};
  EXPECT_THAT(episodesCsv(protocol, episodes), HasSubstr(",2,stuck,41,lost\n6,10001,engine_replay"));
  const std::vector<EpisodeResult> read = episodesFromCsv(protocol, episodesCsv(protocol, episodes));
  ASSERT_TRUE(read[6].rollouts[kEngineClosed].ending);
  EXPECT_EQ(read[6].rollouts[kEngineClosed].ending->still_step, 41);
  const std::string csv = episodesCsv(protocol, noisyEpisodes(2));
  EXPECT_THAT(csv, HasSubstr(",parting_first,repeat,ending,still_step,pusher_ending\n"));
  EXPECT_THAT(csv, HasSubstr("\n6,10001,engine_closed,"));
  EXPECT_THAT(csv, HasSubstr(",,,2,,,\n6,10001,engine_replay"));
  EXPECT_EQ(episodesCsv(protocol, episodesFromCsv(protocol, csv)), csv);
  std::string other = csv;
  other.replace(other.find(",,,2,,,\n"), 5, ",,,3,");
  EXPECT_THROW(episodesFromCsv(protocol, other), pusht::InvalidInput);
  EXPECT_THAT(episodesCsv(bare(), episodesWith(2, 1, 1)), Not(HasSubstr("repeat")));
}

TEST(RepeatedStarts, AreContrastedByStart) {
  const RunConfiguration configuration = repeatedConfiguration(120);
  const std::vector<EpisodeResult> before = noisyEpisodes(30);
  std::vector<EpisodeResult> now = before;
  for (std::size_t i = 0; i < 10 * kRepeats; ++i) {
    now[i].rollouts[kEngineClosed].success = false;
  }
  const auto results = [&](const std::vector<EpisodeResult>& episodes) {
    RunConfiguration named = configuration;
    named.engine = {"two_mass", "two-mass engine"};
    return RunResults{"run", metrics(named, summarize(named.protocol, episodes)), named.protocol, episodes};
  };
  const Contrast found = contrastsOf(results(before), {results(now)}).front();
  const Difference expected =
      repeatedDifference(pairsByStart(configuration.protocol, before, kEngineClosed, now, kEngineClosed));
  expectSame(found.rows.front().difference.interval, expected.interval);
  EXPECT_EQ(found.rows.front().difference.p, expected.p);
  EXPECT_EQ(found.rows.front().name, "engine_success_rate");
  for (const ContrastRow& row : found.rows) {
    EXPECT_FALSE(row.decided_after) << row.name;
  }
}

TEST(RepeatedStarts, AreNotWatchedUntilDecided) {
  Protocol protocol = repeatedConfiguration(40).protocol;
  EXPECT_NO_THROW(protocol.validate());
  protocol.until_decided = 0.5;
  try {
    protocol.validate();
    FAIL() << "not refused";
  } catch (const pusht::InvalidInput& error) {
    EXPECT_STREQ(error.what(),
                 "until_decided 0.5: must not be given with repeats 4, because its bets are on independent episodes");
  }
}

TEST(NoteOnNoise, IsForWhatIsRandomAndWasPlayedOnce) {
  const nlohmann::json stochastic = {{"policy", {{"noise", {{"distribution", "normal"}}}}}};
  RunConfiguration configuration = bareConfiguration();
  EXPECT_THAT(noteOnNoise(configuration, stochastic), HasSubstr("--repeats"));
  EXPECT_EQ(noteOnNoise(configuration, {{"policy", {{"sha256", "1"}}}}), "");
  EXPECT_EQ(noteOnNoise(repeatedConfiguration(8), stochastic), "");
  const auto loop_with = [](const char* name, const char* value) {
    pusht::ParameterSet loop = pusht::plainLoop();
    loop.set(name, value);
    return loop;
  };
  configuration.engine.add(loop_with("action_noise", "0.1"));
  EXPECT_THAT(noteOnNoise(configuration, stochastic), HasSubstr("Policy and loop draw"));
  EXPECT_THAT(noteOnNoise(configuration, nlohmann::json::object()), HasSubstr("The loop draws"));
  configuration.engine = bareConfiguration().engine;
  configuration.engine.add(loop_with("action_delay", "1"));
  EXPECT_THAT(noteOnNoise(configuration, stochastic), HasSubstr("The policy draws"));
  EXPECT_EQ(noteOnNoise(configuration, nlohmann::json::object()), "");
}

}  // namespace
}  // namespace sim2sim
