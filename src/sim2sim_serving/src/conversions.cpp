// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_serving/conversions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/json_text.hpp"
#include "pusht_task/numbers.hpp"

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

std::optional<gym_pusht::State> inPixels(const std::vector<pusht_msgs::PixelState>& reported, const WorldState& state) {
  if (reported.empty()) {
    return std::nullopt;
  }
  const gym_pusht::State in_pixels = fromMessage(reported.front());
  const WorldState same = gym_pusht::toTable(in_pixels);
  const std::array<double, 3> off = {(same.pusher_position - state.pusher_position).norm(),
                                     (same.tee_position - state.tee_position).norm(),
                                     std::abs(wrapAngle(same.tee_yaw - state.tee_yaw))};
  const auto is_small = [](double error) { return error <= kStartTolerance; };
  if (reported.size() > 1 || !std::all_of(off.begin(), off.end(), is_small)) {
    throw BadDependency("state_in_pixels: must be one, with the poses of the state to " +
                        shortestText(kStartTolerance) + " m and rad, or none");
  }
  return in_pixels;
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
