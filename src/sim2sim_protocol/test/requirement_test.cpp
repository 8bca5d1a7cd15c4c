// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/requirement.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "pusht_task/error.hpp"
#include "run_episodes.hpp"

namespace sim2sim {
namespace {

using ::testing::HasSubstr;
using Verdict = RequirementResult::Verdict;

std::string refusalOfText(const std::string& text) {
  try {
    Requirement{text};
  } catch (const pusht::InvalidInput& refusal) {
    return refusal.what();
  }
  return "";
}

template <class Call>
std::string refusalOfCall(const Call& call) {
  try {
    call();
  } catch (const pusht::InvalidInput& refusal) {
    return refusal.what();
  }
  return "";
}

/// Answer of a run of `total` episodes.
RequirementResult answerOfRun(const std::string& text, int total, int reference, int engine) {
  const Protocol protocol = bare();
  std::vector<EpisodeResult> episodes = episodesWith(total, reference, engine);
  for (EpisodeResult& episode : episodes) {
    episode.rollouts[kEngineReplay].at("mean_angle_divergence") = 0.1;  // in range, however many there are
  }
  return judge(Requirement(text), protocol, summarize(protocol, episodes));
}

RequirementResult answerTo(const std::string& text, int reference, int engine) {
  return answerOfRun(text, 200, reference, engine);
}

TEST(Requirement, ReadsFigureNumberAndMargin) {
  const Requirement of_number("transfer > 0.8");
  EXPECT_EQ(of_number.figure.name, "transfer");
  EXPECT_FALSE(of_number.figure.run || of_number.subtracted);
  EXPECT_TRUE(of_number.is_more);
  EXPECT_EQ(of_number.bound, 0.8);
  EXPECT_EQ(Requirement("engine<62.5%").bound, 0.625);
  EXPECT_FALSE(Requirement("engine<62.5%").is_more);
  EXPECT_EQ(Requirement("engine > reference - 0.1").bound, -0.1);
  EXPECT_EQ(Requirement("engine > reference + 10%").bound, 0.1);
  const Requirement of_runs("B > A - 0.05");
  EXPECT_EQ(of_runs.figure.name, "engine");
  EXPECT_EQ(of_runs.figure.run, 1);
  EXPECT_EQ(of_runs.subtracted->run, 0);
  EXPECT_EQ(Requirement("C.transfer > A.transfer").figure.run, 2);
}

TEST(Requirement, RefusesWhatIsNone) {
  for (const char* text : {"", "transfer", "transfer => 0.8", "transfer > ", "0.8 < transfer", "transfer > 0.8 + 0.1",
                           "transfer > 0.8 and engine > 0.5"}) {
    EXPECT_THAT(refusalOfText(text), HasSubstr(": must be as \"transfer > 0.8\"")) << text;
  }
  EXPECT_THAT(refusalOfText("success > 0.8"), HasSubstr("success must be reference, engine or transfer"));
  EXPECT_THAT(refusalOfText("transfer > nan"), HasSubstr("nan must be reference, engine or transfer"));
  EXPECT_THAT(refusalOfText("engine > 0..8"), HasSubstr("0..8 must be a decimal number"));
  EXPECT_THAT(refusalOfText("transfer > engine"), HasSubstr("must compare engine and reference"));
  EXPECT_THAT(refusalOfText("B.transfer > A.engine"), HasSubstr("must compare the same figure of two runs"));
}

TEST(Requirement, HasABoundThatAFigureCanBeBeyond) {
  EXPECT_THAT(refusalOfText("engine < 80"), HasSubstr("the number must be from 0.0 to 1.0; or in percent, as 80%"));
  EXPECT_THAT(refusalOfText("engine > reference - 5"), HasSubstr("the number must be from -1.0 to 1.0"));
  EXPECT_THAT(refusalOfText("transfer > 80"), HasSubstr("the number must be from 0.0 to 10.0"));
  EXPECT_THAT(refusalOfText("transfer > -0.1"), HasSubstr("the number must be from 0.0"));
}

TEST(Requirement, NamesRunsWhereThereAreSeveral) {
  EXPECT_THAT(refusalOfCall([] { Requirement("B > A").requireOneRun(std::nullopt); }), HasSubstr("must name no run"));
  for (const char* text : {"transfer > 0.8", "C > A"}) {
    EXPECT_THAT(refusalOfCall([&] { Requirement(text).requireRuns(2); }),
                HasSubstr("must name runs by their letters, from A, as there are 2"));
  }
  EXPECT_THAT(refusalOfCall([] { Requirement("C > B").requireRuns(3); }), HasSubstr("must compare with A"));
  EXPECT_EQ(refusalOfCall([] { Requirement("B.engine > B.reference").requireRuns(2); }), "");
}

TEST(Requirement, OfARunThatMayStopEarlyIsOfItsTransfer) {
  EXPECT_EQ(refusalOfCall([] { Requirement("transfer > 0.8").requireOneRun(0.8); }), "");
  EXPECT_THAT(refusalOfCall([] { Requirement("transfer > 0.8").requireOneRun(0.5); }),
              HasSubstr("must have the share of --until-decided, 0.5"));
  EXPECT_THAT(refusalOfCall([] { Requirement("engine > 0.8").requireOneRun(0.8); }),
              HasSubstr("must be one of transfer"));
}

TEST(Requirement, IsJudgedByTheInterval) {
  EXPECT_EQ(answerTo("transfer > 0.8", 100, 100).verdict, Verdict::kMet);
  EXPECT_EQ(answerTo("transfer > 0.8", 100, 60).verdict, Verdict::kNotMet);
  EXPECT_EQ(answerTo("transfer > 0.8", 100, 82).verdict, Verdict::kCannotSay);
  EXPECT_EQ(answerTo("transfer < 0.8", 100, 60).verdict, Verdict::kMet);
  EXPECT_EQ(answerTo("engine > 0.3", 100, 100).verdict, Verdict::kMet);
  EXPECT_EQ(answerTo("reference > 0.6", 100, 100).verdict, Verdict::kNotMet);
  EXPECT_EQ(answerTo("engine > reference - 0.1", 100, 95).verdict, Verdict::kMet);
  EXPECT_EQ(answerTo("reference < engine + 0.1", 100, 95).verdict, Verdict::kMet);
  EXPECT_EQ(answerTo("engine > reference", 100, 60).verdict, Verdict::kNotMet);
}

/// The interval of 100 successes of 200 has a half-width near 0.07: to leave out a bound 0.05 away in 80 % of runs
/// takes (1.96 + 0.84)^2 0.25 / 0.05^2 = 785 starts.
TEST(Requirement, SaysHowManyStartsWouldDecide) {
  const RequirementResult answer = answerTo("engine > 0.45", 100, 100);
  EXPECT_EQ(answer.verdict, Verdict::kCannotSay);
  EXPECT_NEAR(answer.starts_needed.value(), 785, 25);
  EXPECT_THAT(answer.sentence(), HasSubstr("engine > 0.45: cannot say, 0.500 [0.431, 0.569]; "));
  EXPECT_THAT(answer.sentence(), HasSubstr(" starts would decide"));
  EXPECT_THAT(answerTo("engine > 0.5", 100, 100).sentence(), HasSubstr("more than 100000 starts would decide"));
}

TEST(Requirement, CannotBeSaidWithoutAnInterval) {
  const RequirementResult never = answerTo("transfer > 0.8", 0, 10);
  EXPECT_EQ(never.verdict, Verdict::kCannotSay);
  EXPECT_THAT(never.sentence(), HasSubstr("the reference never succeeds"));
  const RequirementResult few = answerOfRun("transfer > 0.1", 9, 9, 9);
  EXPECT_EQ(few.verdict, Verdict::kCannotSay);
  EXPECT_THAT(few.sentence(), HasSubstr("it takes 10 or more starts"));
}

}  // namespace
}  // namespace sim2sim
