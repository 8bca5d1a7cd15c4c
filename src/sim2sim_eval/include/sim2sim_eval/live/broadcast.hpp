// SPDX-License-Identifier: BSD-3-Clause
/// What the evaluator says of a run while it goes on: its topics, and the bag.
#pragma once

#include <pusht_msgs/Divergence.h>
#include <pusht_msgs/EpisodeResult.h>
#include <pusht_msgs/Episodes.h>
#include <pusht_msgs/Summary.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/service_server.h>
#include <ros/steady_timer.h>
#include <std_msgs/String.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <visualization_msgs/MarkerArray.h>

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim2sim_eval/bag/run_bag.hpp"
#include "sim2sim_eval/live/picture.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/results/summary.hpp"

namespace sim2sim {

/// Topics in the node's private namespace: `configuration` (latched), `divergence` (every control step; latched),
/// `trace`, `episode`, `summary` (latched) and `markers`, which come again once a second, for late subscribers; the
/// service `episodes`, of what they have missed; the static frames of the tables.
class Broadcast {
 public:
  explicit Broadcast(const ros::NodeHandle& node);

  /// A run begins, and is drawn as `picture`. `bag` may be null: the run is not recorded.
  void begin(const RunConfiguration& configuration, Picture picture, std::unique_ptr<RunBag> bag,
             const ros::Time& stamp);

  /// What a recorder of all topics needs to make the bag of this run; see configurationMessage().
  void publishConfiguration(const std_msgs::String& configuration) const {
    configuration_topic_.publish(configuration);
  }

  /// Episodes that have finished before, as those of a replay; `finished` is of them, and `last` the one that ended the
  /// run, if one did.
  void restore(const std::vector<EpisodeResult>& results, const Summary& finished, std::optional<int> last,
               const ros::Time& stamp);

  /// Shows in the picture what the run does: that it waits, and for what, or why it has ended. From any thread. While
  /// the run goes on, the picture shows its episode and time instead of `words`.
  void showState(RunState state, const std::string& words);

  /// Whether a run that goes on is paused. From any thread.
  void showPaused(bool paused);

  /// Whether markers or divergence have a subscriber.
  bool watched() const { return markers_.getNumSubscribers() + divergence_.getNumSubscribers() > 0; }

  /// The start of an episode, or a control step. `paced`: at a rate that eyes can follow. After a leap within an
  /// episode the divergence of the steps before is told, too, unless it was foretold: a curve is whole.
  pusht_msgs::Divergence step(const Episode& episode, const ros::Time& stamp, bool paced);

  /// The divergence of a whole episode of a replay, before its first step is shown.
  void publishWholeCurve(const Episode& whole, const ros::Time& stamp);

  /// An episode has finished; `finished` are all that have, by index. `last`: the run needs no more.
  void finish(const Episode& episode, const EpisodeResult& result, const Summary& finished, bool last,
              const ros::Time& stamp);

  /// The episode was left before its end: the picture becomes that of the control step that was told last.
  void redrawLastStep(const Episode& episode);

  /// The run has ended, well or not: the bag is put in its place. Throws RuntimeFault if that fails.
  void end();

  /// The last one that was published.
  const pusht_msgs::Summary& summary() const { return summary_; }

 private:
  bool onEpisodes(pusht_msgs::EpisodesRequest& request, pusht_msgs::EpisodesResponse& response);
  void appendToCurve(const pusht_msgs::Divergence& divergence);
  void draw(const Episode& episode, const ros::Time& stamp, bool recorded);
  void drawState();
  void republish() const;

  ros::NodeHandle node_;
  ros::Publisher configuration_topic_;
  ros::Publisher divergence_;
  ros::Publisher trace_;
  ros::Publisher episode_;
  ros::Publisher summary_topic_;

  RunConfiguration configuration_;
  std::unique_ptr<RunBag> bag_;
  pusht_msgs::Summary summary_;
  std::optional<Summary> finished_;
  std::optional<int> last_;        // episode, once it is known
  std::pair<int, int> published_;  // episode and step
  std::pair<int, int> drawn_;      // the same
  ros::Time stamp_;                // of what was told last

  tf2_ros::StaticTransformBroadcaster fixed_frames_;
  std::optional<Picture> picture_;
  ros::Publisher markers_;

  mutable std::mutex mutex_;  // of what is told from another thread
  visualization_msgs::MarkerArray scene_;
  visualization_msgs::MarkerArray update_;
  visualization_msgs::MarkerArray state_markers_;
  RunState state_ = RunState::kWaits;
  bool paused_ = false;
  std::string words_;                                // of the state
  std::string caption_;                              // in the run, in words
  std::vector<pusht_msgs::EpisodeResult> episodes_;  // as they finished
  std::vector<pusht_msgs::Divergence> curve_;        // of the episode that is shown
  bool curve_is_whole_ = false;                      // the curve is that of the whole episode

  // Last: they use what stands above.
  ros::ServiceServer episodes_service_;
  ros::SteadyTimer repeating_;
};

}  // namespace sim2sim
