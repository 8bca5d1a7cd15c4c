// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/first_divergences.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "pusht_task/spawn.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/results/bands.hpp"
#include "sim2sim_protocol/results/episodes_csv.hpp"

namespace sim2sim {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// An episode of `steps` control steps whose replay parts after `parting` of them, or never if that is 0.
EpisodeResult episodeOf(int steps, int first_divergence, Cause cause = Cause::kFree,
                        FirstBody first = FirstBody::kPusher) {
  EpisodeResult episode;
  for (RolloutResult& rollout : episode.rollouts) {
    rollout.steps = steps;
  }
  if (first_divergence > 0) {
    episode.rollouts[kEngineReplay].first_divergence = FirstDivergence{first_divergence, cause, first};
  }
  return episode;
}

/// By hand: of 5, one parts after step 1 (4/5 stay), one ends after step 1 within the bound, one of the 3 that are left
/// parts after step 2 (2/3 of 4/5), the others after step 3 and never.
TEST(FirstDivergences, ShareWithinTheBoundIsKaplanAndMeiers) {
  const FirstDivergences first_divergences = firstDivergencesOf(
      {episodeOf(4, 1, Cause::kContactBegins), episodeOf(1, 0), episodeOf(4, 2, Cause::kWall, FirstBody::kTee),
       episodeOf(4, 3, Cause::kContactBegins), episodeOf(4, 0)},
      kEngineReplay);
  EXPECT_EQ(first_divergences.episodes, 5);
  EXPECT_EQ(first_divergences.parted, 3);
  EXPECT_THAT(first_divergences.within, ElementsAre(1.0, DoubleNear(0.8, 1e-12), DoubleNear(8.0 / 15.0, 1e-12),
                                                    DoubleNear(4.0 / 15.0, 1e-12), DoubleNear(4.0 / 15.0, 1e-12)));
  EXPECT_EQ(first_divergences.median_step, 3);
  EXPECT_EQ(std::string(mostFrequentCause(first_divergences).name), "contact_begins");

  const nlohmann::json json = toJson(first_divergences, true);
  EXPECT_EQ(json.at("causes").at("contact_begins").at("episodes"), 2);
  EXPECT_EQ(json.at("causes").at("contact_begins").at("share"), 0.666667);
  EXPECT_EQ(json.at("causes").at("free").at("episodes"), 0);
  EXPECT_EQ(json.at("first").at("tee").at("episodes"), 1);
  EXPECT_EQ(json.at("parted").at("share"), 0.6);
  EXPECT_EQ(json.at("parted").at("interval").size(), 2U);
  EXPECT_TRUE(toJson(first_divergences, false).at("parted").at("interval").is_null());
}

TEST(FirstDivergences, WithoutOneThereIsNoMedianAndNoShareOfCauses) {
  const FirstDivergences first_divergences = firstDivergencesOf({episodeOf(2, 0), episodeOf(3, 0)}, kEngineReplay);
  EXPECT_EQ(first_divergences.parted, 0);
  EXPECT_THAT(first_divergences.within, ElementsAre(1.0, 1.0, 1.0, 1.0));
  EXPECT_FALSE(first_divergences.median_step);
  EXPECT_TRUE(toJson(first_divergences, true).at("median_step").is_null());
  EXPECT_FALSE(toJson(first_divergences, true).at("causes").at("wall").contains("share"));
}

TEST(FirstDivergences, OfAClosedLoopThatEndsBeforeTheReferenceSayNothingOfLaterSteps) {
  EpisodeResult episode = episodeOf(10, 0);
  episode.rollouts[kEngineClosed].steps = 4;
  EXPECT_EQ(firstDivergencesOf({episode}, kEngineClosed).within.size(), 5U);
}

TEST(FirstDivergences, AreKeptInTheRows) {
  Protocol protocol;
  protocol.floor = false;
  std::vector<EpisodeResult> episodes = {episodeOf(4, 2, Cause::kSlidingOnStem, FirstBody::kBoth), episodeOf(4, 0)};
  episodes[1].index = 1;
  const std::string csv = episodesCsv(protocol, episodes);
  EXPECT_THAT(csv, HasSubstr(",2,sliding_on_stem,both,,,\n"));
  EXPECT_EQ(episodesCsv(protocol, episodesFromCsv(protocol, csv)), csv);
  episodes[1].rollouts[kEngineClosed].ending = RolloutEnding{Ending::kStuck, 41, PusherEnding::kLost};
  const std::string stuck = episodesCsv(protocol, episodes);
  EXPECT_THAT(stuck, HasSubstr(",stuck,41,lost\n1,,engine_replay"));
  EXPECT_EQ(episodesCsv(protocol, episodesFromCsv(protocol, stuck)), stuck);
  std::string misspelt = stuck;
  misspelt.replace(misspelt.find("stuck,41"), 5, "stick");
  EXPECT_THROW(episodesFromCsv(protocol, misspelt), pusht::InvalidInput);
  std::string damaged = csv;
  damaged.replace(damaged.find("sliding_on_stem"), 7, "gliding");
  EXPECT_THROW(episodesFromCsv(protocol, damaged), pusht::InvalidInput);
}

/// An episode whose replay is `divergence` [m] away from the reference at each control step.
Episode apart(const Protocol& protocol, int index, const std::vector<double>& divergence) {
  const pusht::WorldState start = pusht::spawn(7);
  pusht::Rollout reference(start);
  pusht::Rollout replay(start);
  for (const double distance : divergence) {
    pusht::WorldState state = start;
    reference.record({}, state);
    state.tee_position.x() += distance;
    replay.record({}, state);
  }
  pusht::Rollout closed(start);
  return Episode(protocol, index, {std::move(reference), std::move(closed), std::move(replay)});
}

std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    lines.push_back(line);
  }
  return lines;
}

