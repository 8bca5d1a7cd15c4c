// SPDX-License-Identifier: BSD-3-Clause
/// Episode cut off after a number of control steps.
#pragma once

#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"

namespace sim2sim {

/// State of the episode `whole` after `steps` control steps, or after its last one. Without probes.
Episode truncatedEpisode(const Protocol& protocol, const Episode& whole, int steps);

}  // namespace sim2sim
