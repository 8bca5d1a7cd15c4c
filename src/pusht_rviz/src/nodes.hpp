// SPDX-License-Identifier: BSD-3-Clause
/// The nodes of a comparison.
#pragma once

#include <pusht_msgs/NodeStatus.h>

#include <array>
#include <cstddef>

namespace pusht_rviz {

/// In the order in which they are shown.
enum Node : std::size_t { kReference, kEngine, kReplay, kPolicy, kEvaluator };
inline constexpr std::size_t kNodes = 5;
inline constexpr std::array<const char*, kNodes> kNodeNames = {"reference", "engine", "replay", "policy", "evaluator"};

/// Status of each, by Node.
using NodeStatuses = std::array<pusht_msgs::NodeStatus, kNodes>;

}  // namespace pusht_rviz
