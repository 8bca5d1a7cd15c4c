// SPDX-License-Identifier: BSD-3-Clause
/// A run as a bag: what was sent and received, with the configuration; enough to compute its results again.
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

#include "pusht_task/ros/bag_file.hpp"
#include "sim2sim_eval/bag/background_queue.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"

namespace sim2sim {

constexpr const char* kConfigurationTopic = "/sim2sim/configuration";  ///< std_msgs/String: JSON; latched
constexpr const char* kDivergenceTopic = "/sim2sim/divergence";        ///< pusht_msgs/Divergence
constexpr const char* kEpisodeTopic = "/sim2sim/episode";              ///< pusht_msgs/EpisodeResult
constexpr const char* kTraceTopic = "/sim2sim/trace";                  ///< pusht_msgs/Trace: the probes
constexpr const char* kSummaryTopic = "/sim2sim/summary";              ///< pusht_msgs/Summary; latched
constexpr const char* kMarkersTopic = "/sim2sim/markers";              ///< visualization_msgs/MarkerArray
constexpr const char* kTfTopic = "/tf";                                ///< tf2_msgs/TFMessage: the worlds' frames
constexpr const char* kFixedTfTopic = "/tf_static";                    ///< tf2_msgs/TFMessage: those that never move

/// How a world appears in a bag.
struct WorldName {
  std::string state_topic;   ///< pusht_msgs/WorldStateStamped
  std::string frame_prefix;  ///< of its TF frames
};

/// The worlds by mode; the names are those of compare.launch.
using WorldNames = std::array<WorldName, kModeCount>;
const WorldNames& defaultWorldNames();

/// What kConfigurationTopic holds: `provenance` as in provenance.json, configuration included, the state topics, and a
/// stamp [ns] that none of the run's messages is below.
std_msgs::String configurationMessage(const nlohmann::ordered_json& provenance, const WorldNames& worlds,
                                      const ros::Time& stamp);

/// What kTraceTopic holds of an episode that has finished: a message for each probe.
std::vector<pusht_msgs::Trace> traceMessages(const Protocol& protocol, const Episode& episode, const ros::Time& stamp);

/// Writes a run step by step, in a thread of its own, at the times of the stamps, which must not decrease. What was
/// written stays, whatever ends the run. Every function throws RuntimeFault if the bag cannot be written.
class RunBag {
 public:
  /// `provenance` is that of provenance.json, configuration included. Throws InvalidInput if there is something at
  /// `path` already.
  RunBag(const std::filesystem::path& path, const nlohmann::ordered_json& provenance, WorldNames worlds,
         const ros::Time& stamp);
  RunBag(const RunBag&) = delete;
  RunBag& operator=(const RunBag&) = delete;
  ~RunBag();

  /// What the worlds said and where their frames were after `step` control steps.
  void writeWorlds(const Episode& episode, int step, const ros::Time& stamp);

  void write(const tf2_msgs::TFMessage& fixed_frames, const ros::Time& stamp);
  /// The probes of an episode that has finished.
  void writeProbes(const Protocol& protocol, const Episode& episode, const ros::Time& stamp);

  void write(const pusht_msgs::Trace& message);
  void write(const pusht_msgs::Divergence& message);
  void write(const pusht_msgs::EpisodeResult& message);
  void write(const pusht_msgs::Summary& message);
  void write(const visualization_msgs::MarkerArray& message, const ros::Time& stamp);

  /// Waits until everything is written; the bag is then at its path.
  void finish();

 private:
  const WorldNames worlds_;
  pusht::BagFile file_;  // of the worker
  BackgroundQueue worker_;
  bool finished_ = false;
};

}  // namespace sim2sim
