// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/episodes_csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_testing/decimal_comma.hpp"
#include "pusht_testing/refusal.hpp"
#include "run_episodes.hpp"
#include "sim2sim_protocol/results/json.hpp"
#include "sim2sim_protocol/results/metrics.hpp"
#include "sim2sim_protocol/results/statistics.hpp"
#include "sim2sim_protocol/results/table.hpp"

namespace sim2sim {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

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

TEST(EpisodesCsv, HasPushesWithStateResetReplaysAlone) {
  Protocol protocol = bare();
  std::vector<EpisodeResult> episodes = episodesWith(2, 1, 0);
  const std::string without = episodesCsv(protocol, episodes);
  EXPECT_THAT(without, Not(HasSubstr("push_")));
  protocol.reanchor = {5};
  for (EpisodeResult& episode : episodes) {
    episode.rollouts.push_back(episode.rollouts[kEngineReplay]);
    episode.rollouts.back().at("push_size") = -0.25;
  }
  const std::string with = episodesCsv(protocol, episodes);
  EXPECT_THAT(with, HasSubstr(",push_direction_error_rad,pushes_missed_share,pushes_turned_share,push_size_log,"
                              "parting_step,"));
  const std::vector<EpisodeResult> read = episodesFromCsv(protocol, with);
  EXPECT_EQ(read.back().rollouts.back().at("push_size"), -0.25);
  EXPECT_EQ(episodesCsv(protocol, read), with);
  EXPECT_THROW(episodesFromCsv(protocol, without), pusht::InvalidInput) << "columns of before";
}

TEST(EpisodesCsv, NamesTheLineThatIsNotAsItWasWritten) {
  const std::string csv = episodesCsv(bare(), episodesWith(2, 1, 0));
  std::size_t begin = 0;
  for (const std::string line : {"line 2", "line 3", "line 4", "line 5", "line 6", "line 7"}) {
    begin = csv.find('\n', begin) + 1;
    std::string damaged = csv;
    damaged.insert(csv.find(",0,", begin) + 1, "0");  // the number of steps is 00
    EXPECT_EQ(pusht::testing::refusalOf([&] { episodesFromCsv(bare(), damaged); }),
              line + ": must be a line of episodes.csv as it was written");
  }
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

}  // namespace
}  // namespace sim2sim
