// SPDX-License-Identifier: BSD-3-Clause
#include "evaluator_link.hpp"

#include <actionlib/client/action_client.h>
#include <pusht_msgs/CompareAction.h>
#include <pusht_msgs/Describe.h>
#include <ros/callback_queue.h>
#include <ros/names.h>
#include <ros/node_handle.h>
#include <ros/subscriber.h>

#include <atomic>
#include <functional>
#include <utility>

#include "service_call.hpp"

namespace pusht_rviz {
namespace {

using Client = actionlib::ActionClient<pusht_msgs::CompareAction>;
using Clock = std::chrono::steady_clock;
using pusht_msgs::NodeStatus;

constexpr int kPeriod = 40;          // [ms] of the timer, which handles what has come at most 25 times a second
constexpr double kFullSpeed = -1.0;  // [control steps/s] as the service `control` has it
constexpr std::chrono::milliseconds kRetry{500};     // between attempts to connect
constexpr std::chrono::milliseconds kBeat{500};      // in which a live evaluator publishes `nodes`
constexpr std::chrono::milliseconds kSilence{2000};  // of `nodes` after which the evaluator hangs

constexpr std::uint32_t kManySteps = 10'000;  // at full speed some hundreds come in a second; none may be dropped
constexpr std::uint32_t kManyEpisodes = 1'000;

/// Callback of the panel's own in a callback queue.
class Posted : public ros::CallbackInterface {
 public:
  explicit Posted(std::function<void()> handle) : handle_(std::move(handle)) {}
  CallResult call() override {
    handle_();
    return Success;
  }

 private:
  std::function<void()> handle_;
};

using Outcome = ServiceCall::Outcome;

/// Subscriber whose callback, in the thread that empties the queue, is a method or signal of the link.
template <class Message>
ros::Subscriber subscriberOf(ros::NodeHandle& node, const char* topic, std::uint32_t depth, EvaluatorLink* link,
                             void (EvaluatorLink::*handle)(const Message&)) {
  return node.subscribe<Message>(
      topic, depth, [link, handle](const boost::shared_ptr<Message const>& message) { (link->*handle)(*message); });
}

/// Tells what becomes of a goal; nothing in between. A rejected goal reports its end when its result has come.
void follow(const Client::GoalHandle& goal, EvaluatorLink& link) {
  const actionlib::CommState state = goal.getCommState();
  if (state == actionlib::CommState::ACTIVE) {
    Q_EMIT link.goalAccepted();
  } else if (state == actionlib::CommState::DONE) {
    const actionlib::TerminalState end = goal.getTerminalState();
    Q_EMIT link.goalEnded(end == actionlib::TerminalState::REJECTED, QString::fromStdString(end.getText()));
  }
}

/// What makes a node describe itself again: it was restarted, or has become another.
std::string identityOf(const NodeStatus& node) {
  return node.instance_id + '\n' + node.title + '\n' + node.parameters_hash + '\n' + node.failure;
}

}  // namespace

std::uint8_t evaluatorPresence(std::optional<std::chrono::nanoseconds> silence, bool gone) {
  if (!silence) {
    return NodeStatus::WAITING;
  }
  if (gone && *silence > kBeat) {
    return NodeStatus::LOST;
  }
  return *silence < kSilence ? NodeStatus::ALIVE : NodeStatus::SILENT;
}

/// Connections of the link, shared with the worker. Its thread drops the last reference, since to unsubscribe waits for
/// the master.
struct EvaluatorLink::Ros {
  std::string evaluator;
  std::shared_ptr<ServiceCall> calling = std::make_shared<ServiceCall>();
  ros::CallbackQueue queue;
  std::atomic<bool> subscribed{false};  // from here on, the queue may be emptied
  std::atomic<bool> gone{false};        // the evaluator has closed the connection to `control`, or takes none

  // Used in the worker's thread alone; the client is the GUI's once all is subscribed.
  ros::ServiceClient control;
  bool stands = false;  // the connection to `control`, as far as is known
  Clock::time_point next_attempt{};
  std::vector<ros::Subscriber> subscribers;
  std::unique_ptr<Client> client;
  Client::GoalHandle goal;

  void post(std::function<void()> handle) { queue.addCallback(boost::make_shared<Posted>(std::move(handle))); }

