// SPDX-License-Identifier: BSD-3-Clause
/// The types of the task as messages, and back; every bit is kept. What a node says of itself.
#pragma once

#include <pusht_msgs/Describe.h>
#include <pusht_msgs/PixelState.h>
#include <pusht_msgs/WorldState.h>

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <vector>

#include "pusht_task/gym_pusht.hpp"
#include "pusht_task/types.hpp"

namespace pusht {

/// Message with the numbers of a state, bit for bit.
pusht_msgs::WorldState toMessage(const WorldState& state);
/// State with the numbers of a message, bit for bit.
WorldState fromMessage(const pusht_msgs::WorldState& message);
/// Message with the numbers of a state in pixels, bit for bit.
pusht_msgs::PixelState toMessage(const gym_pusht::State& state);
/// State in pixels with the numbers of a message, bit for bit.
gym_pusht::State fromMessage(const pusht_msgs::PixelState& message);

/// State in pixels that a node reports beside `state`; none if it reports none. Throws BadDependency if it reports
/// several, or one whose poses are not those of `state` to kStartTolerance [m, rad].
std::optional<gym_pusht::State> inPixels(const std::vector<pusht_msgs::PixelState>& reported, const WorldState& state);

/// Provenance that a node reports, with its "version": all that its numbers depend on. Throws BadDependency if it is no
/// JSON object.
nlohmann::json provenanceOf(const pusht_msgs::DescribeResponse& node);

}  // namespace pusht
