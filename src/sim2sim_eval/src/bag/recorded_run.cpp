// SPDX-License-Identifier: BSD-3-Clause
#include "bag/recorded_run.hpp"

#include <pusht_msgs/EpisodeResult.h>
#include <pusht_msgs/Trace.h>
#include <pusht_msgs/WorldStateStamped.h>
#include <ros/serialization.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <std_msgs/String.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bag/messages.hpp"
#include "bag/run_bag.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/json_text.hpp"
#include "sim2sim_serving/bag_file.hpp"
#include "sim2sim_serving/conversions.hpp"

namespace sim2sim {
namespace {

namespace fs = std::filesystem;

/// Gathers rollouts from messages, and computes the results of each episode that has finished.
class Reader {
 public:
  Reader(Protocol protocol, std::function<void(Episode&&)> each)
      : protocol_(std::move(protocol)), each_(std::move(each)), bands_(protocol_) {}

  /// Messages with later stamps follow.
  void moveOnTo(const ros::Time& stamp) {
    if (finished_ && finished_->header.stamp < stamp) {
      settle();
    }
  }

  void take(Mode mode, const pusht_msgs::WorldStateStamped& message) {
    pusht::Trace& trace = under_way_[indexOf(message.episode)].modes.at(mode);
    if (message.step == 0) {  // perhaps once more: an episode in which a node is lost is begun anew
      trace = {};
    } else if (message.step != trace.states.size()) {
      throw pusht::BadDependency("episode " + std::to_string(message.episode) + ", " + modeName(mode) + ": step " +
                                 std::to_string(message.step) + " is recorded, must be " +
                                 std::to_string(trace.states.size()));
    } else {
      trace.actions.push_back({message.action[0], message.action[1]});
    }
    trace.states.push_back(pusht::fromMessage(message.state));
  }

  void take(const pusht_msgs::Trace& message) {
    const std::vector<Probe> probes = protocol_.probes();
    const auto probe =
        std::find_if(probes.begin(), probes.end(), [&](const Probe& known) { return known.name == message.mode; });
    if (probe == probes.end()) {
      throw pusht::BadDependency("episode " + std::to_string(message.episode) + ": mode " + message.mode +
                                 " is recorded, but is not one of the run");
    }
    RecordedEpisode& episode = under_way_[indexOf(message.episode)];
    episode.probes.resize(probes.size());
    std::vector<pusht::WorldState>& states = episode.probes[static_cast<std::size_t>(probe - probes.begin())];
    states.clear();
    std::transform(message.states.begin(), message.states.end(), std::back_inserter(states),
                   [](const pusht_msgs::WorldState& state) { return pusht::fromMessage(state); });
  }

  /// The last states of the episode may come later: they have the same stamp.
  void take(const pusht_msgs::EpisodeResult& message) {
    settle();
    finished_ = message;
  }

  /// Bands over the episodes of results().
  const DivergenceBands& bands() const { return bands_; }

  /// Results of the finished episodes by index.
  std::vector<EpisodeResult> results() {
    settle();
    std::vector<EpisodeResult> results;
    for (const auto& [index, result] : results_) {
      results.push_back(result);
    }
    return results;
  }

 private:
  int indexOf(std::uint64_t episode) const {
    if (episode < static_cast<std::uint64_t>(protocol_.first_episode) ||
        episode > static_cast<std::uint64_t>(protocol_.lastEpisode())) {
      throw pusht::BadDependency("episode " + std::to_string(episode) + ": must be from " +
                                 std::to_string(protocol_.first_episode) + " to " +
                                 std::to_string(protocol_.lastEpisode()));
    }
    return static_cast<int>(episode);
  }

  void settle() {
    if (!finished_) {
      return;
    }
    const pusht_msgs::EpisodeResult recorded = *std::exchange(finished_, std::nullopt);
    const int index = indexOf(recorded.episode);
    Episode episode = rebuildEpisode(protocol_, index, under_way_[index]);
    const EpisodeResult result = episode.result();
    under_way_.erase(index);
    pusht_msgs::EpisodeResult computed = toMessage(protocol_, result, recorded.header.stamp);
    computed.header = recorded.header;
    if (bytesOf(computed) != bytesOf(recorded)) {
      throw pusht::BadDependency("episode " + std::to_string(index) +
                                 ": its result does not follow from the recorded states");
    }
    if (!results_.emplace(index, result).second) {
      throw pusht::BadDependency("episode " + std::to_string(index) + ": must finish once");
    }
    bands_.add(episode);
    each_(std::move(episode));
  }

  /// Equal for equal messages, with or without numbers that are not one.
  static std::string bytesOf(const pusht_msgs::EpisodeResult& message) {
    const ros::SerializedMessage bytes = ros::serialization::serializeMessage(message);
    return std::string(bytes.buf.get(), bytes.buf.get() + bytes.num_bytes);
  }

