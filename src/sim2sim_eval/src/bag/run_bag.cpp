// SPDX-License-Identifier: BSD-3-Clause
#include "bag/run_bag.hpp"

#include <pusht_msgs/WorldStateStamped.h>
#include <std_msgs/String.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "bag/messages.hpp"
#include "pusht_task/error.hpp"
#include "sim2sim_serving/conversions.hpp"
#include "sim2sim_serving/transforms.hpp"

namespace sim2sim {
namespace {

/// A world after a control step, and the action that led there.
struct WorldMoment {
  pusht::WorldState state;
  pusht::Action action;
};

std::optional<WorldMoment> momentOf(const pusht::Trace& trace, int step) {
  const auto k = static_cast<std::size_t>(step);
  if (k >= trace.states.size()) {
    return std::nullopt;
  }
  return WorldMoment{trace.states[k], k == 0 ? pusht::Action{} : trace.actions[k - 1]};
}

pusht_msgs::WorldStateStamped toMessage(const WorldMoment& moment, int episode, int step, const ros::Time& stamp,
                                        const std::string& frame_prefix) {
  pusht_msgs::WorldStateStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = frame_prefix + "/table";
  message.episode = static_cast<std::uint64_t>(episode);
  message.step = static_cast<std::uint32_t>(step);
  message.action = {moment.action[0], moment.action[1]};
  message.state = pusht::toMessage(moment.state);
  return message;
}

}  // namespace

const WorldNames& defaultWorldNames() {
  static const WorldNames names = {WorldName{"/reference/state", "reference"}, WorldName{"/engine/state", "engine"},
                                   WorldName{"/engine_replay/state", "engine_replay"}};
  return names;
}

std_msgs::String configurationMessage(const nlohmann::ordered_json& provenance, const WorldNames& worlds,
                                      const ros::Time& stamp) {
  nlohmann::ordered_json run = provenance;
  run["begin_stamp"] = stamp.toNSec();
  for (const Mode mode : kModes) {
    run["state_topics"][modeName(mode)] = worlds[mode].state_topic;
  }
  std_msgs::String message;
  message.data = run.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  return message;
}

std::vector<pusht_msgs::Trace> traceMessages(const Protocol& protocol, const Episode& episode, const ros::Time& stamp) {
  std::vector<pusht_msgs::Trace> messages;
  const std::vector<Probe> probes = protocol.probes();
  for (std::size_t i = 0; i < probes.size(); ++i) {
    messages.push_back(toMessage(probes[i].name, episode.index(), *episode.probe(i), stamp));
  }
  return messages;
}

RunBag::RunBag(const std::filesystem::path& path, const nlohmann::ordered_json& provenance, WorldNames worlds,
               const ros::Time& stamp)
    : worlds_(std::move(worlds)), file_(path) {
  file_.writeLatched(kConfigurationTopic, std::max(stamp, ros::TIME_MIN),
                     configurationMessage(provenance, worlds_, stamp));
}

RunBag::~RunBag() {
  try {
    finish();
  } catch (const std::exception&) {
    // The bag is lost; a caller that needs to know calls finish().
  }
}

void RunBag::writeWorlds(const Episode& episode, int step, const ros::Time& stamp) {
  std::array<std::optional<WorldMoment>, kModeCount> moments;
  for (const Mode mode : kModes) {
    moments[mode] = momentOf(episode.rollout(mode).trace(), step);
  }
  queue_.post([this, moments, episode = episode.index(), step, stamp] {
    tf2_msgs::TFMessage frames;
    for (const Mode mode : kModes) {
      if (moments[mode]) {
        const WorldName& world = worlds_[mode];
        file_.write(world.state_topic, stamp, toMessage(*moments[mode], episode, step, stamp, world.frame_prefix));
        auto transforms = pusht::movingFrames(world.frame_prefix, moments[mode]->state, stamp);
        std::move(transforms.begin(), transforms.end(), std::back_inserter(frames.transforms));
      }
    }
    file_.write(kTfTopic, stamp, frames);
  });
}

void RunBag::write(const tf2_msgs::TFMessage& fixed_frames, const ros::Time& stamp) {
  queue_.post([this, fixed_frames, stamp] { file_.writeLatched(kFixedTfTopic, stamp, fixed_frames); });
}

void RunBag::writeProbes(const Protocol& protocol, const Episode& episode, const ros::Time& stamp) {
  for (const pusht_msgs::Trace& message : traceMessages(protocol, episode, stamp)) {
    write(message);
  }
}

void RunBag::write(const pusht_msgs::Trace& message) {
  queue_.post([this, message] { file_.write(kTraceTopic, message.header.stamp, message); });
}

void RunBag::write(const pusht_msgs::Divergence& message) {
  queue_.post([this, message] { file_.write(kDivergenceTopic, message.header.stamp, message); });
}

void RunBag::write(const pusht_msgs::EpisodeResult& message) {
  queue_.post([this, message] { file_.write(kEpisodeTopic, message.header.stamp, message); });
}

void RunBag::write(const pusht_msgs::Summary& message) {
  queue_.post([this, message] { file_.writeLatched(kSummaryTopic, message.header.stamp, message); });
}

void RunBag::write(const visualization_msgs::MarkerArray& message, const ros::Time& stamp) {
  queue_.post([this, message, stamp] { file_.write(kMarkersTopic, stamp, message); });
}

void RunBag::finish() {
  queue_.wait();
  if (!std::exchange(finished_, true)) {
    file_.finish();
  }
}

}  // namespace sim2sim
