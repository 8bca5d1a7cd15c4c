// SPDX-License-Identifier: BSD-3-Clause
/// A world as frames.
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>

#include <string>
#include <vector>

#include "pusht_task/types.hpp"

namespace pusht {

/// From `<prefix>/table` to `<prefix>/pusher`, `<prefix>/tee` and `<prefix>/target`.
std::vector<geometry_msgs::TransformStamped> toTransforms(const std::string& prefix, const WorldState& state,
                                                          const ros::Time& stamp);

}  // namespace pusht
