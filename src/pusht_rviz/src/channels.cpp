// SPDX-License-Identifier: BSD-3-Clause
#include "channels.hpp"

#include <XmlRpcValue.h>
#include <pusht_msgs/Control.h>
#include <pusht_msgs/Describe.h>
#include <pusht_msgs/Episodes.h>
#include <ros/master.h>
#include <ros/node_handle.h>
#include <ros/service_client.h>
#include <ros/this_node.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <utility>
#include <vector>

namespace pusht_rviz {
namespace {

/// Persistent connection to a service.
class RosConnection : public Connection {
 public:
  explicit RosConnection(const ros::ServiceClient& client) : client_(client) {}
  bool stands() const override { return client_.isValid(); }
  void close() override { client_.shutdown(); }
  ros::ServiceClient& client() { return client_; }

 private:
  ros::ServiceClient client_;
};

/// Stand-in for the master, which roscpp connects to anew for every call.
class MasterConnection : public Connection {
 public:
  bool stands() const override { return true; }
  void close() override {}  // roscpp cannot break off a call to the master
};

template <class Service>
ServiceChannel::Connect connectTo(const std::string& service) {
  return [service] { return std::make_shared<RosConnection>(ros::NodeHandle().serviceClient<Service>(service, true)); };
}

/// Call of a service; `tell` gets whether there was an answer, and the answer.
template <class Service, class TellAnswer>
ServiceChannel::Call callOf(const typename Service::Request& request, TellAnswer tell) {
  return [request, tell](Connection& connection) {
    Service service;
    service.request = request;
    const bool answered = static_cast<RosConnection&>(connection).client().call(service);
    tell(answered, service.response);
    return answered;
  };
}

ServiceChannel::Tell tellPresence(const std::shared_ptr<Events>& events, Node node) {
  return [events, node](Presence presence) { events->push(PresenceEvent{node, presence}); };
}

ServiceChannel::Tell tellNothing() {
  return [](Presence /*presence*/) {};
}

/// Empty command. The evaluator refuses it, which shows that it answers and changes nothing.
ServiceChannel::Call emptyCommand() {
  return callOf<pusht_msgs::Control>({}, [](bool /*answered*/, const pusht_msgs::ControlResponse& /*response*/) {});
}

/// Elements of a list: XmlRpcValue has iterators for structs alone.
std::vector<XmlRpc::XmlRpcValue> elementsOf(XmlRpc::XmlRpcValue& list) {
  std::vector<XmlRpc::XmlRpcValue> elements(static_cast<std::size_t>(list.size()));
  int next = 0;
  std::generate(elements.begin(), elements.end(), [&] { return list[next++]; });
  return elements;
}

/// Asks the master which policies there are. False: there was no answer.
bool askMaster(Events& events) {
  const std::string act = "/act";
  XmlRpc::XmlRpcValue request;
  XmlRpc::XmlRpcValue response;
  XmlRpc::XmlRpcValue lists;
  request[0] = ros::this_node::getName();
  if (!ros::master::execute("getSystemState", request, response, lists, false)) {
    return false;
  }
  MasterEvent event;
  for (XmlRpc::XmlRpcValue& served : elementsOf(lists[2])) {
    const std::string& service = served[0];
    if (service.size() > act.size() && service.compare(service.size() - act.size(), act.size(), act) == 0) {
      event.policies.push_back(service.substr(0, service.size() - act.size()));
    }
  }
  std::sort(event.policies.begin(), event.policies.end());
  events.push(std::move(event));
  return true;
}

}  // namespace

ServiceChannel::Call controlCall(const std::shared_ptr<Events>& events, const pusht_msgs::ControlRequest& request) {
  return callOf<pusht_msgs::Control>(
      request, [events, command = request.command](bool answered, const pusht_msgs::ControlResponse& response) {
        events->push(ControlEvent{command, answered && response.success != 0,
                                  answered ? response.message : command + ": the evaluator does not answer"});
      });
}

ServiceChannel::Call describeCall(const std::shared_ptr<Events>& events, Node node, const std::string& kind) {
  pusht_msgs::DescribeRequest request;
  request.kind = kind;
  return callOf<pusht_msgs::Describe>(
      request, [events, node, kind](bool answered, const pusht_msgs::DescribeResponse& description) {
        events->push(DescriptionEvent{node, kind, answered, description});
      });
}

std::unique_ptr<ServiceChannel> controlChannel(const std::string& evaluator, const std::shared_ptr<Events>& events) {
  return std::make_unique<ServiceChannel>(connectTo<pusht_msgs::Control>(evaluator + "/control"), emptyCommand(),
                                          tellPresence(events, kEvaluator));
}

std::unique_ptr<ServiceChannel> nodeChannel(const std::string& service, const std::shared_ptr<Events>& events,
                                            Node node) {
  return std::make_unique<ServiceChannel>(connectTo<pusht_msgs::Describe>(service), describeCall(events, node, ""),
                                          tellPresence(events, node));
}

std::unique_ptr<ServiceChannel> episodesChannel(const std::string& evaluator, const std::shared_ptr<Events>& events,
                                                std::uint64_t request) {
  ServiceChannel::Times once;
  once.heartbeat = std::chrono::hours(1);
  const auto tell = [events, request](bool answered, const pusht_msgs::EpisodesResponse& response) {
    if (answered) {
      events->push(EpisodesEvent{request, response.episodes, response.curve});
    }
  };
  return std::make_unique<ServiceChannel>(connectTo<pusht_msgs::Episodes>(evaluator + "/episodes"),
                                          callOf<pusht_msgs::Episodes>({}, tell), tellNothing(), once);
}

std::unique_ptr<ServiceChannel> masterChannel(const std::shared_ptr<Events>& events) {
  ServiceChannel::Times slow;
  slow.tick = slow.heartbeat = std::chrono::seconds(2);
  return std::make_unique<ServiceChannel>([] { return std::make_shared<MasterConnection>(); },
                                          [events](Connection& /*connection*/) { return askMaster(*events); },
                                          tellNothing(), slow);
}

}  // namespace pusht_rviz
