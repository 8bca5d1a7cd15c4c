// SPDX-License-Identifier: BSD-3-Clause
#include "live/evaluator.hpp"

#include <ros/ros.h>

#include <iostream>
#include <utility>

#include "live/control.hpp"
#include "live/named_options.hpp"
#include "live/outcome.hpp"
#include "live/participants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/reason.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/results/metrics.hpp"
#include "sim2sim_protocol/results/run.hpp"
#include "sim2sim_serving/node.hpp"

namespace sim2sim {
namespace {

constexpr const char* kEndOfLaunch = " (roslaunch now ends the other nodes, and says so in red)";
constexpr const char* kHowToResume = "rosservice call /sim2sim/control \"{command: resume}\"";

std::chrono::milliseconds toMilliseconds(double seconds) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::duration<double>(seconds));
}

void requireRun(bool there_is, const std::string& command) {
  if (!there_is) {
    throw pusht::InvalidInput(command + ": no comparison is under way");
  }
}

}  // namespace

Evaluator::Evaluator(const ros::NodeHandle& node, EvaluatorParameters parameters)
    : node_(node),
      parameters_(std::move(parameters)),
      broadcast_(node_),
      activity_(node_, pacer_, [this](bool paused) { broadcast_.showPaused(paused); }),
      request_(node_.advertise<pusht_msgs::CompareGoal>("request", 1, true)),
      options_(node_.advertise<pusht_msgs::RunOptions>("options", 1, true)),
      node_watch_(node_, parameters_.request.services),
      health_("none", "comparison", [this](pusht::DiagnosticStatusWrapper& status) { activity_.report(status); }),
      control_(node_.advertiseService("control", &Evaluator::onControl, this)),
      server_(
          node_, "compare", [this](const Goal& goal) { onGoal(goal); }, [this](const Goal& goal) { onCancel(goal); },
          false) {
  if (!parameters_.headless.empty()) {
    ROS_INFO_STREAM("running headless: " << parameters_.headless);
  }
  if (parameters_.start) {
    next_job_ = Job{parameters_.request, std::nullopt};
    activity_.markRequested();
  }
  activity_.publish();
  request_.publish(goalOf(parameters_.request));
  options_.publish(describe(parameters_.request.protocol));
  server_.start();
}

pusht::ExitCode Evaluator::run() {
  pusht::ExitCode code = pusht::ExitCode::kOk;
  while (std::optional<Job> job = nextJob()) {
    RunStatus status = execute(*job);
    if (parameters_.report && status.exit_code == pusht::ExitCode::kOk) {
      status = writeReport(status, folder_);
    }
    code = status.exit_code;
    answer(*job, status);
    if (parameters_.exit && !job->goal) {
      break;
    }
  }
  return code;
}

std::optional<Evaluator::Job> Evaluator::nextJob() {
  constexpr std::chrono::milliseconds kStopPeriod{50};
  std::unique_lock<std::mutex> lock(mutex_);
  while (!next_job_) {
    if (!ros::ok() || interrupted()) {
      return std::nullopt;
    }
    asked_.wait_for(lock, kStopPeriod);
  }
  return std::exchange(next_job_, std::nullopt);
}

RunStatus Evaluator::execute(const Job& job) {
  run_.reset();
  summary_is_ours_ = false;
  goal_ = job.goal;
  folder_.clear();
  faults_survived_ = 0;
  broadcast_.showState(RunState::kWaits, "a run begins");
  std::optional<RunFolder> folder;
  try {
    writeStatusFile(parameters_.status_file, underWay(job.request.protocol.episodes));
    folder.emplace(job.request.out, job.request.overwrite);
    runIn(*folder, job.request);
    const auto episodes = static_cast<int>(run_->episodes().size());
    return {pusht::ExitCode::kOk, "finished", episodes, episodes, faults_survived_};
  } catch (const std::exception& failure) {
    pusht::reportFailure(ros::this_node::getName(), failure);
    const int finished = run_ ? static_cast<int>(run_->episodes().size()) : 0;
    const int episodes = run_ ? run_->configuration().protocol.episodes : job.request.protocol.episodes;
    RunStatus status = {pusht::exitCodeOf(failure), clippedReason(failure), finished, episodes, faults_survived_};
    try {
      broadcast_.end();
    } catch (const std::exception&) {
      // The bag cannot be written; perhaps that is the failure.
    }
    broadcast_.showState(RunState::kEnded, "ended early: " + status.reason);
    try {
      if (run_) {
        run_->abandon(std::cout, failure, faults_survived_);
      } else if (folder) {
        folder->refuse(status);
      }
    } catch (const std::exception& second) {
      pusht::reportFailure(ros::this_node::getName(), second);
    }
    return status;
  }
}