TEST(Bands, AreQuantilesOfTheEpisodesThatGoOn) {
  Protocol protocol;
  protocol.floor = false;
  DivergenceBands bands(protocol);
  for (int i = 1; i <= 100; ++i) {
    bands.add(apart(protocol, i, i <= 60 ? std::vector<double>{0.001 * i, 0.5} : std::vector<double>{0.001 * i}));
  }
  const std::vector<std::string> lines = linesOf(bands.csv());
  ASSERT_EQ(lines.size(), 1U + 1U + 3U) << "the closed loop has its start alone";
  EXPECT_EQ(lines[2].substr(0, lines[2].find(",0,0,0")), "engine_replay,0,100");
  std::istringstream step(lines[3]);
  std::vector<std::string> cells;
  for (std::string cell; std::getline(step, cell, ',');) {
    cells.push_back(cell);
  }
  EXPECT_EQ(cells[2], "100");
  const std::vector<double> wanted = {0.005, 0.025, 0.05, 0.075, 0.095};
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    EXPECT_NEAR(std::stod(cells[3 + i]) / wanted[i], 1.0, 0.015) << i;
  }
  EXPECT_THAT(lines[4], HasSubstr("engine_replay,2,60,"));
}

TEST(Bands, DoNotDependOnTheOrderOfEpisodes) {
  Protocol protocol;
  protocol.floor = false;
  DivergenceBands forward(protocol);
  DivergenceBands backward(protocol);
  for (int i = 0; i < 20; ++i) {
    forward.add(apart(protocol, i, {0.01 * i, 1e-14, 200.0}));
    backward.add(apart(protocol, i, {0.01 * (19 - i), 1e-14, 200.0}));
  }
  EXPECT_EQ(forward.csv(), backward.csv());
  EXPECT_THAT(forward.csv(), HasSubstr("engine_replay,2,20,0,0,0,0,0,")) << "below 1e-12 m is 0";
}

}  // namespace
}  // namespace sim2sim