  /// Calls `control`; connects first if need be. False: no answer.
  bool command(pusht_msgs::Control& command) {
    if (!control.isValid()) {
      control = connectionTo<pusht_msgs::Control>(evaluator + "/control");
    }
    const Outcome outcome = calling->make(control, command);
    stands = outcome == Outcome::kAnswered;
    if (stands) {
      gone = false;
    } else {
      control.shutdown();  // a roscpp client whose connection was refused early stays valid
      next_attempt = Clock::now() + kRetry;
      gone = gone || outcome == Outcome::kFailed;
    }
    return stands;
  }
};

EvaluatorLink::EvaluatorLink(QObject* parent) : QObject(parent) {
  connect(&timer_, &QTimer::timeout, this, &EvaluatorLink::attend);
}

EvaluatorLink::~EvaluatorLink() { ros_.reset(); }

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
  ros_ = std::make_shared<Ros>();
  ros_->evaluator = evaluator_;
  worker_ = std::make_unique<Worker>([this, ros = ros_] { look(*ros, this); },
                                     [calling = ros_->calling] { calling->interrupt(); });
  timer_.start(kPeriod);
}

/// Subscribes at first, and then follows the connection to `control`. In the worker's thread.
void EvaluatorLink::look(Ros& ros, EvaluatorLink* link) {
  if (!ros.subscribed) {
    subscribe(ros, link);
  }
  if (ros.control.isValid()) {
    return;
  }
  if (std::exchange(ros.stands, false)) {
    ros.gone = true;
  }
  if (Clock::now() >= ros.next_attempt) {
    pusht_msgs::Control empty;  // is refused, which proves that the connection stands
    ros.command(empty);
  }
}

void EvaluatorLink::subscribe(Ros& ros, EvaluatorLink* link) {
  ros::NodeHandle node(ros.evaluator);
  node.setCallbackQueue(&ros.queue);
  ros.subscribers = {subscriberOf(node, "progress", kManyEpisodes, link, &EvaluatorLink::onProgress),
                     subscriberOf(node, "request", 1, link, &EvaluatorLink::onRequest),
                     subscriberOf(node, "options", 1, link, &EvaluatorLink::optionsCame),
                     subscriberOf(node, "nodes", 1, link, &EvaluatorLink::onNodes),
                     subscriberOf(node, "summary", 1, link, &EvaluatorLink::summarized),
                     subscriberOf(node, "episode", kManyEpisodes, link, &EvaluatorLink::onEpisode),
                     subscriberOf(node, "divergence", kManySteps, link, &EvaluatorLink::diverged)};
  ros.client = std::make_unique<Client>(node, "compare", &ros.queue);
  ros.subscribed = true;
}

void EvaluatorLink::attend() {
  worker_->attend();
  if (!ros_->subscribed) {
    return;
  }
  const bool any = !ros_->queue.isEmpty();
  ros_->queue.callAvailable();
  if (const bool served = ros_->client->isServerConnected(); served != served_) {
    served_ = served;
    Q_EMIT progressed();
  }
  showPresence();
  if (any) {
    Q_EMIT settled();
  }
}

void EvaluatorLink::showPresence() {
  const auto silence = nodes_at_ ? std::optional<std::chrono::nanoseconds>(Clock::now() - *nodes_at_) : std::nullopt;
  const std::uint8_t presence = evaluatorPresence(silence, ros_->gone);
  if (std::exchange(statuses_[kEvaluator].presence, presence) == presence) {
    return;
  }
  if (presence != NodeStatus::ALIVE) {  // nothing is known of the nodes that it watches
    for (NodeStatus& status : statuses_) {
      status.presence = NodeStatus::WAITING;
    }
    statuses_[kEvaluator].presence = presence;
  }
  if (presence == NodeStatus::LOST) {
    progress_ = {};  // the latched messages of the next evaluator follow
    heard_ = seeking_ = false;
    next_seek_.reset();
    Q_EMIT progressed();
  }
  Q_EMIT nodesChanged();
}

void EvaluatorLink::start(const pusht_msgs::CompareGoal& goal) {
  if (!served_) {
    Q_EMIT goalEnded(true, "no node serves " + evaluator() + "/compare");
    return;
  }
  ros_->goal = ros_->client->sendGoal(goal, [this](const Client::GoalHandle& sent) { follow(sent, *this); });
}

