// SPDX-License-Identifier: BSD-3-Clause
/// State of the evaluator: idle, waiting, running; published for the panel and the diagnostics.
#pragma once

#include <pusht_msgs/Progress.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "live/pacer.hpp"
#include "sim2sim_serving/health.hpp"

namespace sim2sim {

/// State of the evaluator. Each change is published on the latched topic `progress`; report() fills the diagnostics.
/// Any thread may call any function.
class Activity {
 public:
  /// Advertises `progress` in the namespace of `node`. `on_publish(paused)` is called after each message. `pacer` must
  /// outlive this object.
  Activity(ros::NodeHandle& node, const Pacer& pacer, std::function<void(bool)> on_publish);

  /// Marks the evaluator busy until end(), because a run was requested. Publishes nothing.
  void markRequested();
  /// Publishes that a run waits for the node whose services have the namespace `services`; empty: the wait is over.
  void waitFor(const std::string& services);
  /// Publishes that a run of so many episodes begins. From here on, counts and failure are of this run.
  void begin(int episodes);
  /// Counts a finished episode and publishes it. `progress` in words: "7 of 50 episodes". `seconds_left`: estimate of
  /// the time to the end of the run [s].
  void finishEpisode(const std::string& progress, double seconds_left);
  /// Publishes the end of a run; `failure` is the reason of an early end, empty for a whole run. Returns whether the
  /// run was cancelled.
  bool end(const std::string& failure);

  /// Asks the run under way to end. False if there is none.
  bool cancel();

  bool busy() const;
  bool cancelled() const;

  /// Publishes the state. Not to be called from the pacer's `stop`, which holds a lock that this needs.
  void publish();

  /// Fills a diagnostic status: WARN after a run that failed.
  void report(pusht::DiagnosticStatusWrapper& status) const;

 private:
  const Pacer& pacer_;
  const std::function<void(bool)> on_publish_;
  std::mutex publishing_;  // held while publishing, so that the last message is the newest
  ros::Publisher progress_;

  mutable std::mutex mutex_;  // guards the members below
  bool busy_ = false;
  bool cancelled_ = false;
  std::string failure_;  // reason of the last run's early end; empty: none, or a run is under way
  std::string activity_ = "idle";
  int episodes_ = 0;  // number of episodes of the run under way, or of the last one
  int episodes_finished_ = 0;
  std::uint32_t runs_ = 0;              // number of runs that have begun
  std::string waiting_for_;             // namespace of the missing node's services; empty: none
  std::optional<double> seconds_left_;  // estimate for the run under way [s]
};

}  // namespace sim2sim
