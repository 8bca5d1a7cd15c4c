// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/live/evaluator.hpp"

#include <ros/ros.h>

#include <algorithm>
#include <array>
#include <boost/process/search_path.hpp>
#include <boost/process/system.hpp>
#include <functional>
#include <iostream>
#include <iterator>
#include <limits>
#include <regex>
#include <system_error>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/reason.hpp"
#include "pusht_task/ros/node.hpp"
#include "sim2sim_eval/bag/messages.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_eval/live/control.hpp"
#include "sim2sim_eval/results/provenance.hpp"
#include "sim2sim_eval/results/run.hpp"
#include "sim2sim_eval/simulators.hpp"

namespace sim2sim {
namespace {

constexpr double kRateForEyes = 50.0;  // [control steps/s]
constexpr double kFullSpeed = 0.0;
constexpr std::uint32_t kProgressQueue = 100;  // who listens must not miss that a run has begun or ended
constexpr std::uint32_t kNoReanchor = 0;       // alone, in a goal: none; a list without values leaves it open
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr std::chrono::seconds kLinePeriod{5};
constexpr const char* kEndOfLaunch = " (roslaunch now ends the other nodes, and says so in red)";
constexpr const char* kHowToResume = "rosservice call /sim2sim/control \"{command: resume}\"";

std::chrono::milliseconds milliseconds(double seconds) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::duration<double>(seconds));
}

/// Sets `field` to what a goal says of it, if it says anything.
template <class Field, class Values>
void set(const char* name, Field& field, const Values& values) {
  if (values.size() > 1) {
    throw pusht::InvalidInput(std::string(name) + " has " + std::to_string(values.size()) +
                              " values: must have one, or none: then the parameter counts");
  }
  if (!values.empty()) {
    field = static_cast<Field>(values.front());
  }
}

/// Which node took part, as what.
nlohmann::ordered_json participant(const pusht_msgs::DescribeResponse& node) {
  nlohmann::ordered_json parameters = nlohmann::ordered_json::object();
  for (const pusht_msgs::Parameter& parameter : node.parameters) {
    parameters[parameter.name] = parameter.value;
  }
  return {{"name", node.name},
          {"version", node.version},
          {"instance_id", node.instance_id},
          {"parameters", parameters},
          {"parameters_hash", node.parameters_hash}};
}

void requirePolicy(const LiveRequest& request, const Cast& cast) {
  const std::string& name = cast.describePolicy().name;
  if (!request.policy.empty() && request.policy != name) {
    throw pusht::InvalidInput("policy " + request.policy + ": " + request.services.policy + " serves " + name +
                              "; name no policy if its node is started elsewhere, or this one");
  }
}

RunConfiguration configurationOf(const LiveRequest& request, const Cast& cast) {
  RunConfiguration configuration;
  configuration.protocol = request.protocol;
  configuration.smoke = request.smoke;
  configuration.until_decided = request.until_decided;
  configuration.policy = cast.describePolicy().name;
  configuration.reference = recordOf(cast.describe(kReferenceClosed));
  configuration.engine = recordOf(cast.describe(kEngineClosed));
  return configuration;
}

nlohmann::ordered_json originOf(const RunConfiguration& configuration, const Cast& cast) {
  nlohmann::ordered_json result =
      provenance(configuration, provenanceOf(cast.describePolicy()), provenanceOf(cast.describe(kReferenceClosed)),
                 provenanceOf(cast.describe(kEngineClosed)));
  result["nodes"]["policy"] = participant(cast.describePolicy());
  for (const Mode mode : kModes) {
    result["nodes"][modeName(mode)] = participant(cast.describe(mode));
  }
  return result;
}

/// The files that the run has read, and its nodes as far as they say so.
std::vector<Input> inputsOf(const LiveRequest& request, const Cast& cast) {
  std::vector<Input> inputs = {{"policy", cast.describePolicy().name}, {"starts", request.starts}};
  for (const Mode mode : kModes) {
    const std::vector<Input> files = filesIn(provenanceOf(cast.describe(mode)));
    inputs.insert(inputs.end(), files.begin(), files.end());
  }
  return inputs;
}

