// SPDX-License-Identifier: BSD-3-Clause
/// Numbers of a world state, one by one: in tables, messages and refusals.
#pragma once

#include <array>
#include <string_view>

#include "pusht_task/types.hpp"

namespace pusht {

/// Number of a world state, as WorldState.msg names it.
struct StateField {
  const char* name;
  std::string_view unit;
  double& (*of)(WorldState& state);

  constexpr bool isVelocity() const { return unit.find("/s") != std::string_view::npos; }
};

/// All numbers of a world state, in the order of the message.
inline constexpr std::array<StateField, 10> kStateFields = {{
    {"pusher_x", "m", [](WorldState& state) -> double& { return state.pusher_position.x(); }},
    {"pusher_y", "m", [](WorldState& state) -> double& { return state.pusher_position.y(); }},
    {"pusher_vx", "m/s", [](WorldState& state) -> double& { return state.pusher_velocity.x(); }},
    {"pusher_vy", "m/s", [](WorldState& state) -> double& { return state.pusher_velocity.y(); }},
    {"tee_x", "m", [](WorldState& state) -> double& { return state.tee_position.x(); }},
    {"tee_y", "m", [](WorldState& state) -> double& { return state.tee_position.y(); }},
    {"tee_yaw", "rad", [](WorldState& state) -> double& { return state.tee_yaw; }},
    {"tee_vx", "m/s", [](WorldState& state) -> double& { return state.tee_velocity.x(); }},
    {"tee_vy", "m/s", [](WorldState& state) -> double& { return state.tee_velocity.y(); }},
    {"tee_yaw_rate", "rad/s", [](WorldState& state) -> double& { return state.tee_yaw_rate; }},
}};

}  // namespace pusht
