// SPDX-License-Identifier: BSD-3-Clause
/// Events that the threads that talk to ROS report to the thread of the GUI: messages, answers, and changes.
#pragma once

#include <pusht_msgs/CompareGoal.h>
#include <pusht_msgs/DescribeResponse.h>
#include <pusht_msgs/Divergence.h>
#include <pusht_msgs/EpisodeResult.h>
#include <pusht_msgs/Progress.h>
#include <pusht_msgs/RunOptions.h>
#include <pusht_msgs/Summary.h>

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "event_queue.hpp"
#include "nodes.hpp"
#include "service_channel.hpp"

namespace pusht_rviz {

/// Acceptance or end of a goal that the panel has sent.
struct GoalEvent {
  bool ended = false;     ///< rejected or done; false: accepted
  bool rejected = false;  ///< then `text` has the rule
  std::string text;
};

/// Begin or end of the service of the action `compare`.
struct ActionEvent {
  bool served = false;
};

/// Change of a node's presence.
struct PresenceEvent {
  Node node = kEvaluator;
  Presence presence = Presence::kWaiting;
};

/// Answer of a node's service `describe`.
struct DescriptionEvent {
  Node node = kEvaluator;
  std::string kind;       ///< kind of simulator that was asked about; empty: the node itself
  bool answered = false;  ///< false: the call has failed
  pusht_msgs::DescribeResponse description;
};

/// Answer to a command.
struct ControlEvent {
  std::string command;
  bool done = false;
  std::string message;  ///< if not done: the reason
};

/// Answer of the service `episodes`.
struct EpisodesEvent {
  std::uint64_t request = 0;  ///< number of the request, as episodesChannel() got it
  std::vector<pusht_msgs::EpisodeResult> episodes;
  std::vector<pusht_msgs::Divergence> curve;  ///< of the episode under way
};

/// State of the master.
struct MasterEvent {
  std::vector<std::string> policies;  ///< namespaces of the services that end in /act
};

using Event = std::variant<pusht_msgs::Progress, pusht_msgs::Divergence, pusht_msgs::EpisodeResult, pusht_msgs::Summary,
                           pusht_msgs::CompareGoal, pusht_msgs::RunOptions, GoalEvent, ActionEvent, PresenceEvent,
                           DescriptionEvent, ControlEvent, EpisodesEvent, MasterEvent>;
using Events = EventQueue<Event>;

}  // namespace pusht_rviz