Picture pictureOf(const RunConfiguration& configuration, const Cast& cast) {
  std::array<std::string, kModeCount> prefixes;
  for (const Mode mode : kModes) {
    prefixes[mode] = cast.describe(mode).frame_prefix;
  }
  return Picture::of(configuration, prefixes);
}

/// Null if the run is not to be recorded.
std::unique_ptr<RunBag> makeBag(const LiveRequest& request, const RunFolder& folder,
                                const nlohmann::ordered_json& provenance, Cast& cast) {
  if (!request.record) {
    return nullptr;
  }
  WorldNames worlds;
  for (const Mode mode : kModes) {
    worlds[mode] = {request.services.worlds[mode] + "/state", cast.describe(mode).frame_prefix};
  }
  cast.stamps().advance();
  return std::make_unique<RunBag>(folder.bagPath(), provenance, worlds, cast.stamps().now());
}

void writeStatusFile(const std::string& path, const RunStatus& status) {
  if (!path.empty()) {
    pusht::writeFile(path, statusText(status));
  }
}

/// Leaves the reason why the node does not start where its results would be.
void tellRefusal(pusht::ParameterReader& parameters, const std::exception& failure) {
  const RunStatus status = {pusht::exitCodeOf(failure), pusht::reasonOf(failure), 0, 0, 0};
  const auto attempt = [](const std::function<void()>& tell) {
    try {
      tell();
    } catch (const pusht::Error&) {
      // The failure itself is reported by whoever gets it.
    }
  };
  attempt([&] { writeStatusFile(parameters.text("status_file", ""), status); });
  attempt([&] { RunFolder(parameters.text("out", ""), parameters.flag("overwrite", false)).refuse(status); });
}

/// None for 0. Throws InvalidInput as TransferBet does.
std::optional<double> decidedShare(double share) {
  if (share == 0.0) {
    return std::nullopt;
  }
  const TransferBet valid(share);
  return share;
}

}  // namespace

pusht::Parameters settingsFrom(const std::string& what, const std::string& text) {
  static const std::regex setting_name("(^|\\s)\\s*([A-Za-z_][A-Za-z0-9_]*)=");
  const std::sregex_iterator end;
  std::sregex_iterator name(text.begin(), text.end(), setting_name);
  const std::string before =
      text.substr(0, name == end ? std::string::npos : static_cast<std::size_t>(name->position()));
  if (before.find_first_not_of(" \t\n") != std::string::npos) {
    throw pusht::InvalidInput(what + " '" + text + "': must be NAME=VALUE NAME=VALUE");
  }
  pusht::Parameters settings;
  while (name != end) {
    const std::sregex_iterator next = std::next(name);
    const auto value = static_cast<std::size_t>(name->position() + name->length());
    const auto value_end =
        next == end ? text.find_last_not_of(" \t\n") + 1 : static_cast<std::size_t>(next->position());
    if (std::any_of(settings.begin(), settings.end(), [&](const auto& other) { return other.name == name->str(2); })) {
      throw pusht::InvalidInput(what + " '" + text + "': " + name->str(2) + " must be set once");
    }
    settings.push_back(pusht::parameter(name->str(2), text.substr(value, std::max(value, value_end) - value)));
    name = next;
  }
  return settings;
}

