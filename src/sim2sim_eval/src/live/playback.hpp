// SPDX-License-Identifier: BSD-3-Clause
/// Playback of a recorded run, shown as if it were live.
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <pusht_msgs/CompareGoal.h>
#include <pusht_msgs/Control.h>
#include <pusht_msgs/Progress.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/service_server.h>
#include <ros/steady_timer.h>
#include <tf2_ros/transform_broadcaster.h>

#include <array>
#include <atomic>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "bag/recorded_run.hpp"
#include "live/broadcast.hpp"
#include "live/pacer.hpp"
#include "live/serve_playback.hpp"
#include "pusht_task/error.hpp"
#include "sim2sim_serving/node_parameters.hpp"

namespace sim2sim {

/// Private parameters of `replay_node`.
struct PlaybackParameters {
  std::string bag;               ///< compare.bag of a run
  std::optional<int> episode{};  ///< index of the first episode to show; none: the bag's first
  double start = 0.0;            ///< [s] into that episode
  double speed = 1.0;            ///< factor on real time; 0: as fast as possible

  /// Reads all parameters. Throws InvalidInput with key, value and rule.
  static PlaybackParameters load(pusht::ParameterReader& parameters);
};

/// Player of the finished episodes of a bag, without any simulator. It offers the topics and services of Evaluator in
/// the same namespace, without the action, and the command `seek`. TF prefixes of the worlds are `reference`, `engine`
/// and `engine_replay`. Playback begins with the first subscriber and pauses at the end; `resume` starts it again from
/// the first episode.
class Playback {
 public:
  /// Reads the whole bag. Throws as readRun(); InvalidInput if it has no finished episode, or not the requested one.
  Playback(const ros::NodeHandle& node, const PlaybackParameters& parameters);

  /// Plays until the node ends. Callbacks must be served in another thread.
  void run();

 private:
  struct PlaybackPosition {
    int episode;  ///< index
    int step;     ///< control step, from 0
  };

  bool onControl(pusht_msgs::ControlRequest& request, pusht_msgs::ControlResponse& response);
  PlaybackPosition positionOf(const pusht_msgs::ControlRequest& request) const;
  void seek(const PlaybackPosition& position);
  void publishProgress();
  bool ended() const;
  bool sought() const;
  std::optional<PlaybackPosition> takeSought();
  void waitForAudience() const;
  void advance();
  void show(const PlaybackPosition& position);
  void republish();

  // Set once.
  ros::NodeHandle node_;
  std::map<int, Episode> episodes_;  // finished episodes by index
  RecordedRun run_;                  // declared after episodes_, which reading it fills
  std::array<std::string, kModeCount> frame_prefixes_;

  // Used in the thread of run() alone.
  std::optional<Episode> shown_;
  ros::Time stamp_;

  Pacer pacer_;
  std::atomic<bool> at_end_{false};  // paused after the last step of the last episode
  Broadcast broadcast_;
  tf2_ros::TransformBroadcaster frames_;

  mutable std::mutex mutex_;  // guards the next two
  std::optional<PlaybackPosition> sought_;
  std::vector<geometry_msgs::TransformStamped> moving_;  // frames that were sent last

  std::mutex publishing_;  // held while publishing, so that the last message is the newest
  ros::Publisher progress_;
  ros::Publisher request_;
  ros::Publisher nodes_;
  ros::ServiceServer control_;
  // Declared last, because their callbacks use the members above.
  ros::SteadyTimer repeating_;
  ros::SteadyTimer heart_;  // publishes that the player is there
};

}  // namespace sim2sim
