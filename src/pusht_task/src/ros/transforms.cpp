// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/ros/transforms.hpp"

#include <cmath>

#include "pusht_task/constants.hpp"

namespace pusht {

std::vector<geometry_msgs::TransformStamped> toTransforms(const std::string& prefix, const WorldState& state,
                                                          const ros::Time& stamp) {
  const auto transform = [&](const char* child, const Eigen::Vector2d& position, double height, double yaw) {
    geometry_msgs::TransformStamped message;
    message.header.frame_id = prefix + "/table";
    message.header.stamp = stamp;
    message.child_frame_id = prefix + "/" + child;
    message.transform.translation.x = position.x();
    message.transform.translation.y = position.y();
    message.transform.translation.z = height;
    message.transform.rotation.z = std::sin(0.5 * yaw);
    message.transform.rotation.w = std::cos(0.5 * yaw);
    return message;
  };
  return {transform("pusher", state.pusher_position, kPusherFrameHeight, 0.0),
          transform("tee", state.tee_position, kTeeFrameHeight, state.tee_yaw),
          transform("target", Eigen::Vector2d::Zero(), 0.0, 0.0)};
}

}  // namespace pusht