LiveRequest merged(LiveRequest request, const pusht_msgs::CompareGoal& goal) {
  if (request.smoke && !(goal.episodes.empty() && goal.horizon.empty())) {
    throw pusht::InvalidInput("episodes and horizon: a smoke run has its own");
  }
  if (!goal.policy_namespace.empty()) {
    request.policy.clear();  // of another node
  }
  std::string& policy = request.services.policy;
  set("policy_namespace", policy, goal.policy_namespace);
  policy = pusht::serviceName("policy_namespace", policy);
  const auto set_world = [&](const char* name, Mode mode, const std::vector<std::string>& values) {
    std::string& world = request.services.worlds[mode];
    set(name, world, values);
    world = pusht::serviceName(name, world);
  };
  set_world("reference_namespace", kReferenceClosed, goal.reference_namespace);
  set_world("engine_namespace", kEngineClosed, goal.engine_namespace);
  set_world("replay_namespace", kEngineReplay, goal.replay_namespace);
  set("seed", request.protocol.seed, goal.seed);
  set("first_episode", request.protocol.first_episode, goal.first_episode);
  set("episodes", request.protocol.episodes, goal.episodes);
  set("horizon", request.protocol.horizon, goal.horizon);
  set("bound_position", request.protocol.bound.position, goal.bound_position);
  set("bound_angle", request.protocol.bound.angle, goal.bound_angle);
  if (!goal.until_decided.empty()) {
    double share = 0.0;
    set("until_decided", share, goal.until_decided);
    request.until_decided = decidedShare(share);
  }
  set("floor", request.floor, goal.floor);
  if (goal.reanchor == std::vector<std::uint32_t>{kNoReanchor}) {
    request.reanchor.clear();
  } else if (!goal.reanchor.empty()) {
    request.reanchor.assign(goal.reanchor.begin(), goal.reanchor.end());
  }
  request.protocol.probes = probesOf(request.floor, request.reanchor);
  set("rate", request.rate, goal.rate);
  set("record", request.record, goal.record);
  set("starts", request.starts, goal.starts);
  set("out", request.out, goal.out);
  set("overwrite", request.overwrite, goal.overwrite);
  const auto set_role = [](const char* name, Cast::Setting& setting, const auto& kinds, const auto& parameters) {
    Cast::Setting asked;
    set(name, asked.kind, kinds);
    if (asked.kind.empty()) {
      asked = setting;
    }
    asked.parameters.insert(asked.parameters.end(), parameters.begin(), parameters.end());  // the last of a name counts
    setting = asked;
  };
  set_role("reference", request.settings.reference, goal.reference, goal.reference_parameters);
  set_role("engine", request.settings.engine, goal.engine, goal.engine_parameters);
  return request;
}

pusht_msgs::CompareGoal goalOf(const LiveRequest& request) {
  const auto kind = [](const Cast::Setting& setting) {
    return setting.kind.empty() ? std::vector<std::string>() : std::vector<std::string>{setting.kind};
  };
  const Protocol& protocol = request.protocol;
  pusht_msgs::CompareGoal goal;
  goal.reference_namespace = {request.services.worlds[kReferenceClosed]};
  goal.engine_namespace = {request.services.worlds[kEngineClosed]};
  goal.replay_namespace = {request.services.worlds[kEngineReplay]};
  goal.policy_namespace = {request.services.policy};
  goal.reference = kind(request.settings.reference);
  goal.engine = kind(request.settings.engine);
  goal.seed = {protocol.seed};
  goal.first_episode = {static_cast<std::uint32_t>(protocol.first_episode)};
  goal.episodes = {static_cast<std::uint32_t>(protocol.episodes)};
  goal.horizon = {static_cast<std::uint32_t>(protocol.horizon)};
  goal.rate = {request.rate};
  goal.record = {static_cast<std::uint8_t>(request.record)};
  goal.starts = {request.starts};
  goal.out = {request.out};
  goal.overwrite = {static_cast<std::uint8_t>(request.overwrite)};
  goal.until_decided = {request.until_decided.value_or(0.0)};
  goal.bound_position = {protocol.bound.position};
  goal.bound_angle = {protocol.bound.angle};
  goal.floor = {static_cast<std::uint8_t>(request.floor)};
  goal.reanchor = {kNoReanchor};
  if (!request.reanchor.empty()) {
    goal.reanchor.assign(request.reanchor.begin(), request.reanchor.end());
  }
  goal.reference_parameters = request.settings.reference.parameters;
  goal.engine_parameters = request.settings.engine.parameters;
  return goal;
}

bool ProgressLine::due(Clock::time_point now) {
  if (now - last_ < kLinePeriod) {
    return false;
  }
  last_ = now;
  return true;
}