void Evaluator::runIn(RunFolder& folder, const LiveRequest& request) {
  try {
    compare(request, folder);
  } catch (const pusht::NodeMissing& lost) {
    if (parameters_.exit || stopped()) {
      throw;
    }
    throw pusht::RuntimeFault(lost.what() + restartHint(lost, request, worlds_));
  }
}

void Evaluator::compare(LiveRequest request, RunFolder& folder) {
  request.protocol.carryTask();
  request.protocol.validate();
  request.protocol.initial_states =
      givenInitialStates(request.starts, request.protocol.firstStart(), request.protocol.starts(),
                         request.protocol.overlapping_starts, request.protocol.runTask());
  pacer_.setRate(request.rate);
  if (pacer_.paused()) {
    ROS_WARN_STREAM("the run waits, since the evaluator is paused; to go on: " << kHowToResume);
  }
  request.simulators.task = request.protocol.runTask();
  const LiveOptions options = {request.simulators,
                               {toMilliseconds(parameters_.patience), parameters_.respawn, [this] { return stopped(); },
                                [this](const std::string& services) { waitFor(services); }},
                               toMilliseconds(parameters_.grace)};
  node_watch_.follow(request.services);
  LiveNodes nodes(request.services, toMilliseconds(parameters_.deadline), worlds_);
  connectFirst(nodes, options);

  requirePolicy(request, nodes);
  const VariantWorlds variants = variantWorldsOf(request.protocol, nodes);
  const RunConfiguration configuration = configurationOf(request, nodes);
  const nlohmann::ordered_json provenance = runProvenance(configuration, nodes);
  folder.refuseInputs(inputsOf(request, nodes));
  run_ = std::make_unique<Run>(configuration, &folder, provenance);
  folder_ = std::filesystem::absolute(folder.path());
  line_.emplace(request.protocol.episodes);
  activity_.begin(request.protocol.episodes);
  nodes.stamps().advance();
  const WorldNames names = worldNamesOf(request, nodes);
  std::unique_ptr<RunBag> bag =
      request.record ? std::make_unique<RunBag>(folder.bagPath(), provenance, names, nodes.stamps().now()) : nullptr;
  broadcast_.begin(configuration, pictureOf(configuration, nodes), std::move(bag), nodes.stamps().now());
  summary_is_ours_ = true;
  broadcast_.publishConfiguration(configurationMessage(provenance, names, nodes.stamps().now()));
  runLive(configuration.protocol, nodes, variants, pacer_, *this, options);
  broadcast_.end();
  const nlohmann::json metrics = run_->finish(std::cout, faults_survived_);
  ROS_INFO_STREAM("finished, all is well: results in " << folder_.string() << (parameters_.exit ? kEndOfLaunch : ""));
  const std::string doubt = doubtAboutPolicy(metrics, provenance, run_->summary().endings.reference);
  if (!doubt.empty()) {
    ROS_WARN_STREAM(doubt);
  }
}

void Evaluator::answer(Job& job, const RunStatus& status) {
  try {
    writeStatusFile(parameters_.status_file, status);
  } catch (const pusht::RuntimeFault& fault) {
    pusht::reportFailure(ros::this_node::getName(), fault);
  }
  node_watch_.follow(parameters_.request.services);  // those of the next run, unless its goal names others
  const bool cancelled = activity_.end(status.exit_code == pusht::ExitCode::kOk ? "" : status.reason);
  if (job.goal) {
    pusht_msgs::CompareResult result = refusal(status.exit_code, status.reason);
    result.folder = folder_.string();
    result.faults_survived = static_cast<std::uint32_t>(status.faults_survived);
    if (summary_is_ours_) {
      result.summary = broadcast_.summary();
    }
    if (status.exit_code == pusht::ExitCode::kOk) {
      job.goal->setSucceeded(result);
    } else if (cancelled) {
      job.goal->setCanceled(result, status.reason);
    } else {
      job.goal->setAborted(result, status.reason);
    }
  }
}

bool Evaluator::stopped() const { return activity_.cancelled() || !ros::ok() || interrupted(); }