  Protocol protocol_;
  std::function<void(Episode&&)> each_;
  DivergenceBands bands_;
  std::map<int, RecordedEpisode> under_way_;
  std::optional<pusht_msgs::EpisodeResult> finished_;  // waits for its last states
  std::map<int, EpisodeResult> results_;
};

/// Message of a run.
struct Recorded {
  ros::Time stamp;
  std::function<void(Reader&)> take;
};

/// Reads a message of the bag. A recorder that subscribes has its own times and, across topics, its own order; stamps
/// give the true one. Within a stamp the order does not count: the reader waits for the last of them.
Recorded recordedIn(const rosbag::MessageInstance& instance, const std::map<std::string, Mode>& modes) {
  const auto recorded = [](auto message, const auto& take) {
    return Recorded{message.header.stamp,
                    [message = std::move(message), take](Reader& reader) { take(reader, message); }};
  };
  const auto plainly = [](Reader& reader, const auto& message) { reader.take(message); };
  const auto world = modes.find(instance.getTopic());
  if (world != modes.end()) {
    return recorded(pusht::messageIn<pusht_msgs::WorldStateStamped>(instance),
                    [mode = world->second](Reader& reader, const auto& message) { reader.take(mode, message); });
  }
  if (instance.getTopic() == kTraceTopic) {
    return recorded(pusht::messageIn<pusht_msgs::Trace>(instance), plainly);
  }
  return recorded(pusht::messageIn<pusht_msgs::EpisodeResult>(instance), plainly);
}

/// Description of the bag's run; of the last run if a plain recorder has recorded several.
nlohmann::ordered_json descriptionIn(const rosbag::Bag& bag) {
  rosbag::View view(bag, rosbag::TopicQuery(kConfigurationTopic));
  if (view.size() == 0) {
    throw pusht::InvalidInput(std::string("holds 0 messages on ") + kConfigurationTopic +
                              ", must be 1: the bag of one run");
  }
  const std::string text = pusht::messageIn<std_msgs::String>(*std::next(view.begin(), view.size() - 1)).data;
  nlohmann::ordered_json description = pusht::parseOrderedJson(text);
  if (!description.is_object()) {
    throw pusht::InvalidInput(std::string("its last message on ") + kConfigurationTopic + " must hold a JSON object");
  }
  return description;
}

/// Takes the initial states from the bag, if they were given to the run. `protocol` has their hash.
void takeStarts(Protocol& protocol, const nlohmann::ordered_json& provenance) {
  if (!protocol.initial_states) {
    return;
  }
  const std::string hash = protocol.initial_states->hash();
  protocol.initial_states = std::make_shared<InitialStates>(initialStatesFrom(
      provenance.at("starts").get<std::string>(), protocol.firstStart(), protocol.starts(), protocol.runTask()));
  if (protocol.initial_states->hash() != hash) {
    throw pusht::BadDependency("its starts are " + protocol.initial_states->hash() + ", must be " + hash);
  }
}

RecordedRun runIn(const rosbag::Bag& bag, const std::function<bool()>& stop,
                  const std::function<void(Episode&&)>& each) {
  nlohmann::ordered_json provenance = descriptionIn(bag);
  RunConfiguration configuration = configurationFrom(provenance.at("configuration"));
  takeStarts(configuration.protocol, provenance);
  std::map<std::string, Mode> modes;
  for (const Mode mode : kModes) {
    modes.emplace(provenance.at("state_topics").at(modeName(mode)).get<std::string>(), mode);
  }
  provenance.erase("state_topics");
  const ros::Time begin = ros::Time().fromNSec(provenance.value("begin_stamp", std::uint64_t{0}));
  provenance.erase("begin_stamp");

  Reader reader(configuration.protocol, each);
  const auto read = [&](const Recorded& recorded) {
    if (stop()) {
      throw pusht::RuntimeFault("interrupted while it was read");
    }
    reader.moveOnTo(recorded.stamp);
    recorded.take(reader);
  };
  std::vector<std::string> topics = {kEpisodeTopic, kTraceTopic};
  for (const auto& [topic, mode] : modes) {
    topics.push_back(topic);
  }
  rosbag::View view(bag, rosbag::TopicQuery(topics));
  std::vector<Recorded> plain;  // of a bag that a plain recorder has made
  for (const rosbag::MessageInstance& instance : view) {
    Recorded recorded = recordedIn(instance, modes);
    if (recorded.stamp < begin) {
      continue;  // of what was before the run
    }
    if (plain.empty() && recorded.stamp == instance.getTime()) {
      read(recorded);
    } else {
      plain.push_back(std::move(recorded));
    }
  }
  std::stable_sort(plain.begin(), plain.end(), [](const Recorded& a, const Recorded& b) { return a.stamp < b.stamp; });
  std::for_each(plain.begin(), plain.end(), read);
  std::vector<EpisodeResult> episodes = reader.results();
  return {std::move(configuration), std::move(provenance), reader.bands(), std::move(episodes)};
}

}  // namespace

RecordedRun readRun(const fs::path& path, const std::function<bool()>& stop,
                    const std::function<void(Episode&&)>& each) {
  std::optional<RecordedRun> run;
  pusht::readBag(path, [&](const rosbag::Bag& bag) {
    try {
      run = runIn(bag, stop, each);
    } catch (const nlohmann::json::exception& error) {
      throw pusht::InvalidInput(std::string(kConfigurationTopic) + ": " + error.what());
    }
  });
  return std::move(*run);
}

}  // namespace sim2sim