std::string ProgressLine::text(const std::optional<Summary>& finished, int step, Clock::time_point now) const {
  const int count = finished ? finished->episodes : 0;
  std::string line = std::to_string(count) + " of " + std::to_string(episodes_) +
                     " episodes finished, the next one is at control step " + std::to_string(step);
  if (!finished) {
    return line;
  }
  return line + "; success: reference " + std::to_string(finished->reference.successes) + ", engine " +
         std::to_string(finished->engine.successes) + "; about " + pusht::fixedText(secondsLeft(count, now), 0) +
         " s left";
}

double ProgressLine::secondsLeft(int finished, Clock::time_point now) const {
  const std::chrono::duration<double> elapsed = now - begin_;
  return elapsed.count() / finished * (episodes_ - finished);
}

EvaluatorParameters EvaluatorParameters::load(pusht::ParameterReader& parameters) {
  EvaluatorParameters loaded;
  LiveRequest& request = loaded.request;
  request.services.worlds = {parameters.services("reference_namespace", "reference"),
                             parameters.services("engine_namespace", "engine"),
                             parameters.services("replay_namespace", "engine_replay")};
  request.services.policy = parameters.services("policy_namespace", "policy");
  request.policy = parameters.text("policy", "");
  request.protocol.seed = parameters.seed("seed", request.protocol.seed);
  request.protocol.first_episode = parameters.integer("first_episode", request.protocol.first_episode);
  request.protocol.episodes = parameters.integer("episodes", request.protocol.episodes);
  request.protocol.horizon = parameters.integer("horizon", request.protocol.horizon);
  request.protocol.bound.position = parameters.real("bound_position", request.protocol.bound.position);
  request.protocol.bound.angle = parameters.real("bound_angle", request.protocol.bound.angle);
  request.until_decided = decidedShare(parameters.real("until_decided", 0.0));
  request.floor = parameters.flag("floor", request.floor);
  request.reanchor = reanchorFrom(parameters.text("reanchor", ""));
  request.protocol.probes = probesOf(request.floor, request.reanchor);
  request.smoke = parameters.flag("smoke", request.smoke);
  if (request.smoke) {
    request.protocol = smokeRun(request.protocol);
  }
  loaded.headless = parameters.text("headless", "rviz was not asked for");
  request.rate = parameters.real("rate", loaded.headless.empty() ? kRateForEyes : kFullSpeed);
  const auto settings = [&](const std::string& key) { return settingsFrom(key, parameters.text(key, "")); };
  request.settings = {{parameters.text("reference", ""), settings("reference_parameters")},
                      {parameters.text("engine", ""), settings("engine_parameters")}};
  request.record = parameters.flag("record", request.record);
  request.starts = parameters.text("starts", request.starts);
  request.out = parameters.text("out", request.out);
  request.overwrite = parameters.flag("overwrite", request.overwrite);
  loaded.start = parameters.flag("start", loaded.start);
  loaded.exit = parameters.flag("exit", loaded.exit) && !loaded.headless.empty();
  loaded.respawn = parameters.flag("respawn", loaded.respawn);
  loaded.deadline = parameters.positive("deadline", loaded.deadline);
  loaded.patience = parameters.positive("patience", loaded.patience);
  loaded.status_file = parameters.text("status_file", loaded.status_file);
  loaded.report = parameters.flag("report", loaded.report);
  return loaded;
}

Evaluator::Evaluator(const ros::NodeHandle& node, EvaluatorParameters parameters)
    : node_(node),
      parameters_(std::move(parameters)),
      broadcast_(node_),
      progress_(node_.advertise<pusht_msgs::Progress>("progress", kProgressQueue, true)),
      request_(node_.advertise<pusht_msgs::CompareGoal>("request", 1, true)),
      health_("none", "comparison", [this](pusht::DiagnosticStatusWrapper& status) { report(status); }),
      control_(node_.advertiseService("control", &Evaluator::onControl, this)),
      server_(
          node_, "compare", [this](const Goal& goal) { onGoal(goal); }, [this](const Goal& goal) { onCancel(goal); },
          false) {
  if (!parameters_.headless.empty()) {
    ROS_INFO_STREAM("running headless: " << parameters_.headless);
  }
  if (parameters_.start) {
    next_job_ = Job{parameters_.request, std::nullopt};
    activity_ = "beginning";
    busy_ = true;
  }
  tellProgress();
  request_.publish(goalOf(parameters_.request));
  server_.start();
}

