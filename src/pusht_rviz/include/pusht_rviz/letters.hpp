// SPDX-License-Identifier: BSD-3-Clause
/// What the threads that talk to ROS have to say.
#pragma once

#include <pusht_msgs/CompareGoal.h>
#include <pusht_msgs/DescribeResponse.h>
#include <pusht_msgs/Divergence.h>
#include <pusht_msgs/EpisodeResult.h>
#include <pusht_msgs/Progress.h>
#include <pusht_msgs/Summary.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "pusht_rviz/line.hpp"
#include "pusht_rviz/mailbox.hpp"

namespace pusht_rviz {

/// The nodes of a comparison, in the order in which they are shown.
enum Role : std::size_t { kReference, kEngine, kReplay, kPolicy, kEvaluator };
inline constexpr std::size_t kRoles = 5;
inline constexpr std::array<const char*, kRoles> kRoleNames = {"reference", "engine", "replay", "policy", "evaluator"};

/// A goal of ours was accepted, or has ended.
struct GoalNews {
  bool ended = false;     ///< rejected, or done
  bool rejected = false;  ///< then `text` has the rule
  std::string text;
};

/// The action `compare` is served, or no more.
struct ActionNews {
  bool served = false;
};

/// Change of a node's presence.
struct PresenceNews {
  Role role = kEvaluator;
  Presence presence = Presence::kWaiting;
};

/// A node describes itself; or, with a kind, that kind.
struct DescriptionNews {
  Role role = kEvaluator;
  std::string kind;
  bool answered = false;
  pusht_msgs::DescribeResponse description;
};

/// Answer to a command.
struct ControlNews {
  std::string command;
  bool done = false;
  std::string message;  ///< if not: why
};

/// Answer of the service `episodes`.
struct EpisodesNews {
  std::uint64_t request = 0;  ///< which was asked with this number
  std::vector<pusht_msgs::EpisodeResult> episodes;
  std::vector<pusht_msgs::Divergence> curve;  ///< of the episode under way
};

/// What the master knows.
struct MasterNews {
  std::vector<std::string> policies;  ///< namespaces of services that end in /act
  bool knows_us = false;              ///< as a subscriber of `progress`; a new master knows nothing
};

/// The topics are subscribed.
struct SessionNews {};

using Letter = std::variant<pusht_msgs::Progress, pusht_msgs::Divergence, pusht_msgs::EpisodeResult,
                            pusht_msgs::Summary, pusht_msgs::CompareGoal, GoalNews, ActionNews, PresenceNews,
                            DescriptionNews, ControlNews, EpisodesNews, MasterNews, SessionNews>;
using Post = Mailbox<Letter>;

}  // namespace pusht_rviz
