// SPDX-License-Identifier: BSD-3-Clause
/// The types of the task as messages, and back; every bit is kept.
#pragma once

#include <pusht_msgs/WorldState.h>

#include "pusht_task/types.hpp"

namespace pusht {

/// Message with the numbers of a state, bit for bit.
pusht_msgs::WorldState toMessage(const WorldState& state);
/// State with the numbers of a message, bit for bit.
WorldState fromMessage(const pusht_msgs::WorldState& message);

}  // namespace pusht
