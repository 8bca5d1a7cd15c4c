// SPDX-License-Identifier: BSD-3-Clause
#include "goal.hpp"

#include <gmock/gmock.h>

namespace pusht_rviz {
namespace {

constexpr std::uint64_t kGreatest = 18'446'744'073'709'551'615U;

TEST(NextFolder, HasTheNextNumber) {
  EXPECT_EQ(nextFolder(""), "");
  EXPECT_EQ(nextFolder("my_results"), "my_results-2");
  EXPECT_EQ(nextFolder("my_results-2"), "my_results-3");
  EXPECT_EQ(nextFolder("results/compare-9"), "results/compare-10");
  EXPECT_EQ(nextFolder("results/compare-9/"), "results/compare-10");
  EXPECT_EQ(nextFolder("run7"), "run7-2");
  EXPECT_EQ(nextFolder("2026-04"), "2026-04-2") << "04 is no number of a run";
}

TEST(SpawnSeed, IsTenThousandAndSeedAndFirstEpisode) {
  EXPECT_EQ(spawnSeedOf("0", "7"), 10'007U);
  EXPECT_EQ(spawnSeedOf("100", "7"), 10'107U);
  EXPECT_EQ(spawnSeedOf(std::to_string(kGreatest - 10'007), "7"), kGreatest);
  EXPECT_EQ(spawnSeedOf(std::to_string(kGreatest - 10'006), "7"), std::nullopt);
  EXPECT_EQ(spawnSeedOf("0", std::to_string(kGreatest)), std::nullopt);
  EXPECT_EQ(spawnSeedOf("x", "7"), std::nullopt);
  EXPECT_EQ(spawnSeedOf("0", ""), std::nullopt);
}

TEST(SpawnSeed, HasAnEpisode) {
  EXPECT_EQ(firstEpisodeOf("10007", "0").value, 7U);
  EXPECT_EQ(firstEpisodeOf("10007", "0").refusal, "");
  EXPECT_EQ(firstEpisodeOf("10107", "100").value, 7U);
  EXPECT_EQ(firstEpisodeOf("42", "0").refusal, "spawn seed '42': must be a whole number from 10000 + seed on, 10000");
  EXPECT_EQ(firstEpisodeOf("10007", "100").refusal,
            "spawn seed '10007': must be a whole number from 10000 + seed on, 10100");
  EXPECT_NE(firstEpisodeOf("x", "0").refusal, "");
  EXPECT_NE(firstEpisodeOf("", "0").refusal, "");
  EXPECT_EQ(firstEpisodeOf("10007", std::to_string(kGreatest)).refusal,
            "seed '18446744073709551615': 10000 + seed must be below 2^64");
}

}  // namespace
}  // namespace pusht_rviz
