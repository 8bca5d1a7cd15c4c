// SPDX-License-Identifier: BSD-3-Clause
/// A world as frames.
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>

#include <string>
#include <vector>

#include "pusht_task/types.hpp"

namespace pusht {

/// From `<prefix>/table` to what moves: `<prefix>/pusher` and `<prefix>/tee`.
std::vector<geometry_msgs::TransformStamped> movingFrames(const std::string& prefix, const WorldState& state,
                                                          const ros::Time& stamp);

/// From `<prefix>/table` to `<prefix>/target`, which never moves.
geometry_msgs::TransformStamped targetFrame(const std::string& prefix);

}  // namespace pusht
