// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <optional>
#include <string>

#include "live/evaluator_parameters.hpp"
#include "live/node_watch.hpp"
#include "live/progress_line.hpp"
#include "live/request.hpp"
#include "pusht_task/error.hpp"
#include "pusht_testing/refusal.hpp"
#include "pusht_testing/temporary_folder.hpp"

namespace sim2sim {
namespace {

using pusht::testing::refusalOf;

/// Unlike what any field is by itself.
LiveRequest parameters() {
  LiveRequest request;
  request.services.policy = "/policy";
  request.services.worlds = {"/reference", "/engine", "/engine_replay"};
  request.simulators.engine = {"two_mass", {pusht::parameter("block_damp", "8")}};
  request.protocol.seed = 7;
  request.protocol.first_episode = 3;
  request.protocol.episodes = 9;
  request.protocol.horizon = 30;
  request.rate = 50.0;
  request.record = true;
  request.out = "results";
  request.overwrite = true;
  return request;
}

TEST(SettingsFrom, TakesNamesWithValues) {
  using pusht::parameter;
  EXPECT_TRUE(parametersFrom("engine_parameters", " \n").empty());
  EXPECT_EQ(parametersFrom("engine_parameters", "  block_damp=20  scene=/my scenes/a=b.xml empty= "),
            (pusht::Parameters{parameter("block_damp", "20"), parameter("scene", "/my scenes/a=b.xml"),
                               parameter("empty", "")}));
}

TEST(SettingsFrom, RefusesWhatIsNone) {
  for (const std::string text : {"20", "20 block_damp=3", "=20", "-a=3"}) {
    EXPECT_EQ(refusalOf([&] { parametersFrom("engine_parameters", text); }),
              "engine_parameters '" + text + "': must be NAME=VALUE NAME=VALUE");
  }
  EXPECT_EQ(refusalOf([] { parametersFrom("engine_parameters", "block_damp=10 pusher_mass=2 block_damp=20"); }),
            "engine_parameters 'block_damp=10 pusher_mass=2 block_damp=20': block_damp must be set once");
  EXPECT_EQ(refusalOf([] { parametersFrom("engine_parameters", std::string(1'000'000, 'a') + "=1"); }),
            "engine_parameters of 1000002 bytes: must have at most 10000");
}

TEST(NodeWatch, ANodeThatWasNeverThereIsNotLost) {
  using pusht_msgs::NodeStatus;
  EXPECT_EQ(presenceAfter(NodeStatus::WAITING, Answer::kNone), NodeStatus::WAITING);
  EXPECT_EQ(presenceAfter(NodeStatus::WAITING, Answer::kGiven), NodeStatus::ALIVE);
  for (const auto presence : {NodeStatus::ALIVE, NodeStatus::SILENT, NodeStatus::LOST}) {
    EXPECT_EQ(presenceAfter(presence, Answer::kGiven), NodeStatus::ALIVE);
    EXPECT_EQ(presenceAfter(presence, Answer::kLate), NodeStatus::SILENT);
    EXPECT_EQ(presenceAfter(presence, Answer::kNone), NodeStatus::LOST);
  }
}

TEST(MergedGoal, LeavesOpenWhatItDoesNotSay) {
  const LiveRequest request = merged(parameters(), pusht_msgs::CompareGoal());
  EXPECT_EQ(request.services.policy, "/policy");
  EXPECT_EQ(request.services.worlds[kEngineReplay], "/engine_replay");
  EXPECT_EQ(request.simulators.engine.kind, "two_mass");
  EXPECT_EQ(request.simulators.engine.parameters, pusht::Parameters{pusht::parameter("block_damp", "8")});
  EXPECT_EQ(request.protocol.seed, 7U);
  EXPECT_EQ(request.protocol.first_episode, 3);
  EXPECT_EQ(request.protocol.episodes, 9);
  EXPECT_EQ(request.protocol.horizon, 30);
  EXPECT_EQ(request.rate, 50.0);
  EXPECT_TRUE(request.record);
  EXPECT_EQ(request.out, "results");
  EXPECT_TRUE(request.overwrite);
}

TEST(MergedGoal, AKindHasItsOwnParameters) {
  pusht_msgs::CompareGoal goal;
  goal.engine_parameters = {pusht::parameter("pusher_mass", "2")};
  EXPECT_EQ(merged(parameters(), goal).simulators.engine.parameters,
            (pusht::Parameters{pusht::parameter("block_damp", "8"), pusht::parameter("pusher_mass", "2")}));
  goal.engine = {"chipmunk"};
  const WorldRequest engine = merged(parameters(), goal).simulators.engine;
  EXPECT_EQ(engine.kind, "chipmunk");
  EXPECT_EQ(engine.parameters, pusht::Parameters{pusht::parameter("pusher_mass", "2")});
}

TEST(MergedGoal, SetsAParameterOnce) {
  pusht_msgs::CompareGoal goal;
  goal.engine_parameters = {pusht::parameter("block_damp", "20")};
  EXPECT_EQ(merged(parameters(), goal).simulators.engine.parameters,
            pusht::Parameters{pusht::parameter("block_damp", "20")})
      << "in place of the evaluator's";
  goal.engine_parameters.push_back(pusht::parameter("block_damp", "6"));
  EXPECT_EQ(refusalOf([&] { merged(parameters(), goal); }), "parameter block_damp 20, 6: must be set once");
  goal.engine_parameters.clear();
  goal.reference_parameters = {pusht::parameter("scene", "a"), pusht::parameter("scene", "a")};
  EXPECT_EQ(refusalOf([&] { merged(parameters(), goal); }), "parameter scene a, a: must be set once");
}

TEST(MergedGoal, KeepsTheSizeOfEveryNumberOfAnOldField) {
  constexpr std::uint32_t kMost = std::numeric_limits<std::uint32_t>::max();
  const auto refusal = [](std::vector<std::uint32_t> pusht_msgs::CompareGoal::*field) {
    pusht_msgs::CompareGoal goal;
    (goal.*field) = {kMost};
    return refusalOf([&] { merged(parameters(), goal); });
  };
  using Goal = pusht_msgs::CompareGoal;
  EXPECT_EQ(refusal(&Goal::episodes), "episodes 4294967295: must be from 1 to 1000000");
  EXPECT_EQ(refusal(&Goal::first_episode), "first_episode 4294967295: must be from 0 to 1000000000");
  EXPECT_EQ(refusal(&Goal::horizon), "horizon 4294967295: must be from 1 to 300 [control steps]");
  EXPECT_EQ(refusal(&Goal::reanchor), "reanchor '4294967295': must be numbers of control steps like 1,5,20");
  pusht_msgs::CompareGoal goal;
  goal.seed = {std::numeric_limits<std::uint64_t>::max()};
  EXPECT_EQ(merged(parameters(), goal).protocol.seed, goal.seed.front());
}

TEST(FreeFolder, IsTheFirstWithoutResults) {
  const pusht::testing::TemporaryFolder folder;
  const std::string out = (folder / "out").string();
  const auto add_results = [](const std::string& name) {
    std::filesystem::create_directory(name);
    std::ofstream(name + "/metrics.json") << "{}";
  };
  EXPECT_EQ(freeFolder(""), "");
  EXPECT_EQ(freeFolder(out), out);
  add_results(out);
  EXPECT_EQ(freeFolder(out), out + "-2");
  EXPECT_EQ(freeFolder(out + "/"), out + "-2");
  add_results(out + "-2");
  EXPECT_EQ(freeFolder(out), out + "-3");
}

TEST(MergedGoal, SaysWhereTheWorldsAre) {
  pusht_msgs::CompareGoal goal;
  goal.engine_namespace = {"mine"};
  EXPECT_EQ(merged(parameters(), goal).services.worlds[kEngineClosed], "/mine");
  EXPECT_EQ(merged(parameters(), goal).services.worlds[kReferenceClosed], "/reference");
}

TEST(MergedGoal, CanSayZeroAndFalse) {
  pusht_msgs::CompareGoal goal;
  goal.policy_namespace = {"/mine"};
  goal.seed = {0};
  goal.first_episode = {0};
  goal.episodes = {2};
  goal.horizon = {40};
  goal.rate = {0.0};
  goal.record = {0};
  goal.out = {""};
  goal.overwrite = {0};
  const LiveRequest request = merged(parameters(), goal);
  EXPECT_EQ(request.services.policy, "/mine");
  EXPECT_EQ(request.protocol.seed, 0U);
  EXPECT_EQ(request.protocol.first_episode, 0);
  EXPECT_EQ(request.protocol.episodes, 2);
  EXPECT_EQ(request.protocol.horizon, 40);
  EXPECT_EQ(request.rate, 0.0);
  EXPECT_FALSE(request.record);
  EXPECT_EQ(request.out, "");
  EXPECT_FALSE(request.overwrite);
}

TEST(MergedGoal, CanSayThatNoReplayIsReanchored) {
  LiveRequest request = parameters();
  request.protocol.floor = false;
  request.protocol.reanchor = {1, 5};
  pusht_msgs::CompareGoal goal;
  EXPECT_EQ(merged(request, goal).protocol.probes().size(), 2U) << "as the parameter says";
  goal.reanchor = {0};
  EXPECT_TRUE(merged(request, goal).protocol.reanchor.empty());
  EXPECT_TRUE(merged(request, goal).protocol.probes().empty());
  goal.reanchor = {0, 5};
  EXPECT_THAT(refusalOf([&] { merged(request, goal); }), ::testing::HasSubstr("reanchor 0: must be from 1 to"));
  LiveRequest none = parameters();
  EXPECT_TRUE(merged(request, goalOf(none)).protocol.reanchor.empty()) << "a goal that says all";
}

TEST(MergedGoal, NamesWhatCannotBe) {
  pusht_msgs::CompareGoal twice;
  twice.seed = {1, 2};
  EXPECT_THAT(refusalOf([&] { merged(parameters(), twice); }),
              ::testing::HasSubstr("seed has 2 values: must have one"));
  pusht_msgs::CompareGoal nameless;
  nameless.policy_namespace = {"a b"};
  EXPECT_THAT(refusalOf([&] { merged(parameters(), nameless); }),
              ::testing::HasSubstr("policy_namespace 'a b': must be a ROS name"));
}

TEST(ProgressLine, SpeaksEveryFiveSecondsInMidEpisodeToo) {
  using std::chrono::seconds;
  const ProgressLine::Clock::time_point begin;
  ProgressLine line(50, begin);
  EXPECT_FALSE(line.due(begin + seconds(4)));
  EXPECT_TRUE(line.due(begin + seconds(5)));
  EXPECT_FALSE(line.due(begin + seconds(9)));
  EXPECT_TRUE(line.due(begin + seconds(10)));
  EXPECT_EQ(line.text(std::nullopt, 50, begin + seconds(5)),
            "0 of 50 episodes finished, the next one is at control step 50");
  Summary finished;
  finished.episodes = 10;
  finished.reference.successes = 6;
  finished.engine.successes = 2;
  EXPECT_EQ(line.text(finished, 7, begin + seconds(20)),
            "10 of 50 episodes finished, the next one is at control step 7; success: reference 6, engine 2; about 80 s "
            "left");
}

TEST(MergedGoal, DoesNotChangeHowShortASmokeRunIs) {
  LiveRequest smoke = parameters();
  smoke.smoke = true;
  pusht_msgs::CompareGoal longer;
  longer.episodes = {7};
  EXPECT_THAT(refusalOf([&] { merged(smoke, longer); }), ::testing::HasSubstr("a smoke run has its own"));
  pusht_msgs::CompareGoal other;
  other.seed = {1};
  EXPECT_EQ(merged(smoke, other).protocol.seed, 1U);
}

}  // namespace
}  // namespace sim2sim
