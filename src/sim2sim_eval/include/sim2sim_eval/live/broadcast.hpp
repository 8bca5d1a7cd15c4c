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
#include <tf2_ros/static_transform_broadcaster.h>
#include <visualization_msgs/MarkerArray.h>

#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "sim2sim_eval/bag/run_bag.hpp"
#include "sim2sim_eval/live/picture.hpp"
#include "sim2sim_eval/results/report.hpp"

namespace sim2sim {

/// Topics in the node's private namespace: `divergence` (every control step; latched), `episode`, `summary` (latched)
/// and `markers`, which come again once a second, for whoever came late or has forgotten; the service `episodes`, of
/// those that have finished; the static frames of the tables.
class Broadcast {
 public:
  explicit Broadcast(const ros::NodeHandle& node);

  /// Forgets the last run, and says so: nothing is known of the next one yet.
  void clear();

  /// A run begins, and is drawn as `picture`. `bag` may be null: the run is not recorded.
  void begin(const RunConfiguration& configuration, Picture picture, std::unique_ptr<RunBag> bag,
             const ros::Time& stamp);

  /// Episodes that have finished before, as those of a replay; `finished` is of them, and `last` the one that ended the
  /// run, if one did.
  void recall(const std::vector<EpisodeResult>& results, const Summary& finished, std::optional<int> last,
              const ros::Time& stamp);

  /// Whether somebody looks at the run.
  bool watched() const { return markers_.getNumSubscribers() + divergence_.getNumSubscribers() > 0; }

  /// The start of an episode, or a control step. `paced`: at a rate that eyes can follow. After a leap within an
  /// episode the divergence of the steps before is told, too: a curve is whole.
  pusht_msgs::Divergence step(const Episode& episode, const ros::Time& stamp, bool paced);

  /// An episode has finished; `finished` are all that have, by index. `last`: the run needs no more.
  void finish(const Episode& episode, const EpisodeResult& result, const Summary& finished, bool last,
              const ros::Time& stamp);

  /// The run has ended, well or not: the bag is put in its place. Throws RuntimeFault if that fails.
  void end();

  /// The last one that was published.
  const pusht_msgs::Summary& summary() const { return summary_; }

 private:
  bool onEpisodes(pusht_msgs::EpisodesRequest& request, pusht_msgs::EpisodesResponse& response);
  void draw(const Episode& episode, const ros::Time& stamp, bool recorded);
  void repeat() const;

  ros::NodeHandle node_;
  ros::Publisher divergence_;
  ros::Publisher episode_;
  ros::Publisher summary_topic_;

  RunConfiguration configuration_;
  std::unique_ptr<RunBag> bag_;
  pusht_msgs::Summary summary_;
  std::optional<Summary> finished_;
  std::optional<int> last_;   // episode, once it is known
  std::pair<int, int> told_;  // episode and step

  tf2_ros::StaticTransformBroadcaster fixed_frames_;
  std::optional<Picture> picture_;
  ros::Publisher markers_;

  mutable std::mutex mutex_;  // of what is told from another thread
  visualization_msgs::MarkerArray scene_;
  visualization_msgs::MarkerArray update_;
  std::vector<pusht_msgs::EpisodeResult> episodes_;  // as they finished

  // Last: they use what stands above.
  ros::ServiceServer tell_episodes_;
  ros::SteadyTimer repeating_;
};

}  // namespace sim2sim