void EvaluatorLink::control(const pusht_msgs::ControlRequest& request) {
  if (!worker_) {
    return;
  }
  worker_->ask([this, ros = ros_, request] {
    pusht_msgs::Control command;
    command.request = request;
    const bool answered = ros->command(command);
    ros->post([this, word = request.command, done = answered && command.response.success != 0,
               message = answered ? command.response.message : request.command + ": the evaluator does not answer"] {
      onControl(word, done, message);
    });
  });
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

void EvaluatorLink::onControl(const std::string& command, bool done, const std::string& message) {
  if (done) {
    Q_EMIT obeyed();
  } else {
    Q_EMIT refused(QString::fromStdString(message));
  }
  if (command == pusht_msgs::ControlRequest::SEEK) {
    seeking_ = false;
    seekNext();
  }
}

void EvaluatorLink::describe(Node node, const QString& kind) {
  if (!worker_) {
    return;
  }
  worker_->ask([this, ros = ros_, node, services = services_.at(node), kind = kind.toStdString()] {
    pusht_msgs::Describe describe;
    describe.request.kind = kind;
    const ros::ServiceClient client = connectionTo<pusht_msgs::Describe>(services + "/describe");
    const bool answered = ros->calling->make(client, describe) == Outcome::kAnswered;
    ros->post([this, node, kind, answered, description = describe.response] {
      onDescription(node, kind, answered ? &description : nullptr);
    });
  });
}

void EvaluatorLink::onDescription(Node node, const std::string& kind, const pusht_msgs::DescribeResponse* description) {
  if (description == nullptr) {
    known_.at(node).clear();  // it is asked again when it is there
  } else {
    Q_EMIT described(node, QString::fromStdString(kind), *description);
  }
}

void EvaluatorLink::askForEpisodes() {
  worker_->ask([this, ros = ros_, number = ++episodes_request_] {
    pusht_msgs::Episodes episodes;
    const ros::ServiceClient client = connectionTo<pusht_msgs::Episodes>(ros->evaluator + "/episodes");
    if (ros->calling->make(client, episodes) != Outcome::kAnswered) {
      return;
    }
    ros->post([this, number, answer = std::move(episodes.response)] {
      if (number != episodes_request_) {
        return;  // of an earlier run
      }
      if (!answer.episodes.empty()) {
        Q_EMIT episodesFinished(answer.episodes);
      }
      Q_EMIT recalled(answer.curve);
    });
  });
}

void EvaluatorLink::onProgress(const pusht_msgs::Progress& progress) {
  const bool first = !std::exchange(heard_, true);
  const bool begins = first || progress.run != progress_.run;
  progress_ = progress;
  if (begins) {
    ++episodes_request_;
    Q_EMIT runBegan();
  }
  if (first) {
    askForEpisodes();
  }
  Q_EMIT progressed();
}

void EvaluatorLink::onEpisode(const pusht_msgs::EpisodeResult& episode) { Q_EMIT episodesFinished({episode}); }

void EvaluatorLink::onRequest(const pusht_msgs::CompareGoal& request) {
  const auto first = [](const std::vector<std::string>& names) {
    return names.empty() ? std::string() : names.front();
  };
  services_ = {first(request.reference_namespace), first(request.engine_namespace)};
  known_ = {};
  Q_EMIT requestCame(request);
}

void EvaluatorLink::onNodes(const pusht_msgs::Nodes& nodes) {
  nodes_at_ = Clock::now();
  NodeStatuses now;
  now[kEvaluator] = statuses_[kEvaluator];
  for (const NodeStatus& status : nodes.nodes) {
    for (std::size_t node = 0; node < kEvaluator; ++node) {
      if (status.role == kNodeNames.at(node)) {
        now.at(node) = status;
      }
    }
  }
  QStringList policies;
  for (const std::string& policy : nodes.policies) {
    policies << QString::fromStdString(policy);
  }
  if (now != statuses_ || policies != policies_) {
    statuses_ = now;
    policies_ = policies;
    Q_EMIT nodesChanged();
  }
  for (const Node node : {kReference, kEngine}) {
    const NodeStatus& status = statuses_.at(node);
    if (status.presence == NodeStatus::ALIVE && status.services == services_.at(node) &&
        std::exchange(known_.at(node), identityOf(status)) != identityOf(status)) {
      describe(node, "");
    }
  }
}

}  // namespace pusht_rviz
