// SPDX-License-Identifier: BSD-3-Clause
#include "bag/run_bag.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pusht_msgs/WorldStateStamped.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <std_msgs/String.h>
#include <tf2_msgs/TFMessage.h>

#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bag/messages.hpp"
#include "bag/recorded_run.hpp"
#include "pusht_engine/two_mass_engine.hpp"
#include "pusht_policy/scripted_expert.hpp"
#include "pusht_task/error.hpp"
#include "pusht_testing/temporary_folder.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/flight.hpp"
#include "sim2sim_protocol/results/episodes_csv.hpp"
#include "sim2sim_protocol/results/provenance.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/results/summary.hpp"
#include "sim2sim_serving/conversions.hpp"
#include "sim2sim_serving/remote_simulator.hpp"

namespace sim2sim {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Three worlds with an expert in them. In episode 5 it succeeds in the reference before the horizon.
class Play {
 public:
  Play() {
    configuration_.protocol.first_episode = 3;
    configuration_.protocol.episodes = 3;
    configuration_.protocol.reanchor = {5};
    configuration_.policy = "expert";
    configuration_.reference = {"two_mass", "two-mass engine", {{"block_damp", 60.0}}, {"block_damp"}};
    configuration_.engine = {"two_mass", "two-mass engine", {{"block_damp", 6.0}}};
    pusht::TwoMassParameters draggy;
    draggy.block_damp = 60.0;
    worlds_ = worldsOf(std::make_unique<pusht::TwoMassEngine>(draggy), std::make_unique<pusht::TwoMassEngine>(),
                       std::make_unique<pusht::TwoMassEngine>());
  }

  const RunConfiguration& configuration() const { return configuration_; }
  nlohmann::ordered_json origin() const {
    return provenance(configuration_, {{"runs_on", "scripted"}}, {{"scene", "none"}}, nlohmann::json::object());
  }

  Episode run(int index) { return runEpisode(configuration_.protocol, index, worlds_, expert_); }

 private:
  RunConfiguration configuration_;
  pusht::ScriptedExpert expert_;
  Worlds worlds_;
};

constexpr std::size_t kProbes = 3;

RecordedEpisode recordedEpisode(const Episode& episode) {
  RecordedEpisode record{{episode.rollout(kReferenceClosed).trace(), episode.rollout(kEngineClosed).trace(),
                          episode.rollout(kEngineReplay).trace()}};
  for (std::size_t i = 0; i < kProbes; ++i) {
    record.probes.push_back(episode.probe(i)->states);
  }
  return record;
}

/// Writes a run as an evaluator does.
class Recording {
 public:
  Recording(const std::filesystem::path& path, const Play& play)
      : configuration_(play.configuration()), bag_(path, play.origin(), defaultWorldNames(), stamps_.now()) {}

  /// The first control steps of an episode.
  void begin(const Episode& episode, int steps) {
    for (int step = 0; step <= steps; ++step) {
      stamps_.advance();
      bag_.writeWorlds(episode, step, stamps_.now());
      bag_.write(divergenceMessage(episode, step, stamps_.now()));
    }
  }

  void end(const Episode& episode, const EpisodeResult& result) {
    const Protocol& protocol = configuration_.protocol;
    bag_.writeProbes(protocol, episode, stamps_.now());
    bag_.write(toMessage(protocol, result, stamps_.now()));
    finished_.push_back(result);
    bag_.write(summaryMessage(configuration_, summarize(protocol, finished_), stamps_.now()));
  }

  void record(const Episode& episode) {
    begin(episode, episode.steps());
    end(episode, episode.result());
  }

  void finish() { bag_.finish(); }

