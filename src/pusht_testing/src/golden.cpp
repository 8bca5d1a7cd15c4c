// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_testing/golden.hpp"

#include <fstream>
#include <stdexcept>

namespace pusht::testing {

nlohmann::json loadGolden(const std::string& name, const std::string& key) {
  std::ifstream file(std::string(PUSHT_GOLDEN_DIR) + "/" + name);
  if (!file) {
    throw std::runtime_error("golden vectors: cannot read " + name);
  }
  nlohmann::json list = nlohmann::json::parse(file).at(key);
  if (list.empty()) {
    throw std::runtime_error("golden vectors: " + name + " has no " + key);
  }
  return list;
}

Eigen::Vector2d vector2(const nlohmann::json& row, std::size_t first) {
  return {row.at(first).get<double>(), row.at(first + 1).get<double>()};
}

Action action(const nlohmann::json& pair) { return {pair.at(0).get<float>(), pair.at(1).get<float>()}; }

WorldState worldState(const nlohmann::json& row) {
  WorldState state = worldPose(row);
  state.tee_velocity = vector2(row, 5);
  state.tee_yaw_rate = row.at(7).get<double>();
  state.pusher_velocity = vector2(row, 8);
  return state;
}

WorldState worldPose(const nlohmann::json& row) {
  WorldState state;
  state.tee_position = vector2(row, 0);
  state.tee_yaw = row.at(2).get<double>();
  state.pusher_position = vector2(row, 3);
  return state;
}

}  // namespace pusht::testing
