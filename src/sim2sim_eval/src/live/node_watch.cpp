// SPDX-License-Identifier: BSD-3-Clause
#include "live/node_watch.hpp"

#include <XmlRpcValue.h>
#include <pusht_msgs/Describe.h>
#include <ros/master.h>
#include <ros/this_node.h>

#include <algorithm>
#include <utility>

namespace sim2sim {
namespace {

using pusht_msgs::NodeStatus;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kPeriod{250};
constexpr std::chrono::seconds kSilence{1};
constexpr std::chrono::seconds kPolicyPeriod{2};
constexpr std::array<const char*, kModeCount + 1> kRoles = {"reference", "engine", "replay", "policy"};

/// Namespaces of the policies on this master, sorted; those before if it does not answer.
std::vector<std::string> policiesOr(std::vector<std::string> before) {
  const std::string act = "/act";
  XmlRpc::XmlRpcValue request;
  XmlRpc::XmlRpcValue response;
  XmlRpc::XmlRpcValue lists;  // publishers, subscribers, services
  request[0] = ros::this_node::getName();
  if (!ros::master::execute("getSystemState", request, response, lists, false)) {
    return before;
  }
  std::vector<std::string> policies;
  XmlRpc::XmlRpcValue& served = lists[2];
  for (int i = 0; i < served.size(); ++i) {  // NOLINT(modernize-loop-convert): begin() is of structs
    const std::string& service = served[i][0];
    if (service.size() > act.size() && service.compare(service.size() - act.size(), act.size(), act) == 0) {
      policies.push_back(service.substr(0, service.size() - act.size()));
    }
  }
  std::sort(policies.begin(), policies.end());
  return policies;
}

}  // namespace

std::uint8_t presenceAfter(std::uint8_t presence, Answer answer) {
  switch (answer) {
    case Answer::kGiven:
      return NodeStatus::ALIVE;
    case Answer::kLate:
      return NodeStatus::SILENT;
    case Answer::kNone:
      break;
  }
  return presence == NodeStatus::WAITING ? NodeStatus::WAITING : NodeStatus::LOST;
}

NodeWatch::NodeWatch(ros::NodeHandle& node, LiveNodes::Services services)
    : topic_(node.advertise<pusht_msgs::Nodes>("nodes", 1)),
      watchdog_(kSilence),
      services_(std::move(services)),
      thread_([this] { watch(); }) {}

NodeWatch::~NodeWatch() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void NodeWatch::follow(const LiveNodes::Services& services) {
  const std::lock_guard<std::mutex> lock(mutex_);
  services_ = services;
}

LiveNodes::Services NodeWatch::services() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return services_;
}

bool NodeWatch::ends(std::chrono::milliseconds period) {
  std::unique_lock<std::mutex> lock(mutex_);
  return changed_.wait_for(lock, period, [this] { return ending_; });
}

void NodeWatch::watch() {
  Clock::time_point next_policies;
  while (!ends(kPeriod)) {
    if (topic_.getNumSubscribers() == 0) {
      continue;
    }
    if (Clock::now() >= next_policies) {
      policies_ = policiesOr(std::move(policies_));
      next_policies = Clock::now() + kPolicyPeriod;
    }
    const LiveNodes::Services now = services();
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      Watched& node = nodes_.at(i);
      const std::string& wanted = i < kModeCount ? now.worlds.at(i) : now.policy;
      if (node.status.services != wanted) {
        node = {};
        node.status.role = kRoles.at(i);
        node.status.services = wanted;
      }
    }
    for (Watched& node : nodes_) {
      if (ends({})) {
        return;
      }
      ask(node);
      publish();
    }
  }
}

void NodeWatch::ask(Watched& node) {
  if (!node.client.isValid()) {
    if (node.status.presence == NodeStatus::ALIVE) {  // though another may be there already
      node.status.presence = NodeStatus::LOST;
      return;
    }
    node.client = ros::NodeHandle().serviceClient<pusht_msgs::Describe>(node.status.services + "/describe", true);
  }
  pusht_msgs::Describe describe;
  Answer answer = Answer::kNone;
  bool late = false;
  watchdog_.run(
      [&] {
        if (node.client.isValid() && node.client.call(describe)) {
          answer = Answer::kGiven;
        }
      },
      [&] {
        late = true;
        node.client.shutdown();
      });
  if (answer != Answer::kGiven) {
    answer = late ? Answer::kLate : Answer::kNone;
    node.client.shutdown();  // a roscpp client whose connection was refused early stays valid
  }
  node.status.presence = presenceAfter(node.status.presence, answer);
  if (answer == Answer::kGiven) {
    const pusht_msgs::DescribeResponse& now = describe.response;
    node.status.instance_id = now.instance_id;
    node.status.parameters_hash = now.parameters_hash;
    node.status.title = now.title.empty() ? now.name : now.title;
    node.status.failure = now.success != 0 ? "" : now.message;
  }
}

void NodeWatch::publish() const {
  pusht_msgs::Nodes message;
  for (const Watched& node : nodes_) {
    message.nodes.push_back(node.status);
  }
  message.policies = policies_;
  topic_.publish(message);
}

}  // namespace sim2sim
