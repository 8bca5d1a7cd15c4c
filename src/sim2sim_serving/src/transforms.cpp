// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_serving/transforms.hpp"

#include <cmath>

#include "pusht_task/constants.hpp"

namespace pusht {
namespace {

geometry_msgs::TransformStamped onTable(const std::string& prefix, const char* child, const Eigen::Vector2d& position,
                                        double height, double yaw, const ros::Time& stamp) {
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
}

}  // namespace

std::vector<geometry_msgs::TransformStamped> movingFrames(const std::string& prefix, const WorldState& state,
                                                          const ros::Time& stamp) {
  return {onTable(prefix, "pusher", state.pusher_position, kPusherFrameHeight, 0.0, stamp),
          onTable(prefix, "tee", state.tee_position, kTeeFrameHeight, state.tee_yaw, stamp)};
}

geometry_msgs::TransformStamped targetFrame(const std::string& prefix, const Pose& target) {
  return onTable(prefix, "target", target.position, 0.0, target.yaw, ros::Time());
}

}  // namespace pusht
