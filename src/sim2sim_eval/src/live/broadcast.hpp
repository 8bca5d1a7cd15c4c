// SPDX-License-Identifier: BSD-3-Clause
/// Output of a run while it goes on: topics, picture, TF frames and the bag.
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

#include "bag/run_bag.hpp"
#include "live/picture.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/results/summary.hpp"

namespace sim2sim {

/// Publisher of a run, live or played back. Topics in the node's private namespace: `configuration` (latched),
/// `divergence` (each control step; latched), `trace`, `episode`, `summary` (latched), `markers` (repeated once a
/// second for late subscribers). Service `episodes`: results so far, for late subscribers. TF: static frames of the
/// tables.
///
/// showState() and showPaused() may be called from any thread, all others from the thread of the run.
class Broadcast {
 public:
  explicit Broadcast(const ros::NodeHandle& node);

  /// Begins a run that is drawn by `picture`. A null `bag` records nothing.
  void begin(const RunConfiguration& configuration, Picture picture, std::unique_ptr<RunBag> bag,
             const ros::Time& stamp);

  /// Publishes configurationMessage(), with which a recording of all topics can be recomputed.
  void publishConfiguration(const std_msgs::String& configuration) const {
    configuration_topic_.publish(configuration);
  }

  /// Publishes episodes that finished earlier, as those of a bag. `finished` is their summary; `last` is the index of
  /// the episode that ended the run, none if the run ended early.
  void restore(const std::vector<EpisodeResult>& results, const Summary& finished, std::optional<int> last,
               const ros::Time& stamp);

  /// Shows the state of the run in the picture, with `words`: what it waits for, or why it has ended. In the state
  /// kRuns, episode and time are shown instead of `words`.
  void showState(RunState state, const std::string& words);

  /// Shows in the picture whether the run is paused.
  void showPaused(bool paused);

  /// Whether markers or divergence have a subscriber.
  bool watched() const { return markers_.getNumSubscribers() + divergence_.getNumSubscribers() > 0; }

  /// Publishes the initial state of an episode, or a control step, and returns its divergence. `paced`: the rate is
  /// slow enough for the eye, so each step is drawn; otherwise every tenth. After a jump to a later step the
  /// divergences of the skipped steps are published too, which keeps curves whole, unless publishWholeCurve() has done
  /// so.
  pusht_msgs::Divergence step(const Episode& episode, const ros::Time& stamp, bool paced);

  /// Publishes the divergences of all steps of a recorded episode, before its first step is shown.
  void publishWholeCurve(const Episode& whole, const ros::Time& stamp);

  /// Publishes the result of a finished episode. `finished` is the summary of all finished episodes. `last`: the run
  /// needs no further episode.
  void finish(const Episode& episode, const EpisodeResult& result, const Summary& finished, bool last,
              const ros::Time& stamp);

  /// Draws the last published control step of `episode`, if the picture shows an earlier one. For an episode that is
  /// left before its end.
  void redrawLastStep(const Episode& episode);

  /// Closes the bag and moves it to its path. Throws RuntimeFault if that fails.
  void end();

  /// Summary that was published last.
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
  std::optional<int> last_;        // index of the run's last episode, once it is known
  std::pair<int, int> published_;  // episode and step that were published last
  std::pair<int, int> drawn_;      // episode and step that were drawn last
  ros::Time stamp_;                // stamp of the last published step

  tf2_ros::StaticTransformBroadcaster fixed_frames_;
  std::optional<Picture> picture_;
  ros::Publisher markers_;

  mutable std::mutex mutex_;  // guards the members below
  visualization_msgs::MarkerArray scene_;
  visualization_msgs::MarkerArray update_;
  visualization_msgs::MarkerArray state_markers_;
  RunState state_ = RunState::kWaits;
  bool paused_ = false;
  std::string words_;                                // shown with the state
  std::string caption_;                              // episode and time in words
  std::vector<pusht_msgs::EpisodeResult> episodes_;  // in the order in which they finished
  std::vector<pusht_msgs::Divergence> curve_;        // divergences of the episode that is shown
  bool curve_is_whole_ = false;                      // curve_ is of the whole episode

  // Declared last, because their callbacks use the members above.
  ros::ServiceServer episodes_service_;
  ros::SteadyTimer repeating_;
};

}  // namespace sim2sim
