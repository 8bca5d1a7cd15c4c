// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_serving/conversions.hpp"

#include <nlohmann/json.hpp>

#include "pusht_task/error.hpp"
#include "pusht_task/json_text.hpp"

namespace pusht {

pusht_msgs::WorldState toMessage(const WorldState& state) {
  pusht_msgs::WorldState message;
  message.pusher_x = state.pusher_position.x();
  message.pusher_y = state.pusher_position.y();
  message.pusher_vx = state.pusher_velocity.x();
  message.pusher_vy = state.pusher_velocity.y();
  message.tee_x = state.tee_position.x();
  message.tee_y = state.tee_position.y();
  message.tee_yaw = state.tee_yaw;
  message.tee_vx = state.tee_velocity.x();
  message.tee_vy = state.tee_velocity.y();
  message.tee_yaw_rate = state.tee_yaw_rate;
  return message;
}

WorldState fromMessage(const pusht_msgs::WorldState& message) {
  WorldState state;
  state.pusher_position = {message.pusher_x, message.pusher_y};
  state.pusher_velocity = {message.pusher_vx, message.pusher_vy};
  state.tee_position = {message.tee_x, message.tee_y};
  state.tee_yaw = message.tee_yaw;
  state.tee_velocity = {message.tee_vx, message.tee_vy};
  state.tee_yaw_rate = message.tee_yaw_rate;
  return state;
}

pusht_msgs::PixelState toMessage(const gym_pusht::State& state) {
  pusht_msgs::PixelState message;
  message.pusher_x = state.pusher.x();
  message.pusher_y = state.pusher.y();
  message.pusher_vx = state.pusher_velocity.x();
  message.pusher_vy = state.pusher_velocity.y();
  message.tee_x = state.tee.x();
  message.tee_y = state.tee.y();
  message.angle = state.angle;
  message.tee_vx = state.tee_velocity.x();
  message.tee_vy = state.tee_velocity.y();
  message.rate = state.rate;
  return message;
}

gym_pusht::State fromMessage(const pusht_msgs::PixelState& message) {
  gym_pusht::State state;
  state.pusher = {message.pusher_x, message.pusher_y};
  state.pusher_velocity = {message.pusher_vx, message.pusher_vy};
  state.tee = {message.tee_x, message.tee_y};
  state.angle = message.angle;
  state.tee_velocity = {message.tee_vx, message.tee_vy};
  state.rate = message.rate;
  return state;
}

nlohmann::json provenanceOf(const pusht_msgs::DescribeResponse& node) {
  nlohmann::json provenance = parseJson(node.provenance);
  if (!provenance.is_object()) {
    throw BadDependency(node.name + ": provenance '" + node.provenance + "': must be a JSON object");
  }
  provenance.emplace("version", node.version);
  return provenance;
}

}  // namespace pusht
