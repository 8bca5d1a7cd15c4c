// SPDX-License-Identifier: BSD-3-Clause
/// Bag of a run: its messages and its configuration, from which all results can be computed again.
#pragma once

#include <pusht_msgs/Divergence.h>
#include <pusht_msgs/EpisodeResult.h>
#include <pusht_msgs/Summary.h>
#include <pusht_msgs/Trace.h>
#include <ros/time.h>
#include <std_msgs/String.h>
#include <tf2_msgs/TFMessage.h>
#include <visualization_msgs/MarkerArray.h>

#include <array>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bag/background_queue.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_serving/bag_file.hpp"

namespace sim2sim {

constexpr const char* kConfigurationTopic = "/sim2sim/configuration";  ///< std_msgs/String: JSON; latched
constexpr const char* kDivergenceTopic = "/sim2sim/divergence";        ///< pusht_msgs/Divergence
constexpr const char* kEpisodeTopic = "/sim2sim/episode";              ///< pusht_msgs/EpisodeResult
constexpr const char* kTraceTopic = "/sim2sim/trace";                  ///< pusht_msgs/Trace: the probes
constexpr const char* kSummaryTopic = "/sim2sim/summary";              ///< pusht_msgs/Summary; latched
constexpr const char* kMarkersTopic = "/sim2sim/markers";              ///< visualization_msgs/MarkerArray
constexpr const char* kTfTopic = "/tf";                                ///< tf2_msgs/TFMessage: the worlds' frames
constexpr const char* kFixedTfTopic = "/tf_static";                    ///< tf2_msgs/TFMessage: those that never move

/// Topic and frames of a world in a bag.
struct WorldName {
  std::string state_topic;   ///< pusht_msgs/WorldStateStamped
  std::string frame_prefix;  ///< prefix of its TF frames: "engine" for "engine/table"
};

/// Worlds by mode.
using WorldNames = std::array<WorldName, kModeCount>;

/// Names that compare.launch gives to the worlds.
const WorldNames& defaultWorldNames();

/// Message on kConfigurationTopic, as JSON: `provenance` as in provenance.json, with the configuration; the state topic
/// of each world; and `stamp` [ns], a lower bound of the stamps of the run's messages.
std_msgs::String configurationMessage(const nlohmann::ordered_json& provenance, const WorldNames& worlds,
                                      const ros::Time& stamp);

/// Messages on kTraceTopic for a finished episode, one for each probe.
std::vector<pusht_msgs::Trace> traceMessages(const Protocol& protocol, const Episode& episode, const ros::Time& stamp);

/// Writer of a run's bag. Messages are written in a thread of their own (BackgroundQueue), at the times of their
/// stamps, which must not decrease. Written messages stay in the bag when the run fails. Every function throws
/// RuntimeFault if the bag cannot be written, also for a message of an earlier call.
class RunBag {
 public:
  /// Begins the bag with configurationMessage(). Throws InvalidInput if there is something at `path`.
  RunBag(const std::filesystem::path& path, const nlohmann::ordered_json& provenance, WorldNames worlds,
         const ros::Time& stamp);
  RunBag(const RunBag&) = delete;
  RunBag& operator=(const RunBag&) = delete;
  ~RunBag();

  /// State, action and moving TF frames of each world that has come to `step` control steps.
  void writeWorlds(const Episode& episode, int step, const ros::Time& stamp);

  /// Static TF frames; latched.
  void write(const tf2_msgs::TFMessage& fixed_frames, const ros::Time& stamp);

  /// Probes of a finished episode.
  void writeProbes(const Protocol& protocol, const Episode& episode, const ros::Time& stamp);

  void write(const pusht_msgs::Trace& message);
  void write(const pusht_msgs::Divergence& message);
  void write(const pusht_msgs::EpisodeResult& message);
  void write(const pusht_msgs::Summary& message);
  void write(const visualization_msgs::MarkerArray& message, const ros::Time& stamp);

  /// Waits until everything is written, and moves the bag to its path.
  void finish();

 private:
  const WorldNames worlds_;
  pusht::BagFile file_;  // used by tasks of the queue alone
  BackgroundQueue queue_;
  bool finished_ = false;
};

}  // namespace sim2sim
