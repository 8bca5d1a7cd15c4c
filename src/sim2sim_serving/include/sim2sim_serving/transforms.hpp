// SPDX-License-Identifier: BSD-3-Clause
/// TF frames of a world.
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>

#include <string>
#include <vector>

#include "pusht_task/coverage.hpp"
#include "pusht_task/types.hpp"

namespace pusht {

/// Transforms from `<prefix>/table` to the moving frames `<prefix>/pusher` and `<prefix>/tee`.
std::vector<geometry_msgs::TransformStamped> movingFrames(const std::string& prefix, const WorldState& state,
                                                          const ros::Time& stamp);

/// Static transform from `<prefix>/table` to `<prefix>/target`, where a task has its target.
geometry_msgs::TransformStamped targetFrame(const std::string& prefix, const Pose& target = {});

}  // namespace pusht
