// SPDX-License-Identifier: BSD-3-Clause
/// The node that runs comparisons over other nodes.
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

#include "pusht_task/ros/health.hpp"
#include "pusht_task/ros/parameters.hpp"
#include "sim2sim_eval/live/activity.hpp"
#include "sim2sim_eval/live/broadcast.hpp"
#include "sim2sim_eval/live/evaluator_parameters.hpp"
#include "sim2sim_eval/live/live_nodes.hpp"
#include "sim2sim_eval/live/live_run.hpp"
#include "sim2sim_eval/live/pacer.hpp"
#include "sim2sim_eval/live/progress_line.hpp"
#include "sim2sim_eval/live/request.hpp"
#include "sim2sim_eval/live/world_memory.hpp"
#include "sim2sim_protocol/results/run.hpp"
#include "sim2sim_protocol/results/run_folder.hpp"

namespace sim2sim {

/// Offers, in its private namespace, the action `compare`, the service `control`, the latched topics `request` (what a
/// goal leaves open), `options` (those of a run, described) and `progress`, and what Broadcast has.
class Evaluator : private LiveObserver {
 public:
  Evaluator(const ros::NodeHandle& node, EvaluatorParameters parameters);

  /// Runs what is asked for until the node ends, or the run that was asked for by parameters has ended and was to
  /// be all. Returns the exit code of the last run. Callbacks must be served in another thread.
  pusht::ExitCode run();

 private:
  using Server = actionlib::ActionServer<pusht_msgs::CompareAction>;
  using Goal = Server::GoalHandle;

  /// A request and the goal that made it; none if parameters did.
  struct Job {
    LiveRequest request;
    std::optional<Goal> goal;
  };

  // Called in the thread of the callbacks.
  void onGoal(Goal goal);
  bool accept(Goal& goal);
  void onCancel(const Goal& goal);
  bool onControl(pusht_msgs::ControlRequest& request, pusht_msgs::ControlResponse& response);

  std::optional<Job> nextJob();
  RunStatus execute(const Job& job);

  /// Calls compare(). The error of a missing node says how to bring the node back, if the evaluator stays.
  void runIn(RunFolder& folder, const LiveRequest& request);
  void compare(LiveRequest request, RunFolder& folder);
  /// Tells which node is waited for, by the namespace of its services; empty: the wait is over.
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

  std::mutex mutex_;  // of the next two
  std::condition_variable asked_;
  std::optional<Job> next_job_;

  Goal accepted_;  // the last one; used in the thread of the callbacks alone
  ros::Publisher request_;
  ros::Publisher options_;

  WorldMemory worlds_;  // used in the thread of run() alone

  // Of the run under way; used in the thread of run() alone.
  std::optional<Goal> goal_;
  std::unique_ptr<Run> run_;
  bool summary_is_ours_ = false;  // what the broadcast tells is of this run, no longer of the one before
  int faults_survived_ = 0;
  std::filesystem::path folder_;
  std::optional<ProgressLine> line_;

  pusht::Health health_;
  ros::ServiceServer control_;
  Server server_;
};

/// The body of the evaluator's node, after catchInterrupts(). If it cannot start, status.json says why.
pusht::ExitCode evaluate();

}  // namespace sim2sim
