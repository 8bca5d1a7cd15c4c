// SPDX-License-Identifier: BSD-3-Clause
/// Watch over the nodes that an evaluator works with, for the panel.
#pragma once

#include <pusht_msgs/Nodes.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/service_client.h>

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "live/live_nodes.hpp"
#include "sim2sim_serving/peer.hpp"

namespace sim2sim {

/// Outcome of a question to a node.
enum class Answer { kGiven, kLate, kNone };

/// Presence after a question, as in NodeStatus. A node that was never there is not lost.
std::uint8_t presenceAfter(std::uint8_t presence, Answer answer);

/// Publishes on the topic `nodes` who is there.
///
/// While the topic has a subscriber, a thread asks each node of the run, one after the other, to describe itself, every
/// 0.25 s; each question must be answered within a second. The topic is published after each answer, so that a node
/// that hangs does not delay the news of the others. Every two seconds the thread asks the master for policies.
class NodeWatch {
 public:
  /// Advertises `nodes` in the namespace of `node`. Begins with the nodes of `services`.
  NodeWatch(ros::NodeHandle& node, LiveNodes::Services services);
  NodeWatch(const NodeWatch&) = delete;
  NodeWatch& operator=(const NodeWatch&) = delete;
  ~NodeWatch();

  /// Watches these nodes from now on. Any thread may call it.
  void follow(const LiveNodes::Services& services);

 private:
  /// A node, with the connection to its service `describe`.
  struct Watched {
    ros::ServiceClient client;
    pusht_msgs::NodeStatus status;
  };

  void watch();
  void ask(Watched& node);
  void publish() const;
  /// Whether the watch ends, within `period` at the latest.
  bool ends(std::chrono::milliseconds period);
  LiveNodes::Services services();

  ros::Publisher topic_;
  pusht::Watchdog watchdog_;

  // Used in the thread alone.
  std::array<Watched, kModeCount + 1> nodes_;
  std::vector<std::string> policies_;

  std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  bool ending_ = false;
  LiveNodes::Services services_;

  std::thread thread_;  // declared last, because it uses the members above
};

}  // namespace sim2sim
