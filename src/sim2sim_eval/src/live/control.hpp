// SPDX-License-Identifier: BSD-3-Clause
/// Service `control`: the commands that live runs and playbacks share.
#pragma once

#include <pusht_msgs/Control.h>

#include <functional>

#include "live/pacer.hpp"

namespace sim2sim {

/// Carries out the commands pause, resume, step and rate. Throws InvalidInput with command, value and rule for any
/// other.
void applyControl(Pacer& pacer, const pusht_msgs::ControlRequest& request);

/// Response to a command: success, or the message of the InvalidInput that `serve` throws.
pusht_msgs::ControlResponse controlResponse(const std::function<void()>& serve);

}  // namespace sim2sim
