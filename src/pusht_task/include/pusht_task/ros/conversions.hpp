// SPDX-License-Identifier: BSD-3-Clause
/// The types of the task as messages, and back; every bit is kept.
#pragma once

#include <pusht_msgs/WorldState.h>

#include "pusht_task/types.hpp"

namespace pusht {

pusht_msgs::WorldState toMessage(const WorldState& state);
WorldState fromMessage(const pusht_msgs::WorldState& message);

}  // namespace pusht
