// SPDX-License-Identifier: BSD-3-Clause
#include "evaluator_link.hpp"

#include <ros/names.h>

#include <utility>

#include "channels.hpp"

namespace pusht_rviz {
namespace {

constexpr int kPeriod = 40;          // [ms] of the timer, which handles events at most 25 times a second
constexpr double kFullSpeed = -1.0;  // [control steps/s] as the service `control` has it

}  // namespace

EvaluatorLink::EvaluatorLink(QObject* parent) : QObject(parent) {
  connect(&timer_, &QTimer::timeout, this, &EvaluatorLink::attend);
  timer_.start(kPeriod);
}

EvaluatorLink::~EvaluatorLink() { close(); }

void EvaluatorLink::open(const QString& evaluator) {
  try {
    evaluator_ = ros::names::resolve(evaluator.trimmed().toStdString());
  } catch (const ros::InvalidNameException&) {
    // Refused below, like no name at all.
  }
  if (evaluator.trimmed().isEmpty() || evaluator_.size() < 2) {
    Q_EMIT refused("namespace '" + evaluator + "': must be a ROS name, e.g. /sim2sim");
    return;
  }
  events_ = std::make_shared<Events>();
  client_ = std::make_unique<EvaluatorClient>(evaluator_, events_);
  channels_[kEvaluator] = controlChannel(evaluator_, events_);
  master_channel_ = masterChannel(events_);
}

void EvaluatorLink::close() {
  if (client_) {
    client_->end();
  }
  for (const std::unique_ptr<ServiceChannel>& channel : channels_) {
    if (channel) {
      channel->end();
    }
  }
  for (const std::unique_ptr<ServiceChannel>* const channel : {&episodes_channel_, &master_channel_}) {
    if (*channel) {
      (*channel)->end();
    }
  }
  client_.reset();
  episodes_channel_.reset();
  master_channel_.reset();
  for (std::unique_ptr<ServiceChannel>& channel : channels_) {
    channel.reset();
  }
}

void EvaluatorLink::attend() {
  for (const std::unique_ptr<ServiceChannel>& channel : channels_) {
    if (channel) {
      channel->attend();
    }
  }
  if (!events_) {
    return;
  }
  const std::vector<Event> events = events_->popAll();
  for (const Event& event : events) {
    std::visit([this](const auto& content) { handle(content); }, event);
  }
  if (!events.empty()) {
    Q_EMIT settled();
  }
}

void EvaluatorLink::start(const pusht_msgs::CompareGoal& goal) {
  goal_policy_ = goal.policy_namespace;
  if (!client_ || !client_->send(goal)) {
    Q_EMIT goalEnded(true, "no node serves " + evaluator() + "/compare");
  }
}

void EvaluatorLink::control(const pusht_msgs::ControlRequest& request) {
  if (channels_[kEvaluator]) {
    channels_[kEvaluator]->ask(controlCall(events_, request));
  }
}

void EvaluatorLink::command(const std::string& word) {
  pusht_msgs::ControlRequest request;
  request.command = word;
  control(request);
}

void EvaluatorLink::setRate(double rate) {
  pusht_msgs::ControlRequest request;
  request.command = pusht_msgs::ControlRequest::RATE;
  request.rate = rate > 0.0 ? rate : kFullSpeed;
  control(request);
}

void EvaluatorLink::seek(std::uint64_t episode, std::uint32_t step) {
  next_seek_ = Position{episode, step};
  seekNext();
}

void EvaluatorLink::seekNext() {
  if (seeking_ || !next_seek_) {
    return;
  }
  pusht_msgs::ControlRequest request;
  request.command = pusht_msgs::ControlRequest::SEEK;
  request.episode = next_seek_->episode;
  request.step = next_seek_->step;
  next_seek_.reset();
  seeking_ = true;
  control(request);
}

void EvaluatorLink::describe(Node node, const QString& kind) {
  if (channels_[node]) {
    channels_[node]->ask(describeCall(events_, node, kind.toStdString()));
  }
}

void EvaluatorLink::connectNodes(const pusht_msgs::CompareGoal& request) {
  const std::array<std::pair<Node, std::vector<std::string>>, kNodes - 1> nodes = {
      std::pair(kReference, request.reference_namespace), std::pair(kEngine, request.engine_namespace),
      std::pair(kReplay, request.replay_namespace), std::pair(kPolicy, request.policy_namespace)};
  for (const auto& [node, name] : nodes) {
    if (channels_[node] && serviceOf(name) != services_[node]) {
      channels_[node]->end();  // all of them before connectNode() waits for one
    }
  }
  for (const auto& [node, name] : nodes) {
    connectNode(node, name);
  }
  policy_ = ros::names::parentNamespace(services_[kPolicy]);
}

std::string EvaluatorLink::serviceOf(const std::vector<std::string>& name) const {
  try {
    if (!name.empty() && !name.front().empty()) {
      return ros::names::resolve(ros::names::parentNamespace(evaluator_), name.front()) + "/describe";
    }
  } catch (const ros::InvalidNameException&) {
    // A name that is none has no service.
  }
  return "";
}

void EvaluatorLink::connectNode(Node node, const std::vector<std::string>& name) {
  const std::string service = serviceOf(name);
  if (service == services_[node]) {
    return;
  }
  services_[node] = service;
  known_[node].clear();
  presence_[node] = Presence::kWaiting;
  channels_[node].reset();
  if (!service.empty()) {
    channels_[node] = nodeChannel(service, events_, node);
  }
  Q_EMIT presenceChanged(node);
}

void EvaluatorLink::handle(const pusht_msgs::Progress& progress) {
  const bool first = !std::exchange(heard_, true);
  const bool begins = first || progress.run != progress_.run;
  progress_ = progress;
  if (begins) {
    episodes_channel_.reset();  // its answer would be of an earlier run
    Q_EMIT runBegan();
  }
  if (first) {
    episodes_channel_ = episodesChannel(evaluator_, events_, ++episodes_request_);
  }
  Q_EMIT progressed();
}

void EvaluatorLink::handle(const pusht_msgs::Divergence& divergence) { Q_EMIT diverged(divergence); }

void EvaluatorLink::handle(const pusht_msgs::EpisodeResult& episode) { Q_EMIT episodesFinished({episode}); }

void EvaluatorLink::handle(const pusht_msgs::Summary& summary) { Q_EMIT summarized(summary); }

void EvaluatorLink::handle(const pusht_msgs::CompareGoal& request) {
  connectNodes(request);
  Q_EMIT requestCame(request);
}

void EvaluatorLink::handle(const pusht_msgs::RunOptions& options) { Q_EMIT optionsCame(options); }

void EvaluatorLink::handle(const GoalEvent& event) {
  if (event.ended) {
    Q_EMIT goalEnded(event.rejected, QString::fromStdString(event.text));
  } else {
    if (!goal_policy_.empty()) {
      connectNode(kPolicy, goal_policy_);
    }
    Q_EMIT goalAccepted();
  }
}

void EvaluatorLink::handle(const ActionEvent& event) {
  served_ = event.served;
  Q_EMIT progressed();
}

void EvaluatorLink::handle(const PresenceEvent& event) {
  presence_[event.node] = event.presence;
  if (event.presence == Presence::kAlive) {
    known_[event.node].clear();  // answers may have been lost: its next one counts as new
  }
  if (event.node == kEvaluator && event.presence == Presence::kLost) {
    progress_ = {};  // the latched messages of the next evaluator follow
    heard_ = seeking_ = false;
    next_seek_.reset();
    Q_EMIT progressed();
  }
  Q_EMIT presenceChanged(event.node);
}

void EvaluatorLink::handle(const DescriptionEvent& event) {
  const pusht_msgs::DescribeResponse& description = event.description;
  if (!event.answered) {
    return;
  }
  if (event.kind.empty()) {
    std::string now = description.instance_id + '\n' + description.name + '\n' + description.message;
    for (const pusht_msgs::Parameter& parameter : description.parameters) {
      now += '\n' + parameter.name + '=' + parameter.value;
    }
    if (std::exchange(known_[event.node], now) == now) {
      return;  // unchanged since the last heartbeat
    }
  }
  Q_EMIT described(event.node, QString::fromStdString(event.kind), description);
}

void EvaluatorLink::handle(const ControlEvent& event) {
  if (!event.done) {
    Q_EMIT refused(QString::fromStdString(event.message));
  } else {
    Q_EMIT obeyed();
  }
  if (event.command == pusht_msgs::ControlRequest::SEEK) {
    seeking_ = false;
    seekNext();
  }
}

void EvaluatorLink::handle(const EpisodesEvent& event) {
  if (event.request != episodes_request_ || !episodes_channel_) {
    return;
  }
  episodes_channel_.reset();
  if (!event.episodes.empty()) {
    Q_EMIT episodesFinished(event.episodes);
  }
  Q_EMIT recalled(event.curve);
}

void EvaluatorLink::handle(const MasterEvent& event) {
  QStringList policies;
  for (const std::string& policy : event.policies) {
    policies << QString::fromStdString(policy);
  }
  Q_EMIT policiesFound(policies);
}

}  // namespace pusht_rviz
