// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/headline.hpp"

#include <gtest/gtest.h>

#include <regex>
#include <string>

#include "pusht_task/numbers.hpp"
#include "sim2sim_protocol/results/text.hpp"

namespace sim2sim {
namespace {

RunConfiguration configurationOf(const std::string& engine, int episodes) {
  RunConfiguration configuration;
  configuration.protocol.episodes = episodes;
  configuration.reference = {"mujoco", "MuJoCo"};
  configuration.engine = {"engine", engine};
  return configuration;
}

/// The headline of a whole run with `engine` in place of the engine; counts: both succeed, only the reference, only
/// the engine, neither.
Headline headline(const std::string& engine, const PairTable& successes) {
  return headlineOf(configurationOf(engine, successes.pairs()), outcomesOf(successes), {});
}

void expect(const Headline& headline, const std::string& verdict, const std::string& answer) {
  EXPECT_EQ(nameOf(headline.verdict), verdict) << answer;
  EXPECT_EQ(headline.text(), "Does the skill transfer? " + answer);
}

TEST(Headline, Transfers) {
  expect(headline("rigid-body engine", {540, 59, 63, 338}), "transfers",
         "Yes: with this policy the rigid-body engine has 101 % [97, 104] of MuJoCo's success.");
}

TEST(Headline, MoreSuccessThanInTheReferenceIsNoYes) {
  expect(headline("Chipmunk", {300, 5, 120, 75}), "exceeds",
         "More, not alike: with this policy Chipmunk has 138 % [130, 147] of MuJoCo's success, which is another task, "
         "not a better skill.");
}

TEST(Headline, TransfersInPart) {
  expect(headline("Chipmunk", {1000, 240, 54, 706}), "transfers_in_part",
         "In part: with this policy Chipmunk keeps 85 % [82, 87] of MuJoCo's success.");
}

TEST(Headline, TransfersAtMostInPart) {
  expect(headline("two-mass engine", {10, 20, 4, 66}), "at_most_in_part",
         "At most in part: with this policy the two-mass engine keeps 47 % [28, 73] of MuJoCo's success.");
}

TEST(Headline, DoesNotTransfer) {
  expect(headline("two-mass engine", {1500, 4625, 400, 3475}), "does_not_transfer",
         "No: with this policy the two-mass engine keeps 31 % [30, 32] of MuJoCo's success.");
}

TEST(Headline, DoesNotTransferAtAll) {
  expect(headline("two-mass engine", {0, 30, 0, 20}), "does_not_transfer",
         "No: with this policy the two-mass engine keeps 0 % [0, 13] of MuJoCo's success.");
}

TEST(Headline, CannotSay) {
  expect(headline("two-mass engine", {4, 5, 2, 9}), "cannot_say",
         "Cannot say yet: with this policy the two-mass engine keeps 67 % [31, 138] of MuJoCo's success.");
}

TEST(Headline, CannotSayButAtLeastInPart) {
  expect(headline("Chipmunk", {24, 6, 7, 13}), "cannot_say",
         "Cannot say yet, but at least in part: with this policy Chipmunk has 103 % [80, 134] of MuJoCo's success.");
}

TEST(Headline, CannotSayOfFewEpisodes) {
  expect(headline("Chipmunk", {2, 0, 0, 0}), "cannot_say",
         "Cannot say yet: 2 episodes can say nothing; it takes 10 or more.");
  expect(headline("Chipmunk", {0, 0, 0, 1}), "cannot_say",
         "Cannot say yet: 1 episode can say nothing; it takes 10 or more.");
  expect(headlineOf(configurationOf("Chipmunk", 50), outcomesOf(PairTable{}), {}), "cannot_say",
         "Cannot say yet: no episode has finished; it takes 10 or more.");
}

TEST(Headline, NothingToTransfer) {
  expect(headline("two-mass engine", {0, 0, 1, 49}), "nothing_to_transfer",
         "Nothing to transfer: with this policy MuJoCo never succeeds in 50 episodes.");
}

TEST(Headline, SaysThatARunGoesOn) {
  const RunConfiguration configuration = configurationOf("two-mass engine", 10'000);
  expect(headlineOf(configuration, outcomesOf(PairTable{5, 25, 1, 19}), {}), "does_not_transfer",
         "So far no: with this policy the two-mass engine keeps 20 % [9, 40] of MuJoCo's success (50 of 10000 "
         "episodes).");
  expect(headlineOf(configuration, outcomesOf(PairTable{4, 5, 2, 9}), {}), "cannot_say",
         "Cannot say yet: with this policy the two-mass engine keeps 67 % [31, 138] of MuJoCo's success (20 of 10000 "
         "episodes).");
  expect(headlineOf(configuration, outcomesOf(PairTable{0, 0, 0, 20}), {}), "nothing_to_transfer",
         "So far nothing to transfer: with this policy MuJoCo never succeeds (20 of 10000 episodes).");
}

/// The interval holds whenever the run stops, so it is wider than that of a run of fixed length, and nothing is said of
/// the episodes that were not needed.
TEST(Headline, ARunThatEndsWhenItIsDecidedHasTheIntervalThatHoldsThen) {
  RunConfiguration configuration = configurationOf("two-mass engine", 1000);
  configuration.protocol.until_decided = 0.5;
  expect(headlineOf(configuration, outcomesOf(PairTable{10, 50, 2, 38}), {}), "does_not_transfer",
         "No: with this policy the two-mass engine keeps 20 % [6, 40] of MuJoCo's success.");
  expect(headlineOf(configuration, outcomesOf(PairTable{5, 5, 1, 19}), {}), "cannot_say",
         "Cannot say yet: with this policy the two-mass engine keeps 60 % [0, 228] of MuJoCo's success.");
  expect(headlineOf(configuration, outcomesOf(PairTable{1, 0, 0, 9}), {}), "cannot_say",
         "Cannot say yet: with this policy the two-mass engine keeps 100 % [0 or more] of MuJoCo's success.");
}

/// A run may be decided before its tenth episode.
TEST(Headline, ARunThatEndsWhenItIsDecidedHasAnAnswerFromTheFirstEpisodeOn) {
  RunConfiguration configuration = configurationOf("two-mass engine", 1000);
  EXPECT_NE(headlineOf(configuration, outcomesOf(PairTable{0, 9, 0, 0}), {}).answer.find("9 episodes can say nothing"),
            std::string::npos);
  configuration.protocol.until_decided = 0.9;
  EXPECT_NE(headlineOf(configuration, outcomesOf(PairTable{0, 9, 0, 0}), {}).answer.find("keeps 0 % [0, "),
            std::string::npos);
  EXPECT_NE(headlineOf(configuration, outcomesOf(PairTable{0, 0, 0, 9}), {}).answer.find("9 episodes can say nothing"),
            std::string::npos);
}

TEST(Headline, TellsTwoOfOneKindApartByTheirRoles) {
  expect(headline("MuJoCo", {950, 0, 0, 50}), "transfers",
         "Yes: with this policy the engine keeps 100 % [100, 100] of the reference's success.");
}

/// The scale of words at its bounds, each of which belongs to the firmer word.
TEST(Headline, VerdictFollowsFromTheInterval) {
  const auto verdict = [](const Interval& interval) { return nameOf(verdictOf(interval)); };
  EXPECT_EQ(verdict({1.101, 2.0}), "exceeds");
  EXPECT_EQ(verdict({1.1, 2.0}), "transfers");
  EXPECT_EQ(verdict({0.9, 2.0}), "transfers");
  EXPECT_EQ(verdict({0.899, 2.0}), "cannot_say");
  EXPECT_EQ(verdict({0.0, 0.9}), "cannot_say");
  EXPECT_EQ(verdict({0.6, 0.899}), "transfers_in_part");
  EXPECT_EQ(verdict({0.5, 0.899}), "transfers_in_part");
  EXPECT_EQ(verdict({0.499, 0.899}), "at_most_in_part");
  EXPECT_EQ(verdict({0.0, 0.501}), "at_most_in_part");
  EXPECT_EQ(verdict({0.0, 0.5}), "does_not_transfer");
}

/// "50" beside "no" where the interval ends at 0.4996 would not say on which side of 0.5 that is.
TEST(Headline, FiguresStandOnTheirSideOfEachBound) {
  RunConfiguration configuration = configurationOf("two-mass engine", 1000);
  EXPECT_EQ(transferNumber(configuration, 0.5), "50");
  EXPECT_EQ(transferNumber(configuration, 0.504), "50.4");
  EXPECT_EQ(transferNumber(configuration, 0.4996), "49.96");
  EXPECT_EQ(transferNumber(configuration, 0.496), "49.6");
  EXPECT_EQ(transferNumber(configuration, 0.494), "49");
  EXPECT_EQ(transferNumber(configuration, 0.8999), "89.99");
  EXPECT_EQ(transferNumber(configuration, 1.1), "110");
  EXPECT_EQ(transferNumber(configuration, 1.1004), "110.04");
  EXPECT_EQ(transferNumber(configuration, 0.4999999), "50") << "as files have it";
  EXPECT_EQ(transferNumber(configuration, 0.328), "33");
  configuration.protocol.until_decided = 0.33;
  EXPECT_EQ(transferNumber(configuration, 0.328), "32.8");
}

/// Every outcome of 30 episodes in which the reference succeeds: the printed interval has the verdict of the words.
TEST(Headline, WordsFollowFromThePrintedFigures) {
  constexpr int kEpisodes = 30;
  int finer = 0;
  for (int both = 0; both <= kEpisodes; ++both) {
    for (int reference = both == 0 ? 1 : 0; both + reference <= kEpisodes; ++reference) {
      for (int engine = 0; both + reference + engine <= kEpisodes; ++engine) {
        const Headline found = headline("Chipmunk", {both, reference, engine, kEpisodes - both - reference - engine});
        const std::string interval = found.answer.substr(found.answer.find('['));
        std::smatch printed;
        ASSERT_TRUE(std::regex_search(interval, printed, std::regex(R"(^\[([0-9.]+), ([0-9.]+)\])"))) << found.answer;
        const double low = pusht::decimal<double>(printed[1]).value();
        const double high = pusht::decimal<double>(printed[2]).value();
        EXPECT_EQ(nameOf(verdictOf({low / 100.0, high / 100.0})), nameOf(found.verdict)) << found.answer;
        finer += interval.find('.') != std::string::npos && interval.find('.') < interval.find(']') ? 1 : 0;
      }
    }
  }
  EXPECT_GT(finer, 0) << "outcomes whose interval ends close to a bound";
}

TEST(Headline, IsJson) {
  EXPECT_EQ(toJson(headline("Chipmunk", {2, 0, 0, 0})).dump(),
            R"({"answer":"Cannot say yet: 2 episodes can say nothing; it takes 10 or more.","caveat":"","question":)"
            R"("Does the skill transfer?","verdict":"cannot_say"})");
}

TEST(InSentence, GivesANounItsArticle) {
  EXPECT_EQ(inSentence("rigid-body engine"), "the rigid-body engine");
  EXPECT_EQ(inSentence("two-mass engine, block_damp 20.0"), "the two-mass engine, block_damp 20.0");
  EXPECT_EQ(inSentence("Chipmunk"), "Chipmunk");
}

TEST(MarkOf, TellsNotShownFromTooFewToSay) {
  EXPECT_EQ(markOf(true), "");
  EXPECT_EQ(markOf(false), "(!)");
  EXPECT_EQ(markOf(std::nullopt), "(?)");
}

TEST(Headline, OfAPolicyInAnotherUnitSaysSo) {
  EndingsOfPairs endings;
  endings.reference.commands = 1000;
  endings.reference.limited_commands = 990;
  EXPECT_EQ(headlineOf(configurationOf("Chipmunk", 50), outcomesOf(PairTable{0, 0, 0, 50}), endings).caveat,
            "99 % of the policy's commands are at the limit of 1 m/s, where they are clipped: does it answer in m/s?");
  endings.reference.limited_commands = 400;
  EXPECT_EQ(headlineOf(configurationOf("Chipmunk", 50), outcomesOf(PairTable{0, 0, 0, 50}), endings).caveat, "");
}

}  // namespace
}  // namespace sim2sim
