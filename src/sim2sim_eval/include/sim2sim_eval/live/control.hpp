// SPDX-License-Identifier: BSD-3-Clause
/// The service `control`, as far as live runs and replays have it in common.
#pragma once

#include <pusht_msgs/Control.h>

#include <functional>

#include "sim2sim_eval/live/pacer.hpp"

namespace sim2sim {

/// Pauses, resumes, steps or paces. Throws InvalidInput with command, value and rule for anything else.
void applyControl(Pacer& pacer, const pusht_msgs::ControlRequest& request);

/// The answer to a command that `serve` carries out, or that it refuses by InvalidInput.
pusht_msgs::ControlResponse controlResponse(const std::function<void()>& serve);

}  // namespace sim2sim