void Evaluator::onGoal(Goal goal) {
  if (accept(goal)) {
    activity_.publish();
  }
}

bool Evaluator::accept(Goal& goal) {
  if (activity_.busy()) {
    const std::string reason = "a comparison is under way: cancel it, or wait for its end";
    goal.setRejected(refusal(pusht::ExitCode::kRuntimeFault, reason), reason);
    return false;
  }
  LiveRequest request;
  try {
    request = merged(parameters_.request, *goal.getGoal());
    if (goal.getGoal()->out.empty() && !request.overwrite) {
      request.out = freeFolder(request.out);
    }
  } catch (const pusht::InvalidInput& error) {
    goal.setRejected(refusal(error.exitCode(), clippedReason(error)), clippedReason(error));
    return false;
  }
  goal.setAccepted();
  accepted_ = goal;
  activity_.markRequested();
  const std::lock_guard<std::mutex> lock(mutex_);
  next_job_ = Job{std::move(request), goal};
  asked_.notify_one();
  return true;
}

void Evaluator::onCancel(const Goal& goal) {
  if (goal == accepted_) {
    activity_.cancel();
  }
}

bool Evaluator::onControl(pusht_msgs::ControlRequest& request, pusht_msgs::ControlResponse& response) {
  response = controlResponse([&] {
    if (request.command == pusht_msgs::ControlRequest::CANCEL) {
      requireRun(activity_.cancel(), request.command);
    } else {
      requireRun(request.command != pusht_msgs::ControlRequest::STEP || activity_.busy(), request.command);
      applyControl(pacer_, request);
    }
    activity_.publish();
  });
  if (response.success != 0 && request.command == pusht_msgs::ControlRequest::PAUSE && !activity_.busy()) {
    response.message = "no comparison is under way: the next one begins paused";
  }
  return true;
}

void Evaluator::waitFor(const std::string& services) {
  if (!services.empty()) {
    broadcast_.showState(RunState::kWaits, "waits for the node " + services);
  }
  activity_.waitFor(services);
}

void Evaluator::onStep(const Episode& episode, const ros::Time& stamp) {
  const pusht_msgs::Divergence divergence = broadcast_.step(episode, stamp, pacer_.rate() > 0.0 || pacer_.paused());
  if (goal_) {
    pusht_msgs::CompareFeedback feedback;
    feedback.episodes_finished = static_cast<std::uint32_t>(run_->episodes().size());
    feedback.divergence = divergence;
    goal_->publishFeedback(feedback);
  }
  if (line_->due()) {
    const std::optional<Summary> finished = run_->episodes().empty() ? std::nullopt : std::optional(run_->summary());
    ROS_INFO_STREAM(line_->text(finished, episode.steps()));
  }
}

bool Evaluator::onFinish(const Episode& episode, const ros::Time& stamp) {
  const EpisodeResult result = run_->add(episode);
  broadcast_.finish(episode, result, run_->summary(), run_->whole(), stamp);
  activity_.finishEpisode(run_->progress(), line_->secondsLeft(static_cast<int>(run_->episodes().size())));
  return !run_->decided();
}

void Evaluator::onBreak(const Episode& episode) { broadcast_.redrawLastStep(episode); }

void Evaluator::onFault(int episode, const pusht::PeerFault& fault) {
  ROS_WARN_STREAM("episode " << episode << " is void and begins again: " << fault.what());
}

void Evaluator::onRecovery() { ++faults_survived_; }

void Evaluator::onLoss(int episode, const pusht::PeerFault& fault) {
  ROS_WARN_STREAM("lost in episode " << episode << ": " << fault.what());
}

pusht::ExitCode evaluate() {
  const ros::NodeHandle node("~");
  pusht::ParameterReader parameters(node);
  try {
    parameters.enterWorkingDirectory();
    const EvaluatorParameters loaded = EvaluatorParameters::load(parameters);
    parameters.refuseUnknown();
    if (loaded.start) {
      writeStatusFile(loaded.status_file, underWay(loaded.request.protocol.episodes));
    }
    pusht::requireClock();
    Evaluator evaluator(node, loaded);
    ros::AsyncSpinner callbacks(1);
    callbacks.start();
    return evaluator.run();
  } catch (const std::exception& failure) {
    writeRefusal(parameters, failure);
    throw;
  }
}

}  // namespace sim2sim