 private:
  RunConfiguration configuration_;
  pusht::StampSource stamps_;
  std::vector<EpisodeResult> finished_;
  RunBag bag_;
};

std::string refusal(const std::function<void()>& action, pusht::ExitCode code) {
  try {
    action();
  } catch (const pusht::Error& error) {
    EXPECT_EQ(error.exitCode(), code) << error.what();
    return error.what();
  }
  return "";
}

class RunBagTest : public ::testing::Test {
 protected:
  Play play_;
  pusht::testing::TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_ / "compare.bag";
};

TEST_F(RunBagTest, IsReadAsItWasRun) {
  std::vector<EpisodeResult> results;
  {
    Recording recording(path_, play_);
    for (const int index : {3, 5, 4}) {
      const Episode episode = play_.run(index);
      recording.record(episode);
      results.push_back(episode.result());
    }
    recording.finish();
  }
  std::swap(results[1], results[2]);
  const RecordedRun run = readRun(path_);
  EXPECT_EQ(episodesCsv(run.configuration.protocol, run.episodes), episodesCsv(run.configuration.protocol, results));
  EXPECT_EQ(describe(run.configuration).dump(), describe(play_.configuration()).dump());
  EXPECT_EQ(run.provenance.dump(), play_.origin().dump());
}

TEST_F(RunBagTest, HoldsWhatIsSaidOnTheTopicsAtTheTimeOfTheStamps) {
  const Episode episode = play_.run(4);
  {
    Recording recording(path_, play_);
    recording.record(episode);
  }
  const rosbag::Bag bag(path_.string());
  rosbag::View view(bag);
  EXPECT_EQ(view.begin()->getTopic(), kConfigurationTopic);

  std::map<std::string, std::vector<int>> steps;
  for (const rosbag::MessageInstance& message : view) {
    const bool latched = message.isLatching();
    EXPECT_EQ(latched, message.getTopic() == kConfigurationTopic || message.getTopic() == kSummaryTopic);
    if (const auto state = message.instantiate<pusht_msgs::WorldStateStamped>()) {
      EXPECT_EQ(state->header.stamp, message.getTime());
      EXPECT_EQ(state->header.frame_id, message.getTopic().substr(1, message.getTopic().rfind('/') - 1) + "/table");
      EXPECT_EQ(state->episode, 4U);
      EXPECT_TRUE(state->step > 0 || (state->action[0] == 0.0F && state->action[1] == 0.0F));
      steps[message.getTopic()].push_back(static_cast<int>(state->step));
    } else if (const auto divergence = message.instantiate<pusht_msgs::Divergence>()) {
      EXPECT_EQ(divergence->header.stamp, message.getTime());
      steps[message.getTopic()].push_back(static_cast<int>(divergence->step));
    }
  }
  for (const Mode mode : kModes) {
    const std::vector<int>& recorded = steps[defaultWorldNames()[mode].state_topic];
    ASSERT_EQ(static_cast<int>(recorded.size()), episode.rollout(mode).steps() + 1) << modeName(mode);
    EXPECT_EQ(recorded.front(), 0);
    EXPECT_EQ(recorded.back(), episode.rollout(mode).steps());
  }
  EXPECT_EQ(static_cast<int>(steps[kDivergenceTopic].size()), episode.steps() + 1);
}

TEST_F(RunBagTest, HoldsTheFramesOfTheWorlds) {
  const Episode episode = play_.run(4);
  {
    Recording recording(path_, play_);
    recording.begin(episode, 0);
  }
  const rosbag::Bag bag(path_.string());
  rosbag::View view(bag, rosbag::TopicQuery(kTfTopic));
  const auto frames = view.begin()->instantiate<tf2_msgs::TFMessage>();
  ASSERT_TRUE(frames);
  std::vector<std::string> children;
  for (const auto& frame : frames->transforms) {
    children.push_back(frame.child_frame_id);
    EXPECT_EQ(frame.header.frame_id, frame.child_frame_id.substr(0, frame.child_frame_id.find('/')) + "/table");
  }
  EXPECT_THAT(children, ElementsAre("reference/pusher", "reference/tee", "engine/pusher", "engine/tee",
                                    "engine_replay/pusher", "engine_replay/tee"));
  const pusht::WorldState& start = episode.rollout(kReferenceClosed).trace().states.front();
  const geometry_msgs::Transform& tee = frames->transforms.at(1).transform;
  EXPECT_EQ(tee.translation.x, start.tee_position.x());
  EXPECT_EQ(tee.translation.y, start.tee_position.y());
  EXPECT_EQ(tee.translation.z, 0.015);
  EXPECT_NEAR(pusht::wrapAngle(2.0 * std::atan2(tee.rotation.z, tee.rotation.w) - start.tee_yaw), 0.0, 1e-12);
  EXPECT_EQ(frames->transforms.at(0).transform.translation.z, 0.02);
}

/// A node that is lost makes an episode void; it is then run again, and the second attempt counts.
TEST_F(RunBagTest, AnEpisodeThatIsBegunAnewCountsFromThere) {
  {
    Recording recording(path_, play_);
    recording.begin(play_.run(5), 20);
    recording.begin(play_.run(4), 7);
    recording.record(play_.run(4));
  }
  const RecordedRun run = readRun(path_);
  EXPECT_EQ(episodesCsv(run.configuration.protocol, run.episodes),
            episodesCsv(run.configuration.protocol, {play_.run(4).result()}));
}

TEST_F(RunBagTest, KnowsNoEpisodeBeforeOneHasFinished) {
  {
    Recording recording(path_, play_);
    const Episode episode = play_.run(3);
    recording.begin(episode, episode.steps());
  }
  EXPECT_TRUE(readRun(path_).episodes.empty());
}

TEST_F(RunBagTest, AResultThatIsNotThatOfTheStatesIsRefused) {
  {
    Recording recording(path_, play_);
    const Episode episode = play_.run(3);
    recording.begin(episode, episode.steps());
    EpisodeResult result = episode.result();
    double& angle = result.rollouts[kEngineReplay].at("mean_angle_divergence");
    angle = std::nextafter(angle, 0.0);
    recording.end(episode, result);
  }
  EXPECT_THAT(refusal([this] { readRun(path_); }, pusht::ExitCode::kBadDependency),
              HasSubstr("episode 3: its result does not follow from the recorded states"));
}

TEST_F(RunBagTest, WhatDoesNotFollowTheProtocolIsRefusedByName) {
  const Episode episode = play_.run(5);
  const auto replayed = [&](const std::function<void(RecordedEpisode&)>& change) {
    RecordedEpisode record = recordedEpisode(episode);
    change(record);
    return refusal([&] { rebuildEpisode(play_.configuration().protocol, 5, record); }, pusht::ExitCode::kBadDependency);
  };
  EXPECT_EQ(replayed([](RecordedEpisode&) {}), "");
  EXPECT_THAT(replayed([](RecordedEpisode& e) { e.modes[kEngineClosed].states[0].tee_position.x() += 1e-5; }),
              HasSubstr("episode 5 (spawn seed 10005), engine_closed, step 0: the start that is recorded is not"));
  EXPECT_THAT(replayed([](RecordedEpisode& e) { e.modes[kEngineReplay].actions[7][1] += 1e-6F; }),
              HasSubstr("engine_replay, step 7: the action that is recorded is ("));
  EXPECT_THAT(replayed([](RecordedEpisode& e) {
                e.modes[kEngineReplay].states.pop_back();
                e.modes[kEngineReplay].actions.pop_back();
              }),
              HasSubstr("no more is recorded, but the rollout must go on"));
  EXPECT_THAT(replayed([](RecordedEpisode& e) {
                e.modes[kReferenceClosed].states.push_back(e.modes[kReferenceClosed].states.back());
                e.modes[kReferenceClosed].actions.push_back({0.0F, 0.0F});
              }),
              HasSubstr("episode 5, reference_closed: "));
  EXPECT_THAT(replayed([](RecordedEpisode& e) { e.modes[kEngineClosed] = {}; }), HasSubstr("no start is recorded"));
  EXPECT_THAT(replayed([](RecordedEpisode& e) { e.probes[1].pop_back(); }), HasSubstr("episode 5, floor_1e-6: "));
  EXPECT_THAT(replayed([](RecordedEpisode& e) { e.probes.clear(); }),
              HasSubstr("episode 5, floor_1e-9: 0 steps are recorded, must be "));
}

/// What `rosbag record -a` makes: its own times, and topics that overtake each other.
void recordPlainly(const std::filesystem::path& ours, const std::filesystem::path& plain) {
  const rosbag::Bag source(ours.string());
  rosbag::Bag copy(plain.string(), rosbag::bagmode::Write);
  ros::Time now(1e9);
  const auto take = [&](const std::vector<std::string>& topics) {
    for (const rosbag::MessageInstance& instance : rosbag::View(source, rosbag::TopicQuery(topics))) {
      now += ros::Duration(0, 1000);
      copy.write(instance.getTopic(), now, instance);
    }
  };
  take({kConfigurationTopic});
  take({kEpisodeTopic});
  take({"/engine_replay/state", "/engine/state"});
  take({kTraceTopic, "/reference/state", kSummaryTopic, kTfTopic});
}

TEST_F(RunBagTest, ABagOfAPlainRecorderIsTheSameRun) {
  {
    Recording recording(path_, play_);
    recording.begin(play_.run(3), 7);  // a node is lost
    for (const int index : {3, 4, 5}) {
      recording.record(play_.run(index));
    }
    recording.finish();
  }
  const std::filesystem::path plain = folder_ / "plain.bag";
  recordPlainly(path_, plain);
  const RecordedRun wanted = readRun(path_);
  const RecordedRun found = readRun(plain);
  EXPECT_EQ(found.provenance, wanted.provenance);
  EXPECT_EQ(found.bands.csv(), wanted.bands.csv());
  const Protocol& protocol = wanted.configuration.protocol;
  EXPECT_EQ(episodesCsv(protocol, found.episodes), episodesCsv(protocol, wanted.episodes));
}

TEST_F(RunBagTest, AGapIsRefusedByName) {
  const Episode episode = play_.run(3);
  {
    RunBag bag(path_, play_.origin(), defaultWorldNames(), ros::Time(0.1));
    bag.writeWorlds(episode, 0, ros::Time(0.2));
    bag.writeWorlds(episode, 1, ros::Time(0.3));
    bag.writeWorlds(episode, 3, ros::Time(0.4));
  }
  EXPECT_THAT(refusal([this] { readRun(path_); }, pusht::ExitCode::kBadDependency),
              HasSubstr("step 3 is recorded, must be 2"));
}

TEST_F(RunBagTest, ABagThatCannotBeWrittenIsAFault) {
  RunBag bag(path_, play_.origin(), defaultWorldNames(), ros::Time(0.1));
  std::filesystem::create_directory(path_);  // the bag cannot be put there
  bag.writeWorlds(play_.run(3), 0, ros::Time(0.2));
  EXPECT_THAT(refusal([&] { bag.finish(); }, pusht::ExitCode::kRuntimeFault), HasSubstr("compare.bag"));
}

TEST(Messages, DivergenceIsNotANumberWhereARolloutHasEnded) {
  Play play;
  const Episode episode = play.run(5);
  const int reference = episode.rollout(kReferenceClosed).steps();
  const int engine = episode.rollout(kEngineClosed).steps();
  ASSERT_LT(reference, engine) << "for this test to tell";
  const auto last = divergenceMessage(episode, reference, ros::Time(1.0));
  EXPECT_GT(last.replay_position, 0.0);
  EXPECT_GT(last.closed_position, 0.0);
  const auto after = divergenceMessage(episode, reference + 1, ros::Time(1.0));
  EXPECT_TRUE(std::isnan(after.replay_position) && std::isnan(after.replay_angle));
  EXPECT_TRUE(std::isnan(after.closed_position) && std::isnan(after.closed_angle));
  EXPECT_EQ(after.step, static_cast<std::uint32_t>(reference + 1));
}

TEST(Messages, SummaryIsOfTheFinishedEpisodesAndOfNone) {
  Play play;
  const auto none = summaryMessage(play.configuration(), std::nullopt, ros::Time(1.0));
  EXPECT_EQ(none.episodes, 3U);
  EXPECT_EQ(none.episodes_finished, 0U);
  EXPECT_EQ(none.reference.trials, 0U);
  EXPECT_TRUE(std::isnan(none.reference.rate) && std::isnan(none.transfer) && std::isnan(none.means.back().value));
  EXPECT_EQ(none.verdict, "cannot_say");
  EXPECT_EQ(none.headline, "Does the skill transfer? Cannot say yet: no episode has finished; it takes 10 or more.");
  const auto one = summaryMessage(play.configuration(),
                                  summarize(play.configuration().protocol, {play.run(5).result()}), ros::Time(1.0));
  EXPECT_EQ(one.episodes_finished, 1U);
  EXPECT_EQ(one.reference.successes, 1U);
  EXPECT_EQ(one.policy, "expert");
  EXPECT_EQ(one.headline, "Does the skill transfer? Cannot say yet: 1 episode can say nothing; it takes 10 or more.");
  EXPECT_FALSE(std::isnan(one.means.front().value));
  EXPECT_TRUE(std::isnan(one.means.front().low)) << "one episode has no interval";
}

}  // namespace
}  // namespace sim2sim
