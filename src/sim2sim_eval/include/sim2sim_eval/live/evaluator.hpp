// SPDX-License-Identifier: BSD-3-Clause
/// The node that runs comparisons over other nodes.
#pragma once

#include <actionlib/server/action_server.h>
#include <pusht_msgs/CompareAction.h>
#include <pusht_msgs/Control.h>
#include <pusht_msgs/Progress.h>
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
#include "sim2sim_eval/live/broadcast.hpp"
#include "sim2sim_eval/live/cast.hpp"
#include "sim2sim_eval/live/live_run.hpp"
#include "sim2sim_eval/live/pacer.hpp"
#include "sim2sim_eval/results/run.hpp"
#include "sim2sim_eval/results/run_folder.hpp"

namespace sim2sim {

/// One comparison that is asked for.
struct LiveRequest {
  Cast::Services services;
  std::string policy{};  ///< the name that the policy must have; empty: any
  Protocol protocol;
  std::optional<double> until_decided{};  ///< as in RunConfiguration
  bool floor = true;                      ///< as in probesOf(); so is the next
  std::vector<int> reanchor{};
  bool smoke = false;  ///< short; the policy node should be given the untrained policy
  double rate = 0.0;   ///< [control steps/s]; 0: as fast as possible
  Cast::Settings settings;
  bool record = true;      ///< write compare.bag
  std::string starts;      ///< file for readStarts(); empty: spawn seeds
  std::string out;         ///< folder for the results; empty: the next free results/compare-N
  bool overwrite = false;  ///< replace results that are in the folder
};

/// "NAME=VALUE NAME=VALUE"; a value may hold spaces. Throws InvalidInput with `what` and the text if it is none,
/// or sets a name twice.
pusht::Parameters settingsFrom(const std::string& what, const std::string& text);

/// `goal` on top of `request`. Throws InvalidInput with the field of the goal that cannot be.
LiveRequest merged(LiveRequest request, const pusht_msgs::CompareGoal& goal);

/// All of `request` as a goal.
pusht_msgs::CompareGoal goalOf(const LiveRequest& request);

struct EvaluatorParameters {
  LiveRequest request;      ///< what a goal leaves open
  bool start = false;       ///< run `request` at once
  bool exit = false;        ///< and end then, unless rviz shows it
  bool respawn = false;     ///< nodes that die come back: their episode is run again
  double deadline = 5.0;    ///< [s] for the answer to a call
  double patience = 30.0;   ///< [s] for a node to appear, or to come back
  std::string status_file;  ///< a copy of status.json, under way first; empty: none
  bool report = false;      ///< write a report of each run that finishes
  std::string headless;     ///< why rviz does not show what runs; empty: it does, and the node stays when it has run

  /// Throws InvalidInput with key, value and rule.
  static EvaluatorParameters load(pusht::ParameterReader& parameters);
};

/// When to say how far a run is, and how long it still takes if it goes on like this.
class ProgressLine {
 public:
  using Clock = std::chrono::steady_clock;

  explicit ProgressLine(int episodes, Clock::time_point begin = Clock::now())
      : episodes_(episodes), begin_(begin), last_(begin) {}

  /// Whether the last line, or the beginning, was 5 s ago: then there is to be one now. Costs next to nothing.
  bool due(Clock::time_point now = Clock::now());

  /// After so many control steps of the episode under way; `finished` are the episodes before it, none at first.
  std::string text(const std::optional<Summary>& finished, int step, Clock::time_point now = Clock::now()) const;

  /// [s] after so many episodes, one at least.
  double secondsLeft(int finished, Clock::time_point now = Clock::now()) const;

 private:
  int episodes_;
  Clock::time_point begin_;
  Clock::time_point last_;
};

/// Offers, in its private namespace, the action `compare`, the service `control`, the latched topics `request` (what a
/// goal leaves open) and `progress`, and what Broadcast has.
class Evaluator : private LiveObserver {
 public:
  Evaluator(const ros::NodeHandle& node, EvaluatorParameters parameters);

  /// Runs what is asked for until the node ends, or the run that was asked for by parameters has ended and was to
  /// be all. Returns the exit code of the last run. Callbacks must be served in another thread.
  pusht::ExitCode run();

 private:
  using Server = actionlib::ActionServer<pusht_msgs::CompareAction>;
  using Goal = Server::GoalHandle;

  /// A request, and who has made it.
  struct Job {
    LiveRequest request;
    std::optional<Goal> goal;
  };

  // Called in the thread of the callbacks.
  void onGoal(Goal goal);
  bool accept(Goal& goal);
  void onCancel(const Goal& goal);
  bool onControl(pusht_msgs::ControlRequest& request, pusht_msgs::ControlResponse& response);
  void cancel();
  void report(pusht::DiagnosticStatusWrapper& status) const;

  /// Tells on `~progress` how things are now. Not with `mutex_` held: the pacer calls stopped() under its own.
  void tellProgress();

  std::optional<Job> nextJob();
  RunStatus execute(const Job& job);

  /// Of a finished run. If it cannot be written, the status says so; the results stand.
  RunStatus writeReport(const RunStatus& finished) const;
  void compare(LiveRequest request, RunFolder& folder);
  void begin(int episodes);
  void answer(Job& job, const RunStatus& status);
  bool stopped() const;

  void onStep(const Episode& episode, const ros::Time& stamp) override;
  bool onFinish(const Episode& episode, const ros::Time& stamp) override;
  void onFault(int episode, const pusht::PeerFault& fault) override;

  ros::NodeHandle node_;
  const EvaluatorParameters parameters_;
  Pacer pacer_;
  Broadcast broadcast_;

  mutable std::mutex mutex_;  // of what follows
  std::condition_variable asked_;
  std::optional<Job> next_job_;
  bool busy_ = false;
  bool cancelled_ = false;
  Goal accepted_;        // the last one
  std::string failure_;  // of the last run; empty: none, or one is under way
  std::string activity_ = "idle";
  int episodes_ = 0;  // of the run under way, or of the last one
  int episodes_finished_ = 0;
  std::optional<double> seconds_left_;  // of the run under way

  std::mutex telling_;  // so that the last message is the newest
  ros::Publisher progress_;
  ros::Publisher request_;

  // Of the run under way; used in the thread of run() alone.
  std::optional<Goal> goal_;
  std::unique_ptr<Run> run_;
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
