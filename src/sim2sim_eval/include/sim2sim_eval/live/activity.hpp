// SPDX-License-Identifier: BSD-3-Clause
/// What the evaluator is doing, for all of its threads and for whoever watches.
#pragma once

#include <pusht_msgs/Progress.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "pusht_task/ros/health.hpp"
#include "sim2sim_eval/live/pacer.hpp"

namespace sim2sim {

/// State of the evaluator, told on the latched topic `progress` whenever it changes, and in the diagnostics. Any thread
/// may call any function.
class Activity {
 public:
  /// Advertises `progress` in the namespace of `node`. `tell(paused)` is called with each message. `pacer` must outlive
  /// this.
  Activity(ros::NodeHandle& node, const Pacer& pacer, std::function<void(bool)> on_publish);

  /// A run is asked for: the evaluator is busy until end(). Tells nothing yet.
  void markRequested();
  /// The nodes of a run are waited for; `services` is the namespace of the one that is missing, empty: the wait is
  /// over.
  void waitFor(const std::string& services);
  /// The run's folder is taken: it is no longer the run before that is told of.
  void begin(int episodes);
  /// An episode has finished. `progress` is for people: "7 of 50 episodes"; `seconds_left` of the run [s].
  void finishEpisode(const std::string& progress, double seconds_left);
  /// The run has ended; `failure` is why it did so early, empty: it did not. Returns whether it was cancelled.
  bool end(const std::string& failure);

  /// Asks the run that is under way to end; false: there is none.
  bool cancel();

  bool busy() const;
  bool cancelled() const;

  /// Publishes the state. Must not be called by the pacer, which then holds a lock that this needs.
  void publish();
  void report(pusht::DiagnosticStatusWrapper& status) const;

 private:
  const Pacer& pacer_;
  const std::function<void(bool)> on_publish_;
  std::mutex publishing_;  // so that the last message is the newest
  ros::Publisher progress_;

  mutable std::mutex mutex_;  // of what follows
  bool busy_ = false;
  bool cancelled_ = false;
  std::string failure_;  // of the last run; empty: none, or one is under way
  std::string activity_ = "idle";
  int episodes_ = 0;  // of the run under way, or of the last one
  int episodes_finished_ = 0;
  std::uint32_t runs_ = 0;              // that have begun
  std::string waiting_for_;             // as in Progress
  std::optional<double> seconds_left_;  // of the run under way
};

}  // namespace sim2sim
