// SPDX-License-Identifier: BSD-3-Clause
/// Evaluator: the node that runs comparisons over other nodes.
#pragma once

#include <actionlib/server/action_server.h>
#include <pusht_msgs/CompareAction.h>
#include <pusht_msgs/Control.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "live/activity.hpp"
#include "live/broadcast.hpp"
#include "live/evaluate.hpp"
#include "live/evaluator_parameters.hpp"
#include "live/live_nodes.hpp"
#include "live/live_run.hpp"
#include "live/node_watch.hpp"
#include "live/pacer.hpp"
#include "live/progress_line.hpp"
#include "live/request.hpp"
#include "live/world_memory.hpp"
#include "sim2sim_protocol/results/run.hpp"
#include "sim2sim_protocol/results/run_folder.hpp"
#include "sim2sim_serving/health.hpp"
#include "sim2sim_serving/node_parameters.hpp"

namespace sim2sim {

/// Node that runs comparisons, one at a time: a goal that comes during a run is rejected. In its private namespace it
/// offers the action `compare`, the service `control`, the latched topics `request` (values of fields that a goal
/// leaves open), `options` (descriptions of the options of a run) and `progress`, and the topics of NodeWatch and
/// Broadcast.
class Evaluator : private LiveObserver {
 public:
  Evaluator(const ros::NodeHandle& node, EvaluatorParameters parameters);

  /// Runs comparisons as goals arrive, until the node ends. With the parameter `exit` it returns after the run that the
  /// parameters request. Returns the exit code of the last run. Callbacks must be served in another thread.
  pusht::ExitCode run();

 private:
  using Server = actionlib::ActionServer<pusht_msgs::CompareAction>;
  using Goal = Server::GoalHandle;

  /// Request of a run, and the goal that made it; no goal if the parameters did.
  struct Job {
    LiveRequest request;
    std::optional<Goal> goal;
  };

  // Callbacks, in their own thread.
  void onGoal(Goal goal);
  bool accept(Goal& goal);
  void onCancel(const Goal& goal);
  bool onControl(pusht_msgs::ControlRequest& request, pusht_msgs::ControlResponse& response);

  std::optional<Job> nextJob();
  RunStatus execute(const Job& job);

  /// Calls compare(). Adds to the error of a missing node how to restart it, if the evaluator stays.
  void runIn(RunFolder& folder, const LiveRequest& request);
  void compare(LiveRequest request, RunFolder& folder);
  /// Publishes the node that the run waits for, by the namespace of its services; empty: the wait is over.
  void waitFor(const std::string& services);
  void answer(Job& job, const RunStatus& status);
  bool stopped() const;

  void onStep(const Episode& episode, const ros::Time& stamp) override;
  bool onFinish(const Episode& episode, const ros::Time& stamp) override;
  void onBreak(const Episode& episode) override;
  void onFault(int episode, const pusht::PeerFault& fault) override;
  void onRecovery() override;
  void onLoss(int episode, const pusht::PeerFault& fault) override;

  ros::NodeHandle node_;
  const EvaluatorParameters parameters_;
  Pacer pacer_;
  Broadcast broadcast_;

  Activity activity_;

  std::mutex mutex_;  // guards next_job_
  std::condition_variable asked_;
  std::optional<Job> next_job_;

  Goal accepted_;  // last accepted goal; used in the thread of the callbacks alone
  ros::Publisher request_;
  ros::Publisher options_;

  NodeWatch node_watch_;

  WorldMemory worlds_;  // used in the thread of run() alone

  // State of the run under way, used in the thread of run() alone.
  std::optional<Goal> goal_;
  std::unique_ptr<Run> run_;
  bool summary_is_ours_ = false;  // the broadcast's summary is of this run, not of the one before
  int faults_survived_ = 0;
  std::filesystem::path folder_;
  std::optional<ProgressLine> line_;

  pusht::Health health_;
  ros::ServiceServer control_;
  Server server_;
};

}  // namespace sim2sim
