// SPDX-License-Identifier: BSD-3-Clause
/// The golden vectors, for tests. They were made with the course's own numpy engine and with MuJoCo 2.2.2
/// (see test/data/README.md).
#pragma once

#include <Eigen/Core>
#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "pusht_task/types.hpp"

namespace pusht::testing {

/// The list `key` of a file of the golden folder. By value: a reference would dangle in a range-for.
inline nlohmann::json loadGolden(const std::string& name, const std::string& key) {
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

/// Two consecutive numbers of a row.
inline Eigen::Vector2d vector2(const nlohmann::json& row, std::size_t first = 0) {
  return {row.at(first).get<double>(), row.at(first + 1).get<double>()};
}

/// Action from a pair of numbers in JSON.
inline Action action(const nlohmann::json& pair) { return {pair.at(0).get<float>(), pair.at(1).get<float>()}; }

/// A row of `qpos_qvel`: tee x, y, yaw, pusher x, y, then their velocities.
inline WorldState worldState(const nlohmann::json& row) {
  WorldState state;
  state.tee_position = vector2(row, 0);
  state.tee_yaw = row.at(2).get<double>();
  state.pusher_position = vector2(row, 3);
  state.tee_velocity = vector2(row, 5);
  state.tee_yaw_rate = row.at(7).get<double>();
  state.pusher_velocity = vector2(row, 8);
  return state;
}

/// A row of `expert_actions.json`: tee x, y, yaw, pusher x, y.
inline WorldState worldPose(const nlohmann::json& row) {
  WorldState state;
  state.tee_position = vector2(row, 0);
  state.tee_yaw = row.at(2).get<double>();
  state.pusher_position = vector2(row, 3);
  return state;
}

}  // namespace pusht::testing
