// SPDX-License-Identifier: BSD-3-Clause
#include "results/answers.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "pusht_task/error.hpp"

namespace sim2sim {
namespace {

using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

json simulator(const std::string& name, const std::string& title, const json& parameters, const json& changed) {
  return {
      {"name", name}, {"title", title}, {"parameters", parameters}, {"units", json::object()}, {"changed", changed}};
}

/// A run of `total` episodes in which MuJoCo succeeds in 3 of 5, the engine in every `nth`; its tee is `away` from
/// MuJoCo's [m and rad], with a scatter that is the same in all runs.
RunResults run(const json& engine, int total, int nth, double away) {
  RunResults results;
  results.folder = "run";
  results.metrics["simulators"] = {{"reference", simulator("mujoco", "MuJoCo", json::object(), json::array())},
                                   {"engine", engine}};
  results.protocol.floor = false;
  results.protocol.episodes = total;
  for (int i = 0; i < total; ++i) {
    EpisodeResult episode;
    episode.index = i;
    for (RolloutResult& rollout : episode.rollouts) {
      rollout.quantities.fill(0.0);
    }
    episode.rollouts[kReferenceClosed].success = i % 5 < 3;
    episode.rollouts[kEngineClosed].success = i % nth == 0;
    RolloutResult& replay = episode.rollouts[kEngineReplay];
    replay.at("mean_position_divergence") = away * (1.0 + 0.01 * (i % 7));
    replay.at("mean_angle_divergence") = 1.0 + 0.01 * (i % 7) * (away > 0.1 ? 1.0 : (i % 2 == 0 ? 1.1 : 0.9));
    results.episodes.push_back(episode);
  }
  return results;
}

RunResults damped(double block_damp, int total, int nth, double away) {
  const json changed = block_damp == 6.0 ? json::array() : json{"block_damp"};
  return run(simulator("two_mass", "two-mass engine", {{"block_damp", block_damp}, {"pusher_mass", 4.0}}, changed),
             total, nth, away);
}

RunResults chipmunk(int total, int nth, double away) {
  return run(simulator("chipmunk", "Chipmunk", {{"iterations", 30}}, json::array()), total, nth, away);
}

std::string answer(const std::vector<RunResults>& runs) {
  const std::vector<RunResults> others(runs.begin() + 1, runs.end());
  return answerOf(runs.front(), others, contrastsOf(runs.front(), others)).text();
}

TEST(Answer, OfASweepOverOneParameterSaysWhatItChanges) {
  EXPECT_EQ(answer({damped(2, 60, 12, 0.2), damped(6, 60, 5, 0.08), damped(20, 60, 5, 0.07), damped(60, 60, 12, 0.07)}),
            "What does block_damp change? At every block_damp (2, 6, 20 and 60) the policy succeeds in 8 to 20 % of 60 "
            "episodes, in MuJoCo in 60 %. Against block_damp 2, the position divergence falls at every other value; "
            "no change of success or the angle divergence is shown.");
}

TEST(Answer, OfASweepNamesTheValuesThatDiffer) {
  EXPECT_EQ(answer({damped(6, 60, 5, 0.08), damped(2, 60, 5, 0.09), damped(20, 60, 1, 0.07)}),
            "What does block_damp change? At every block_damp (6, 2 and 20) the policy succeeds in 20 to 100 % of 60 "
            "episodes, in MuJoCo in 60 %. Against block_damp 6, success rises at 20; the position divergence falls at "
            "20 and rises at 2; no change of the angle divergence is shown.");
}

TEST(Answer, OfTwoEnginesSaysHowMuch) {
  EXPECT_EQ(
      answer({damped(6, 60, 5, 0.08), chipmunk(60, 2, 0.03)}),
      "What differs between the runs? In these 2 runs the policy succeeds in 20 to 50 % of 60 episodes, in MuJoCo "
      "in 60 %. Against the two-mass engine, with Chipmunk success rises by 0.300 [0.129, 0.454]; the position "
      "divergence falls by 0.0515 m [0.0512, 0.0517]; the angle divergence is the same.");
}

TEST(Answer, OfSeveralEnginesNamesThem) {
  EXPECT_EQ(
      answer({damped(6, 60, 5, 0.08), chipmunk(60, 2, 0.03), damped(2, 60, 5, 0.08)}),
      "What differs between the runs? In these 3 runs the policy succeeds in 20 to 50 % of 60 episodes, in MuJoCo "
      "in 60 %. Against the two-mass engine, block_damp 6.0, success rises in Chipmunk; the position divergence falls "
      "in Chipmunk; no change of the angle divergence is shown.");
}

TEST(Answer, OfOneFigureAmongManyHasHolmsP) {
  EXPECT_THAT(answer({damped(6, 100, 5, 0.08), damped(20, 100, 3, 0.08)}),
              HasSubstr("success is not shown to change (+0.140 [0.017, 0.261], after Holm p 0.5231)"));
}

TEST(Answer, OfFewEpisodesSaysThatTheyAreTooFew) {
  EXPECT_THAT(answer({damped(6, 10, 5, 0.08), damped(20, 10, 5, 0.07)}),
              EndsWith("Against block_damp 6, with block_damp 20 success is not shown to change (0.000 [-0.278, "
                       "0.278]); there are too few episodes to "
                       "compare the position divergence; there are too few episodes to compare the angle "
                       "divergence."));
}

TEST(Answer, OfASweepOverSwitchesSuggestsAttribute) {
  std::vector<RunResults> runs;
  for (const bool shape : {false, true}) {
    for (const bool drag : {false, true}) {
      runs.push_back(
          run(simulator("rigid_body", "rigid-body engine", {{"shape", shape}, {"drag", drag}}, json::array()), 20, 5,
              0.08));
    }
  }
  EXPECT_THAT(answer(runs), EndsWith("`attribute` says how much of the gap each switch explains."));
  EXPECT_THAT(answer(runs), StartsWith("What differs between the runs? In these 4 runs the policy succeeds in 20 %"));
}

/// A baseline with all its defaults shows the parameter that the others vary.
TEST(TitlesOf, NameWhatTellsRunsApart) {
  EXPECT_THAT(titlesOf({damped(6, 1, 1, 0.1), damped(20, 1, 1, 0.1), chipmunk(1, 1, 0.1)}),
              ElementsAre("two-mass engine, block_damp 6.0", "two-mass engine, block_damp 20.0", "Chipmunk"));
}

/// Run of a policy of which MuJoCo succeeds in the first `home` of 60 episodes, Chipmunk in the first `away`.
RunResults policyRun(const std::string& policy, int home, int away) {
  RunResults results = chipmunk(60, 1, 0.05);
  results.metrics["policy"] = policy;
  for (int i = 0; i < 60; ++i) {
    results.episodes[i].rollouts[kReferenceClosed].success = i < home;
    results.episodes[i].rollouts[kEngineClosed].success = i < away;
  }
  return results;
}

TEST(Answer, OfTwoPoliciesSaysWhichIsBetterWhere) {
  EXPECT_EQ(answer({policyRun("runs/a.pt", 30, 20), policyRun("runs/b.pt", 34, 40)}),
            "Is b.pt better than a.pt? In MuJoCo b.pt is not shown to be better or worse than a.pt: +6.7 points [+0.2, "
            "+15.9] over 60 starts; 188 would show 5. In Chipmunk b.pt is better than a.pt: +33 points [+23, +46] over "
            "60 starts. Chipmunk keeps 67 % [49, 81] of a.pt's success and 118 % [106, 141] of b.pt's: +51 points "
            "[+33, +80].");
}

TEST(Answer, OfSeveralPoliciesNamesThoseThatDiffer) {
  EXPECT_EQ(answer({policyRun("a.pt", 30, 20), policyRun("b.pt", 34, 40), policyRun("c.pt", 5, 21)}),
            "Which policies are better than a.pt? In MuJoCo worse: c.pt; not shown: b.pt. In Chipmunk better: b.pt; "
            "not shown: c.pt.");
}

TEST(Contrast, OfPoliciesHasBothSimulatorsAndTheTransfer) {
  const Contrast contrast = contrastsOf(policyRun("a.pt", 30, 20), {policyRun("b.pt", 34, 40)}).front();
  EXPECT_EQ(contrast.rows[0].name, kReferenceSuccessRow);
  EXPECT_EQ(contrast.rows[1].name, kSuccessRow);
  EXPECT_EQ(contrast.rows[2].name, kTransferRow);
  EXPECT_NEAR(contrast.row(kTransferRow).difference.value, 40.0 / 34.0 - 20.0 / 30.0, 1e-12);
  EXPECT_THAT(contrast.policies.value().reference.gained, ElementsAre(30, 31, 32, 33));
  EXPECT_THAT(contrast.policies.value().reference.lost, ElementsAre());
  EXPECT_EQ(contrast.engine.gained.size(), 20U);
}

std::string refusalOf(const RunResults& baseline, const std::vector<RunResults>& others) {
  try {
    contrastsOf(baseline, others);
  } catch (const pusht::InvalidInput& refusal) {
    return refusal.what();
  }
  return "";
}

TEST(Contrast, RefusesRunsThatDifferInPolicyAndEngine) {
  RunResults both = damped(6, 60, 5, 0.08);
  both.metrics["policy"] = "b.pt";
  EXPECT_THAT(refusalOf(policyRun("a.pt", 30, 20), {both}),
              HasSubstr("do not pair: policy is \"a.pt\" and \"b.pt\", and simulators/engine"));
  RunResults engine = policyRun("a.pt", 30, 20);
  engine.metrics["simulators"]["engine"]["parameters"]["iterations"] = 3;
  EXPECT_THAT(refusalOf(policyRun("a.pt", 30, 20), {policyRun("b.pt", 30, 20), engine}),
              HasSubstr("differs from run in the engine, others do not"));
}

/// Two files of one name, as of two folders that were entered in turn, are told apart by their digests.
TEST(Contrast, TellsFilesOfOneNameApart) {
  RunResults one = policyRun("policy.pt", 30, 20);
  RunResults other = policyRun("policy.pt", 34, 20);
  EXPECT_THAT(refusalOf(one, {other}), HasSubstr("the reference did not do the same in episode 30"));
  one.policy_sha256 = "0123456789";
  other.policy_sha256 = "abcdefabcd";
  EXPECT_EQ(contrastsOf(one, {other}).front().title, "policy.pt (abcdefab)");
  other = one;
  other.metrics["execute"] = 4;
  EXPECT_EQ(contrastsOf(one, {other}).front().title, "policy.pt, execute 4");
  EXPECT_EQ(policyTitles({policyRun("x/a/p.pt", 1, 1), policyRun("x/b/p.pt", 1, 1)}),
            (std::vector<std::string>{"a/p.pt", "b/p.pt"}));
}

}  // namespace
}  // namespace sim2sim
