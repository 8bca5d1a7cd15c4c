// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_rviz/evaluator_link.hpp"

#include <XmlRpcValue.h>
#include <pusht_msgs/Control.h>
#include <pusht_msgs/Describe.h>
#include <pusht_msgs/Episodes.h>
#include <ros/master.h>
#include <ros/names.h>
#include <ros/node_handle.h>
#include <ros/service_client.h>
#include <ros/this_node.h>

#include <algorithm>
#include <chrono>
#include <utility>

namespace pusht_rviz {
namespace {

constexpr int kPeriod = 40;          // [ms] of the timer: what happens is shown 25 times a second at most
constexpr int kUnknownTooOften = 2;  // answers of the master in a row, before it counts as a new one
constexpr double kFullSpeed = -1.0;  // of the service `control`

/// Over roscpp.
class RosConnection : public Connection {
 public:
  explicit RosConnection(const ros::ServiceClient& client) : client_(client) {}
  bool stands() const override { return client_.isValid(); }
  void close() override { client_.shutdown(); }
  ros::ServiceClient& client() { return client_; }

 private:
  ros::ServiceClient client_;
};

/// To the master every call is a connection of its own.
class MasterConnection : public Connection {
 public:
  bool stands() const override { return true; }
  void close() override {}  // there is no way to break off a call
};

template <class Service>
Line::Connect connectTo(const std::string& service) {
  return [service] { return std::make_shared<RosConnection>(ros::NodeHandle().serviceClient<Service>(service, true)); };
}

/// Calls a service; `tell` gets whether there was an answer, and the answer.
template <class Service, class TellAnswer>
Line::Call callOf(const typename Service::Request& request, TellAnswer tell) {
  return [request, tell](Connection& connection) {
    Service service;
    service.request = request;
    const bool answered = static_cast<RosConnection&>(connection).client().call(service);
    tell(answered, service.response);
    return answered;
  };
}

Line::Tell tellPresence(const std::shared_ptr<Post>& post, Role role) {
  return [post, role](Presence presence) { post->put(PresenceNews{role, presence}); };
}

Line::Call describeCall(const std::shared_ptr<Post>& post, Role role, const std::string& kind) {
  pusht_msgs::DescribeRequest request;
  request.kind = kind;
  return callOf<pusht_msgs::Describe>(
      request, [post, role, kind](bool answered, const pusht_msgs::DescribeResponse& description) {
        post->put(DescriptionNews{role, kind, answered, description});
      });
}

/// A service that the evaluator refuses, so that nothing comes of it but an answer: somebody is there.
Line::Call nothingCall() {
  return callOf<pusht_msgs::Control>({}, [](bool /*answered*/, const pusht_msgs::ControlResponse& /*response*/) {});
}

/// Of a list: the iterators of an XmlRpcValue are those of a struct.
std::vector<XmlRpc::XmlRpcValue> elementsOf(XmlRpc::XmlRpcValue& list) {
  std::vector<XmlRpc::XmlRpcValue> elements(static_cast<std::size_t>(list.size()));
  int next = 0;
  std::generate(elements.begin(), elements.end(), [&] { return list[next++]; });
  return elements;
}

/// Asks the master for its list of who publishes, subscribes and serves what.
bool askMaster(Post& post, const std::string& progress_topic) {
  constexpr const char* kAct = "/act";
  constexpr std::size_t kActLength = 4;
  XmlRpc::XmlRpcValue request;
  XmlRpc::XmlRpcValue response;
  XmlRpc::XmlRpcValue lists;
  request[0] = ros::this_node::getName();
  if (!ros::master::execute("getSystemState", request, response, lists, false)) {
    return false;
  }
  MasterNews news;
  for (XmlRpc::XmlRpcValue& subscribed : elementsOf(lists[1])) {
    if (static_cast<std::string&>(subscribed[0]) == progress_topic) {
      for (XmlRpc::XmlRpcValue& node : elementsOf(subscribed[1])) {
        news.knows_us = news.knows_us || static_cast<std::string&>(node) == ros::this_node::getName();
      }
    }
  }
  for (XmlRpc::XmlRpcValue& served : elementsOf(lists[2])) {
    const std::string& service = served[0];
    if (service.size() > kActLength && service.compare(service.size() - kActLength, kActLength, kAct) == 0) {
      news.policies.push_back(service.substr(0, service.size() - kActLength));
    }
  }
  std::sort(news.policies.begin(), news.policies.end());
  post.put(std::move(news));
  return true;
}

}  // namespace

EvaluatorLink::EvaluatorLink(QObject* parent) : QObject(parent) {
  connect(&timer_, &QTimer::timeout, this, &EvaluatorLink::attend);
  timer_.start(kPeriod);
}

EvaluatorLink::~EvaluatorLink() { close(); }

void EvaluatorLink::setNamespace(const QString& evaluator) {
  std::string resolved;
  try {
    resolved = ros::names::resolve(evaluator.trimmed().toStdString());
  } catch (const ros::InvalidNameException&) {
    // Refused below, like no name at all.
  }
  if (evaluator.trimmed().isEmpty() || resolved.size() < 2) {
    Q_EMIT refused("namespace '" + evaluator + "': must be a ROS name, e.g. /sim2sim");
    return;
  }
  if (resolved == evaluator_) {
    return;
  }
  evaluator_ = resolved;
  open();
}

void EvaluatorLink::close() {
  if (session_) {
    session_->end();
  }
  for (const std::unique_ptr<Line>& line : lines_) {
    if (line) {
      line->end();
    }
  }
  for (const std::unique_ptr<Line>* const line : {&episodes_line_, &master_line_}) {
    if (*line) {
      (*line)->end();
    }
  }
  session_.reset();
  episodes_line_.reset();
  master_line_.reset();
  for (std::unique_ptr<Line>& line : lines_) {
    line.reset();
  }
}

void EvaluatorLink::open() {
  close();
  services_ = {};
  policy_.clear();
  known_ = {};
  presence_ = {};
  progress_ = {};
  heard_ = served_ = open_ = seeking_ = false;
  unknown_to_master_ = 0;
  next_seek_.reset();
  post_ = std::make_shared<Post>();
  Q_EMIT forgotten();
  Q_EMIT progressed();
  for (std::size_t role = 0; role < kRoles; ++role) {
    Q_EMIT presenceChanged(static_cast<int>(role));
  }
  session_ = std::make_unique<Session>(evaluator_, post_);
  lines_[kEvaluator] = std::make_unique<Line>(connectTo<pusht_msgs::Control>(evaluator_ + "/control"), nothingCall(),
                                              tellPresence(post_, kEvaluator));
  Line::Times slow;
  slow.tick = slow.heartbeat = std::chrono::seconds(2);
  master_line_ = std::make_unique<Line>(
      [] { return std::make_shared<MasterConnection>(); },
      [post = post_, topic = evaluator_ + "/progress"](Connection& /*connection*/) { return askMaster(*post, topic); },
      [](Presence /*presence*/) {}, slow);
}

void EvaluatorLink::attend() {
  for (const std::unique_ptr<Line>& line : lines_) {
    if (line) {
      line->attend();
    }
  }
  if (!post_) {
    return;
  }
  const std::shared_ptr<Post> post = post_;
  const std::vector<Letter> letters = post->takeAll();
  for (const Letter& letter : letters) {
    if (post != post_) {
      return;  // of the evaluator before
    }
    std::visit([this](const auto& content) { read(content); }, letter);
  }
  if (!letters.empty()) {
    Q_EMIT settled();
  }
}

void EvaluatorLink::start(const pusht_msgs::CompareGoal& goal) {
  goal_policy_ = goal.policy_namespace;
  if (!session_ || !session_->send(goal)) {
    Q_EMIT goalEnded(true, "nobody serves " + evaluator() + "/compare");
  }
}

void EvaluatorLink::control(const pusht_msgs::ControlRequest& request) {
  if (!lines_[kEvaluator]) {
    return;
  }
  lines_[kEvaluator]->ask(callOf<pusht_msgs::Control>(
      request, [post = post_, command = request.command](bool answered, const pusht_msgs::ControlResponse& response) {
        post->put(ControlNews{command, answered && response.success != 0,
                              answered ? response.message : command + ": nobody answers"});
      }));
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
  next_seek_ = Place{episode, step};
  seekOn();
}

void EvaluatorLink::seekOn() {
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

void EvaluatorLink::describe(Role role, const QString& kind) {
  if (lines_[role]) {
    lines_[role]->ask(describeCall(post_, role, kind.toStdString()));
  }
}

void EvaluatorLink::askForEpisodes() {
  const std::uint64_t number = ++episodes_request_;
  // A line of its own: ten thousand episodes take a while, and commands must not wait for them. It serves once.
  Line::Times times;
  times.heartbeat = std::chrono::hours(1);
  episodes_line_ = std::make_unique<Line>(
      connectTo<pusht_msgs::Episodes>(evaluator_ + "/episodes"),
      callOf<pusht_msgs::Episodes>({},
                                   [post = post_, number](bool answered, const pusht_msgs::EpisodesResponse& response) {
                                     if (answered) {
                                       post->put(EpisodesNews{number, response.episodes, response.curve});
                                     }
                                   }),
      [](Presence /*presence*/) {}, times);
}

void EvaluatorLink::connectNodes(const pusht_msgs::CompareGoal& request) {
  const std::array<std::pair<Role, std::vector<std::string>>, kRoles - 1> nodes = {
      std::pair(kReference, request.reference_namespace), std::pair(kEngine, request.engine_namespace),
      std::pair(kReplay, request.replay_namespace), std::pair(kPolicy, request.policy_namespace)};
  for (const auto& [role, name] : nodes) {
    if (lines_[role] && serviceOf(name) != services_[role]) {
      lines_[role]->end();  // all of them, before one is waited for
    }
  }
  for (const auto& [role, name] : nodes) {
    connectNode(role, name);
  }
  policy_ = ros::names::parentNamespace(services_[kPolicy]);
}

std::string EvaluatorLink::serviceOf(const std::vector<std::string>& node) const {
  try {
    if (!node.empty() && !node.front().empty()) {
      return ros::names::resolve(ros::names::parentNamespace(evaluator_), node.front()) + "/describe";
    }
  } catch (const ros::InvalidNameException&) {
    // Then there is no node to talk to.
  }
  return "";
}

void EvaluatorLink::connectNode(Role role, const std::vector<std::string>& name) {
  const std::string service = serviceOf(name);
  if (service == services_[role]) {
    return;
  }
  services_[role] = service;
  known_[role].clear();
  presence_[role] = Presence::kWaiting;
  lines_[role].reset();
  if (!service.empty()) {
    lines_[role] = std::make_unique<Line>(connectTo<pusht_msgs::Describe>(service), describeCall(post_, role, ""),
                                          tellPresence(post_, role));
  }
  Q_EMIT presenceChanged(role);
}

void EvaluatorLink::read(const pusht_msgs::Progress& progress) {
  const bool first = !std::exchange(heard_, true);
  const bool begins = first || progress.run != progress_.run;
  progress_ = progress;
  if (begins) {
    episodes_line_.reset();  // what it would bring is of an earlier run
    Q_EMIT runBegan();
  }
  if (first) {
    askForEpisodes();
  }
  Q_EMIT progressed();
}

void EvaluatorLink::read(const pusht_msgs::Divergence& divergence) { Q_EMIT diverged(divergence); }

void EvaluatorLink::read(const pusht_msgs::EpisodeResult& episode) { Q_EMIT episodesFinished({episode}); }

void EvaluatorLink::read(const pusht_msgs::Summary& summary) { Q_EMIT summarised(summary); }

void EvaluatorLink::read(const pusht_msgs::CompareGoal& request) {
  connectNodes(request);
  Q_EMIT requestCame(request);
}

void EvaluatorLink::read(const GoalNews& news) {
  if (news.ended) {
    Q_EMIT goalEnded(news.rejected, QString::fromStdString(news.text));
  } else {
    if (!goal_policy_.empty()) {
      connectNode(kPolicy, goal_policy_);
    }
    Q_EMIT goalAccepted();
  }
}

void EvaluatorLink::read(const ActionNews& news) {
  served_ = news.served;
  Q_EMIT progressed();
}

void EvaluatorLink::read(const PresenceNews& news) {
  presence_[news.role] = news.presence;
  if (news.presence == Presence::kAlive) {
    known_[news.role].clear();  // answers may have been lost: what it says next counts as new
  }
  if (news.role == kEvaluator && news.presence == Presence::kLost) {
    progress_ = {};  // latched messages of the next one say how things are
    heard_ = seeking_ = false;
    next_seek_.reset();
    Q_EMIT progressed();
  }
  Q_EMIT presenceChanged(news.role);
}

void EvaluatorLink::read(const DescriptionNews& news) {
  const pusht_msgs::DescribeResponse& description = news.description;
  if (!news.answered) {
    return;
  }
  if (news.kind.empty()) {
    std::string now = description.instance_id + '\n' + description.name + '\n' + description.message;
    for (const pusht_msgs::Parameter& parameter : description.parameters) {
      now += '\n' + parameter.name + '=' + parameter.value;
    }
    if (std::exchange(known_[news.role], now) == now) {
      return;  // it says so every second
    }
  }
  Q_EMIT described(news.role, QString::fromStdString(news.kind), description);
}

void EvaluatorLink::read(const ControlNews& news) {
  if (!news.done) {
    Q_EMIT refused(QString::fromStdString(news.message));
  } else {
    Q_EMIT obeyed();
  }
  if (news.command == pusht_msgs::ControlRequest::SEEK) {
    seeking_ = false;
    seekOn();
  }
}

void EvaluatorLink::read(const EpisodesNews& news) {
  if (news.request != episodes_request_ || !episodes_line_) {
    return;
  }
  episodes_line_.reset();
  if (!news.episodes.empty()) {
    Q_EMIT episodesFinished(news.episodes);
  }
  Q_EMIT recalled(news.curve);
}

void EvaluatorLink::read(const MasterNews& news) {
  QStringList policies;
  for (const std::string& policy : news.policies) {
    policies << QString::fromStdString(policy);
  }
  Q_EMIT policiesFound(policies);
  unknown_to_master_ = open_ && !news.knows_us ? unknown_to_master_ + 1 : 0;
  if (unknown_to_master_ >= kUnknownTooOften) {
    open();  // a new master: it has to be told of our subscriptions
  }
}

void EvaluatorLink::read(const SessionNews& /*news*/) { open_ = true; }

}  // namespace pusht_rviz