pusht::ExitCode Evaluator::run() {
  pusht::ExitCode code = pusht::ExitCode::kOk;
  while (std::optional<Job> job = nextJob()) {
    RunStatus status = execute(*job);
    if (parameters_.report && status.exit_code == pusht::ExitCode::kOk) {
      status = writeReport(status);
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
  broadcast_.clear();
  goal_ = job.goal;
  folder_.clear();
  faults_survived_ = 0;
  std::optional<RunFolder> folder;
  try {
    writeStatusFile(parameters_.status_file, underWay(job.request.protocol.episodes));
    folder.emplace(job.request.out, job.request.overwrite);
    compare(job.request, *folder);
    const auto episodes = static_cast<int>(run_->episodes().size());
    return {pusht::ExitCode::kOk, "finished", episodes, episodes, faults_survived_};
  } catch (const std::exception& failure) {
    pusht::reportFailure(ros::this_node::getName(), failure);
    const int finished = run_ ? static_cast<int>(run_->episodes().size()) : 0;
    const int episodes = run_ ? run_->configuration().protocol.episodes : job.request.protocol.episodes;
    RunStatus status = {pusht::exitCodeOf(failure), pusht::reasonOf(failure), finished, episodes, faults_survived_};
    try {
      broadcast_.end();
    } catch (const std::exception&) {
      // The bag cannot be written; perhaps that is the failure.
    }
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

RunStatus Evaluator::writeReport(const RunStatus& finished) const {
  namespace process = boost::process;
  RunStatus status = finished;
  try {
    const int code = process::system(process::search_path("rosrun"), "sim2sim_eval", "report", folder_.string());
    if (code == 0) {
      return status;
    }
    status.reason = "the run finished, but its report was not written: report ended with exit code " +
                    std::to_string(code) + "; its own line says why";
  } catch (const process::process_error& error) {
    status.reason = "the run finished, but its report was not written: rosrun: " + error.code().message();
  }
  status.exit_code = pusht::ExitCode::kRuntimeFault;
  ROS_ERROR_STREAM(status.reason);
  return status;
}

void Evaluator::compare(LiveRequest request, RunFolder& folder) {
  request.protocol.validate();
  request.protocol.starts = givenStarts(request.starts, request.protocol.first_episode, request.protocol.episodes);
  pacer_.setRate(request.rate);
  begin(request.protocol.episodes);
  const LiveOptions options = {request.settings, parameters_.respawn, milliseconds(parameters_.patience)};
  Cast cast(request.services, milliseconds(parameters_.deadline));
  const auto stop = [this] { return stopped(); };
  cast.connect(options.settings, options.patience, options.respawn, stop);

  requirePolicy(request, cast);
  const RunConfiguration configuration = configurationOf(request, cast);
  const nlohmann::ordered_json provenance = originOf(configuration, cast);
  folder.refuseInputs(inputsOf(request, cast));
  run_ = std::make_unique<Run>(configuration, folder, provenance);
  folder_ = std::filesystem::absolute(folder.path());
  std::unique_ptr<RunBag> bag = makeBag(request, folder, provenance, cast);
  broadcast_.begin(configuration, pictureOf(configuration, cast), std::move(bag), cast.stamps().now());
  runLive(configuration.protocol, cast, pacer_, *this, options, stop);
  broadcast_.end();
  const nlohmann::json metrics = run_->finish(std::cout, faults_survived_);
  ROS_INFO_STREAM("finished, all is well: results in " << folder_.string() << (parameters_.exit ? kEndOfLaunch : ""));
  const std::string doubt = doubtAboutPolicy(metrics, provenance);
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
  bool cancelled = false;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    cancelled = cancelled_;
    busy_ = false;  // who has the result may send the next goal
    failure_ = status.exit_code == pusht::ExitCode::kOk ? "" : status.reason;
    activity_ = "idle";
  }
  tellProgress();
  if (job.goal) {
    pusht_msgs::CompareResult result;
    result.exit_code = static_cast<int>(status.exit_code);
    result.reason = status.reason;
    result.folder = folder_.string();
    result.faults_survived = static_cast<std::uint32_t>(status.faults_survived);
    result.summary = broadcast_.summary();
    if (status.exit_code == pusht::ExitCode::kOk) {
      job.goal->setSucceeded(result);
    } else if (cancelled) {
      job.goal->setCanceled(result, status.reason);
    } else {
      job.goal->setAborted(result, status.reason);
    }
  }
}

bool Evaluator::stopped() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return cancelled_ || !ros::ok() || interrupted();
}

void Evaluator::onGoal(Goal goal) {
  if (accept(goal)) {
    tellProgress();
  }
}

bool Evaluator::accept(Goal& goal) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (busy_) {
    goal.setRejected({}, "a comparison is under way: cancel it, or wait for its end");
    return false;
  }
  LiveRequest request;
  try {
    request = merged(parameters_.request, *goal.getGoal());
  } catch (const pusht::InvalidInput& refusal) {
    goal.setRejected({}, refusal.what());
    return false;
  }
  goal.setAccepted();
  busy_ = true;
  cancelled_ = false;
  accepted_ = goal;
  failure_.clear();
  activity_ = "beginning";
  next_job_ = Job{std::move(request), goal};
  asked_.notify_one();
  return true;
}

void Evaluator::onCancel(const Goal& goal) {
  const std::lock_guard<std::mutex> lock(mutex_);
  cancelled_ = cancelled_ || goal == accepted_;
}

bool Evaluator::onControl(pusht_msgs::ControlRequest& request, pusht_msgs::ControlResponse& response) {
  response = answerTo([&] {
    if (request.command == pusht_msgs::ControlRequest::CANCEL) {
      cancel();
    } else {
      obey(pacer_, request);
    }
    tellProgress();
  });
  return true;
}

void Evaluator::cancel() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!busy_) {
    throw pusht::InvalidInput("cancel: no comparison is under way");
  }
  cancelled_ = true;
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
  const double seconds_left = line_->secondsLeft(static_cast<int>(run_->episodes().size()));
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    activity_ = run_->progress() + " finished";
    ++episodes_finished_;
    seconds_left_ = seconds_left;
  }
  tellProgress();
  return !run_->decided();
}

