// SPDX-License-Identifier: BSD-3-Clause
/// The golden vectors, for tests. They were made with the course's own numpy engine and with MuJoCo 2.2.2
/// (see data/README.md).
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>

#include "pusht_task/types.hpp"

namespace pusht::testing {

/// The list `key` of a file of the golden folder. By value: a reference would dangle in a range-for.
nlohmann::json loadGolden(const std::string& name, const std::string& key);

/// Two consecutive numbers of a row.
Eigen::Vector2d vector2(const nlohmann::json& row, std::size_t first = 0);

/// Action from a pair of numbers in JSON.
Action action(const nlohmann::json& pair);

/// A row of `qpos_qvel`: tee x, y, yaw, pusher x, y, then their velocities.
WorldState worldState(const nlohmann::json& row);

/// A row of `expert_actions.json`: tee x, y, yaw, pusher x, y.
WorldState worldPose(const nlohmann::json& row);

}  // namespace pusht::testing
