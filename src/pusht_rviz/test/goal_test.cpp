// SPDX-License-Identifier: BSD-3-Clause
#include "goal.hpp"

#include <gmock/gmock.h>

#include "parameters.hpp"

namespace pusht_rviz {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::uint64_t kGreatest = 18'446'744'073'709'551'615U;

pusht_msgs::ParameterDescriptor number(const std::string& name, const std::string& type, double least,
                                       double greatest) {
  pusht_msgs::ParameterDescriptor made;
  made.name = name;
  made.type = type;
  made.default_value = "1";
  made.least = least;
  made.greatest = greatest;
  return made;
}

/// Simulator with one parameter.
pusht_msgs::DescribeResponse twoMass() {
  pusht_msgs::DescribeResponse made;
  made.parameter_descriptors = {number("block_damp", "real", 0.0, 100.0)};
  made.parameters = {parameter("block_damp", "20.0")};
  return made;
}

RunDraft fiftyEpisodes() {
  pusht_msgs::RunOptions options;
  options.descriptors = {number("seed", "integer", 0.0, 1e300), number("first_episode", "integer", 0.0, 1e9),
                         number("episodes", "integer", 1.0, 1e6)};
  options.values = {parameter("seed", "0"), parameter("first_episode", "0"), parameter("episodes", "50")};
  RunDraft run;
  run.options = ParameterDraft(options);
  run.spawn_seed = "10000";
  return run;
}

std::string only(const std::vector<Refusal>& refusals) {
  return refusals.size() == 1 ? refusals.front().field + " | " + refusals.front().rule
                              : std::to_string(refusals.size()) + " refusals";
}

TEST(NextFolder, HasTheNextNumber) {
  EXPECT_EQ(nextFolder(""), "");
  EXPECT_EQ(nextFolder("my_results"), "my_results-2");
  EXPECT_EQ(nextFolder("my_results-2"), "my_results-3");
  EXPECT_EQ(nextFolder("results/compare-9"), "results/compare-10");
  EXPECT_EQ(nextFolder("results/compare-9/"), "results/compare-10");
  EXPECT_EQ(nextFolder("run7"), "run7-2");
  EXPECT_EQ(nextFolder("2026-04"), "2026-04-2") << "04 is no number of a run";
}

TEST(Goal, SaysWhatTheFormSaysAndNoMore) {
  const Draft draft = goalFrom(fiftyEpisodes());
  EXPECT_THAT(draft.refusals, IsEmpty());
  pusht_msgs::CompareGoal expected;
  expected.out = {""};
  EXPECT_EQ(draft.goal, expected) << "the evaluator's own values count for the rest";
}

TEST(Goal, NamesOptionsFolderPolicyAndRateThatWereChosen) {
  RunDraft run = fiftyEpisodes();
  run.options.type(2, "3");
  run.out = "mine";
  run.policy = "/my_policy";
  run.rate = 0.0;
  const Draft draft = goalFrom(run);
  EXPECT_THAT(draft.goal.options, ElementsAre(parameter("episodes", "3")));
  EXPECT_THAT(draft.goal.out, ElementsAre("mine"));
  EXPECT_THAT(draft.goal.policy_namespace, ElementsAre("/my_policy"));
  EXPECT_THAT(draft.goal.rate, ElementsAre(0.0)) << "as fast as possible";
}

TEST(Goal, NamesAKindAndItsParameters) {
  RunDraft run = fiftyEpisodes();
  run.engine = {"two_mass", ParameterDraft(twoMass(), {parameter("block_damp", "20")})};
  const Draft draft = goalFrom(run);
  EXPECT_THAT(draft.goal.engine, ElementsAre("two_mass"));
  EXPECT_THAT(draft.goal.engine_parameters, ElementsAre(parameter("block_damp", "20")));
  EXPECT_THAT(draft.goal.reference, IsEmpty());
}

TEST(Goal, RefusesOptionsByName) {
  for (const char* const text : {"0", "1000001", "-1"}) {
    RunDraft run = fiftyEpisodes();
    run.options.type(2, text);
    EXPECT_EQ(only(goalFrom(run).refusals), std::string("episodes | episodes ") + text + ": must be from 1 to 1000000");
  }
  RunDraft run = fiftyEpisodes();
  run.options.type(2, "many");
  EXPECT_EQ(only(goalFrom(run).refusals), "episodes | episodes 'many': must be a decimal integer");
}

TEST(Goal, RefusesParametersByName) {
  RunDraft run = fiftyEpisodes();
  run.engine.parameters = ParameterDraft(twoMass(), {parameter("block_damp", "1000")});
  EXPECT_EQ(only(goalFrom(run).refusals), "engine.block_damp | block_damp 1000.0: must be from 0.0 to 100.0");
  run.reference = run.engine;
  EXPECT_THAT(goalFrom(run).refusals, SizeIs(2));
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

TEST(SpawnSeed, IsRefusedUnlessStartsAreGiven) {
  RunDraft run = fiftyEpisodes();
  run.spawn_seed = "42";
  EXPECT_EQ(only(goalFrom(run).refusals),
            "spawn_seed | spawn seed '42': must be a whole number from 10000 + seed on, 10000");
  run.spawned = false;
  EXPECT_THAT(goalFrom(run).refusals, IsEmpty());
}

}  // namespace
}  // namespace pusht_rviz
