// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_rviz/goal.hpp"

#include <gmock/gmock.h>

#include <limits>

namespace pusht_rviz {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

pusht_msgs::ParameterDescriptor descriptor(const std::string& name, const std::string& type,
                                           const std::string& default_value, double least = -kUnbounded,
                                           double greatest = kUnbounded) {
  pusht_msgs::ParameterDescriptor made;
  made.name = name;
  made.type = type;
  made.default_value = default_value;
  made.least = least;
  made.greatest = greatest;
  return made;
}

pusht_msgs::ParameterDescriptor blockDamp() {
  pusht_msgs::ParameterDescriptor made = descriptor("block_damp", "real", "6.0", 0.0, 100.0);
  made.unit = "1/s";
  return made;
}

pusht_msgs::Parameter parameter(const std::string& name, const std::string& value) {
  pusht_msgs::Parameter made;
  made.name = name;
  made.value = value;
  return made;
}

pusht_msgs::Preset preset(const std::string& word, const std::string& servo, const std::string& walls) {
  pusht_msgs::Preset made;
  made.word = word;
  made.settings = {parameter("servo", servo), parameter("walls", walls)};
  return made;
}

pusht_msgs::ParameterDescriptor presets() {
  pusht_msgs::ParameterDescriptor made = descriptor("preset", "text", "faithful");
  made.words = {"faithful", "shaped", "simple"};
  made.presets = {preset("faithful", "true", "true"), preset("shaped", "true", "false"),
                  preset("simple", "false", "false")};
  return made;
}

/// Of an engine with two switches, which a word sets; it is simple now.
pusht_msgs::DescribeResponse rigidBody() {
  pusht_msgs::DescribeResponse made;
  made.parameter_descriptors = {presets(), descriptor("servo", "boolean", "true"),
                                descriptor("walls", "boolean", "true")};
  made.parameters = {parameter("preset", "simple"), parameter("servo", "false"), parameter("walls", "false")};
  return made;
}

/// Of an engine with two parameters, whose block_damp is 20 now.
pusht_msgs::DescribeResponse twoMass() {
  pusht_msgs::DescribeResponse made;
  made.parameter_descriptors = {descriptor("pusher_mass", "real", "4.0", 0.1, 100.0), blockDamp()};
  made.parameters = {parameter("pusher_mass", "4.0"), parameter("block_damp", "20.0")};
  return made;
}

RunDraft fiftyEpisodes() {
  RunDraft run;
  run.episodes = "50";
  run.run_seed = "0";
  run.first_episode = "0";
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
  expected.episodes = {50};
  expected.seed = {0};
  expected.out = {""};
  expected.first_episode = {0};
  EXPECT_EQ(draft.goal, expected) << "the evaluator's own values count for the rest";
}

TEST(Goal, NamesPolicyAndRateIfTheyWereChosen) {
  RunDraft run = fiftyEpisodes();
  run.policy = "/my_policy";
  run.rate = 0.0;
  const Draft draft = goalFrom(run);
  EXPECT_THAT(draft.goal.policy_namespace, ElementsAre("/my_policy"));
  EXPECT_THAT(draft.goal.rate, ElementsAre(0.0)) << "as fast as possible";
}

TEST(Goal, NamesAKindAndWhatDiffersFromItsDefaults) {
  RunDraft run = fiftyEpisodes();
  run.engine = draftOf("two_mass", twoMass(), {});
  Draft draft = goalFrom(run);
  EXPECT_THAT(draft.goal.engine, ElementsAre("two_mass"));
  EXPECT_THAT(draft.goal.engine_parameters, IsEmpty()) << "what the node is now does not count: its kind is named";
  run.engine = draftOf("two_mass", twoMass(), {parameter("block_damp", "20"), parameter("no_such", "1")});
  draft = goalFrom(run);
  EXPECT_THAT(draft.goal.engine_parameters, ElementsAre(parameter("block_damp", "20")));
  run.engine.settings[1].text = "6";
  EXPECT_THAT(goalFrom(run).goal.engine_parameters, IsEmpty()) << "6 is 6.0";
}

std::vector<std::string> textsOf(const SimulatorDraft& draft) {
  std::vector<std::string> texts;
  for (const Setting& setting : draft.settings) {
    texts.push_back(setting.text);
  }
  return texts;
}

TEST(Presets, SetWhatDoesNotDifferYet) {
  SimulatorDraft draft = draftOf("rigid_body", rigidBody(), {});
  EXPECT_THAT(textsOf(draft), ElementsAre("faithful", "true", "true"));
  draft.type(0, "simple");
  EXPECT_THAT(textsOf(draft), ElementsAre("simple", "false", "false"));
  EXPECT_THAT(draft.named(), ElementsAre(parameter("preset", "simple"))) << "which sets the switches";
  draft.type(1, "true");
  EXPECT_THAT(draft.named(), ElementsAre(parameter("preset", "simple"), parameter("servo", "true")))
      << "though that is its default";
  draft.type(0, "shaped");
  EXPECT_THAT(textsOf(draft), ElementsAre("shaped", "true", "false"));
  EXPECT_THAT(draft.named(), ElementsAre(parameter("preset", "shaped")));
  draft.type(2, "true");
  draft.type(0, "faithful");
  EXPECT_THAT(textsOf(draft), ElementsAre("faithful", "true", "true"));
  EXPECT_THAT(draft.named(), IsEmpty());
}

TEST(Presets, LeaveWhatIsChosenByName) {
  const std::vector<pusht_msgs::Parameter> chosen = {parameter("preset", "simple"), parameter("servo", "true")};
  SimulatorDraft draft = draftOf("rigid_body", rigidBody(), chosen);
  EXPECT_THAT(textsOf(draft), ElementsAre("simple", "true", "false"));
  EXPECT_EQ(draft.named(), chosen);
  EXPECT_THAT(draftOf("rigid_body", rigidBody(), rigidBody().parameters).named(),
              ElementsAre(parameter("preset", "simple")));
}

TEST(Goal, LeavesOpenHowManyEpisodesIfItIsAsTheEvaluatorSays) {
  RunDraft run = fiftyEpisodes();
  run.requested_episodes = 50;
  EXPECT_THAT(goalFrom(run).goal.episodes, IsEmpty());
  run.requested_episodes = 2;
  EXPECT_THAT(goalFrom(run).goal.episodes, ElementsAre(50));
}

TEST(Goal, NamesTheFolder) {
  RunDraft run = fiftyEpisodes();
  run.out = "mine";
  EXPECT_THAT(goalFrom(run).goal.out, ElementsAre("mine"));
}

TEST(Goal, AlwaysNamesParametersWhoseDefaultIsNotKnown) {
  pusht_msgs::DescribeResponse foreign;
  foreign.parameters = {parameter("gain", "3")};
  RunDraft run = fiftyEpisodes();
  run.reference = draftOf("foreign", foreign, {});
  EXPECT_THAT(goalFrom(run).goal.reference_parameters, ElementsAre(parameter("gain", "3")));
  run.reference.settings[0].text = "whatever";
  const Draft draft = goalFrom(run);
  EXPECT_THAT(draft.refusals, IsEmpty());
  EXPECT_THAT(draft.goal.reference_parameters, ElementsAre(parameter("gain", "whatever")));
}

TEST(Goal, RefusesNumbersOfEpisodes) {
  for (const char* const text : {"0", "1000001", "-1", "1.5", "1e3", "", "many", "99999999999999999999"}) {
    RunDraft run = fiftyEpisodes();
    run.episodes = text;
    EXPECT_EQ(only(goalFrom(run).refusals), std::string("episodes | episodes ") + (*text == '\0' ? "''" : text) +
                                                ": must be a whole number from 1 to 1000000");
  }
}

TEST(Goal, RefusesSeedsOfRuns) {
  RunDraft run = fiftyEpisodes();
  run.run_seed = "-1";
  EXPECT_EQ(only(goalFrom(run).refusals),
            "run_seed | run seed -1: must be a whole number from 0 to 18446744072708541615");
  run.run_seed = "18446744073709551615";
  EXPECT_THAT(goalFrom(run).refusals, SizeIs(1));
}

TEST(Goal, RefusesFirstEpisodes) {
  RunDraft run = fiftyEpisodes();
  run.first_episode = "1000000001";
  EXPECT_EQ(only(goalFrom(run).refusals),
            "first_episode | first episode 1000000001: must be a whole number from 0 to 1000000000");
}

TEST(Goal, FindsTheEpisodeOfASpawnSeed) {
  EXPECT_EQ(episodeOfSeed("10007", 0).value, 7U);
  EXPECT_EQ(episodeOfSeed("10007", 0).refusal, "");
  EXPECT_EQ(episodeOfSeed("10107", 100).value, 7U);
  EXPECT_EQ(episodeOfSeed("42", 0).refusal, "seed 42: must be at least 10000 + the run's seed, 10000");
  EXPECT_EQ(episodeOfSeed("10007", 100).refusal, "seed 10007: must be at least 10000 + the run's seed, 10100");
  EXPECT_EQ(episodeOfSeed("x", 0).refusal, "seed x: must be a whole number, at least 10000");
  EXPECT_EQ(episodeOfSeed("", 0).refusal, "seed '': must be a whole number, at least 10000");
  EXPECT_EQ(episodeOfSeed("2000000000", 0).refusal, "seed 2000000000: must be at most 1000010000");
}

TEST(Goal, RefusesSpawnSeedsUnlessStartsAreGiven) {
  RunDraft run = fiftyEpisodes();
  run.spawn_seed = "42";
  EXPECT_EQ(only(goalFrom(run).refusals), "spawn_seed | seed 42: must be at least 10000 + the run's seed, 10000");
  run.spawned = false;
  EXPECT_THAT(goalFrom(run).refusals, IsEmpty());
}

TEST(Goal, RefusesParametersByName) {
  RunDraft run = fiftyEpisodes();
  run.engine = draftOf("two_mass", twoMass(), {parameter("block_damp", "1e9")});
  EXPECT_EQ(only(goalFrom(run).refusals), "engine.block_damp | block_damp 1e9: must be from 0 to 100 [1/s]");
  run.reference = draftOf("two_mass", twoMass(), {parameter("pusher_mass", "0")});
  EXPECT_THAT(goalFrom(run).refusals, SizeIs(2));
}

TEST(Parameters, OfEveryTypeHaveARule) {
  EXPECT_EQ(refusalOf(blockDamp(), "0"), "");
  EXPECT_EQ(refusalOf(blockDamp(), "100.0"), "");
  EXPECT_EQ(refusalOf(blockDamp(), "6,0"), "block_damp 6,0: must be a decimal number, from 0 to 100 [1/s]");
  EXPECT_EQ(refusalOf(blockDamp(), "nan"), "block_damp nan: must be a decimal number, from 0 to 100 [1/s]");
  EXPECT_EQ(refusalOf(blockDamp(), ""), "block_damp '': must be a decimal number, from 0 to 100 [1/s]");
  const auto iterations = descriptor("iterations", "integer", "30", 1, 1000);
  EXPECT_EQ(refusalOf(iterations, "1000"), "");
  EXPECT_EQ(refusalOf(iterations, "1001"), "iterations 1001: must be from 1 to 1000");
  EXPECT_EQ(refusalOf(iterations, "1.0"), "iterations 1.0: must be a whole number, from 1 to 1000");
  const auto at_least = descriptor("mass", "real", "1.0", 0.1);
  EXPECT_EQ(refusalOf(at_least, "0"), "mass 0: must be at least 0.1");
  const auto at_most = descriptor("slope", "real", "1.0", -kUnbounded, 2.5);
  EXPECT_EQ(refusalOf(at_most, "3"), "slope 3: must be at most 2.5");
  EXPECT_EQ(refusalOf(descriptor("free", "real", "1.0"), "x"), "free x: must be a decimal number");
  EXPECT_EQ(refusalOf(descriptor("on", "boolean", "true"), "yes"), "on yes: must be true or false");
  EXPECT_EQ(refusalOf(descriptor("on", "boolean", "true"), "false"), "");
  EXPECT_EQ(refusalOf(presets(), "shaped"), "");
  EXPECT_EQ(refusalOf(presets(), "ideal"), "preset ideal: must be one of: faithful, shaped, simple");
  EXPECT_EQ(refusalOf(descriptor("scene", "text", ""), "any thing"), "");
}

}  // namespace
}  // namespace pusht_rviz
