// SPDX-License-Identifier: BSD-3-Clause
// A policy node gives the bytes of the policy, whatever happens between the queries.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "network_testing.hpp"
#include "pusht_policy/policy_choice.hpp"
#include "pusht_task/error.hpp"
#include "sim2sim_serving/policy_session.hpp"

namespace pusht {
namespace {

using ::testing::HasSubstr;

constexpr int kSteps = 12;

class ServedNetwork : public ::testing::TestWithParam<const char*> {
 protected:
  PolicySession session() const { return PolicySession({"network", "1", chosen_.make(), chosen_.provenance}); }

  static pusht_msgs::Query query(std::uint64_t rollout, int step, const Beginning& beginning) {
    const std::vector<Observation> all = testing::observations();
    pusht_msgs::Query query;
    query.rollout = rollout;
    query.step = static_cast<std::uint32_t>(step);
    query.seed = beginning.seed;
    query.execute = static_cast<std::uint32_t>(beginning.execute);
    const Observation& observation = all[static_cast<std::size_t>(step)];
    std::copy(observation.begin(), observation.end(), query.observation.begin());
    return query;
  }

  /// Action for a query that is sent alone, or why there is none.
  static std::pair<Action, std::string> ask(PolicySession& session, const pusht_msgs::Query& query) {
    pusht_msgs::ActRequest request;
    request.queries = {query};
    const pusht_msgs::ActResponse response = session.act(request);
    return response.success ? std::pair(Action{response.actions.at(0), response.actions.at(1)}, std::string())
                            : std::pair(Action{}, response.message);
  }

  std::vector<Action> inProcess(const Beginning& beginning) const {
    return testing::drive(*chosen_.make(), {beginning}, kSteps, 1).front();
  }

  const ChosenPolicy chosen_ = choosePolicy({(testing::checkpointsFromPython() / GetParam()).string()}, "none");
};

TEST_P(ServedNetwork, GivesTheBytesOfThePolicyThoughQueriesAreSentTwice) {
  PolicySession session = this->session();
  const std::vector<std::pair<std::uint64_t, Beginning>> rollouts = {{7, {1, 0}}, {8, {1, 1}}, {9, {2, 0}}};
  for (const auto& [rollout, beginning] : rollouts) {
    const std::vector<Action> expected = inProcess(beginning);
    for (int step = 0; step < kSteps; ++step) {
      for (int time = 0; time < 1 + step % 3; ++time) {  // as after an answer that was lost on its way
        EXPECT_EQ(ask(session, query(rollout, step, beginning)), std::pair(expected[step], std::string()))
            << "rollout " << rollout << ", step " << step << ", time " << time;
      }
    }
  }
}

TEST_P(ServedNetwork, GivesTheSameBytesToAnEpisodeThatBeginsAgainElsewhere) {
  const Beginning beginning = {3, 0};
  const std::vector<Action> expected = inProcess(beginning);
  PolicySession first = session();
  for (int step = 0; step < 5; ++step) {
    ask(first, query(7, step, beginning));
  }
  PolicySession respawned = session();
  const std::string refusal = ask(respawned, query(7, 5, beginning)).second;
  EXPECT_EQ(refusal, "rollout 7: step 5: expected 0") << "it has no memory of the rollout, and must not invent one";
  for (PolicySession* const session : {&respawned, &first}) {
    for (int step = 0; step < kSteps; ++step) {
      EXPECT_EQ(ask(*session, query(7, step, beginning)).first, expected[step]) << "step " << step;
    }
  }
}

TEST_P(ServedNetwork, RefusesToExecuteMoreThanItAnswers) {
  PolicySession session = this->session();
  const int answered = chosen_.provenance.at("description").at("actions");
  const Beginning one_more = {0, answered + 1};
  ask(session, query(7, 0, {}));
  EXPECT_THAT(ask(session, query(8, 0, one_more)).second, HasSubstr("must be from 1 to "));
  auto far_more = query(8, 0, {});
  far_more.execute = 3'000'000'000U;
  EXPECT_EQ(ask(session, far_more).second, "rollout 8: execute 3000000000: must be below 2^31");
  EXPECT_EQ(ask(session, query(7, 1, {})).first, inProcess({})[1]) << "others are not disturbed";
}

INSTANTIATE_TEST_SUITE_P(Kinds, ServedNetwork, ::testing::Values("chunks.pt", "gru.pt", "denoising.pt"),
                         [](const auto& info) {
                           const std::string name = info.param;
                           return name.substr(0, name.find('.'));
                         });

TEST(ChosenNetwork, SaysWhatOthersMustKnow) {
  const auto choose = [](const char* name) {
    return choosePolicy({(testing::checkpointsFromPython() / name).string()}, "none");
  };
  const ChosenPolicy denoising = choose("denoising.pt");
  EXPECT_EQ(denoising.provenance.at("noise").at("distribution"), "normal");
  EXPECT_EQ(denoising.provenance.at("description").at("observations"), 2);
  EXPECT_EQ(denoising.identity.at("description"), denoising.provenance.at("description"));
  const ChosenPolicy recurrent = choose("gru.pt");
  EXPECT_FALSE(recurrent.provenance.contains("noise"));
  EXPECT_EQ(recurrent.provenance.at("description").at("state").at("shape").at(0), 48);
  const ChosenPolicy plain = choose("course_scripted.pt");
  EXPECT_FALSE(plain.provenance.contains("description")) << "as before there were descriptions";
  EXPECT_EQ(plain.identity.size(), 2U);
}

}  // namespace
}  // namespace pusht
