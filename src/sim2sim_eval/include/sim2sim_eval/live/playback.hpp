// SPDX-License-Identifier: BSD-3-Clause
/// A recorded run, shown as if it were live.
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

#include "pusht_task/error.hpp"
#include "pusht_task/ros/parameters.hpp"
#include "sim2sim_eval/bag/recorded_run.hpp"
#include "sim2sim_eval/live/broadcast.hpp"
#include "sim2sim_eval/live/pacer.hpp"

namespace sim2sim {

struct PlaybackParameters {
  std::string bag;
  std::optional<int> episode{};  ///< to begin with; none: the first one of the bag
  double start = 0.0;            ///< [s] into that episode
  double speed = 1.0;            ///< times real time; 0: as fast as possible

  /// Throws InvalidInput with key, value and rule.
  static PlaybackParameters load(pusht::ParameterReader& parameters);
};

/// Plays the finished episodes of a bag one after the other, without any simulator. Offers what Evaluator does, in the
/// same namespace, but for the action; and the command `seek`. The frames of the worlds are `reference`, `engine` and
/// `engine_replay`. It begins when somebody looks, and pauses at the end; resumed there, it begins again.
class Playback {
 public:
  /// Throws as readRun(); InvalidInput if the bag has no finished episode, or not that one.
  Playback(const ros::NodeHandle& node, const PlaybackParameters& parameters);

  /// Plays until the node ends. Callbacks must be served in another thread.
  void run();

 private:
  struct PlaybackPosition {
    int episode;
    int step;
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
  std::map<int, Episode> episodes_;  // the finished ones, whole, by index
  RecordedRun run_;                  // after them: reading it fills them
  std::array<std::string, kModeCount> frame_prefixes_;

  // Used in the thread of run() alone.
  std::optional<Episode> shown_;
  ros::Time stamp_;

  Pacer pacer_;
  std::atomic<bool> at_end_{false};  // paused after the last step of the last episode
  Broadcast broadcast_;
  tf2_ros::TransformBroadcaster frames_;

  mutable std::mutex mutex_;  // of what follows
  std::optional<PlaybackPosition> sought_;
  std::vector<geometry_msgs::TransformStamped> moving_;  // as sent last

  std::mutex publishing_;  // so that the last message is the newest
  ros::Publisher progress_;
  ros::Publisher request_;
  ros::ServiceServer control_;
  ros::SteadyTimer repeating_;  // last
};

/// The body of the replay's node, after catchInterrupts().
pusht::ExitCode servePlayback();

}  // namespace sim2sim