void Evaluator::begin(int episodes) {
  line_.emplace(episodes);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    episodes_ = episodes;
    episodes_finished_ = 0;
    seconds_left_.reset();
  }
  tellProgress();
  if (pacer_.paused()) {
    ROS_WARN_STREAM("the run waits, since the evaluator is paused; to go on: " << kHowToResume);
  }
}

void Evaluator::tellProgress() {
  const std::lock_guard<std::mutex> telling(telling_);
  pusht_msgs::Progress progress;
  progress.paused = static_cast<std::uint8_t>(pacer_.paused());
  progress.rate = pacer_.rate();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    progress.busy = static_cast<std::uint8_t>(busy_);
    progress.episodes = static_cast<std::uint32_t>(episodes_);
    progress.episodes_finished = static_cast<std::uint32_t>(episodes_finished_);
    progress.seconds_left = busy_ ? seconds_left_.value_or(kNan) : kNan;
    progress.failure = failure_;
  }
  progress_.publish(progress);
}

void Evaluator::onFault(int episode, const pusht::PeerFault& fault) {
  ++faults_survived_;
  ROS_WARN_STREAM("episode " << episode << " is void and begins again: " << fault.what());
}

void Evaluator::report(pusht::DiagnosticStatusWrapper& status) const {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const bool well = failure_.empty();
    status.summary(well ? diagnostic_msgs::DiagnosticStatus::OK : diagnostic_msgs::DiagnosticStatus::WARN,
                   well ? activity_ : activity_ + "; the last run failed: " + failure_);
  }
  // Without the lock: the pacer calls stopped() under its own.
  status.add("paused", pacer_.paused());
  status.add("rate [control steps/s]", pacer_.rate());
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
    tellRefusal(parameters, failure);
    throw;
  }
}

}  // namespace sim2sim
