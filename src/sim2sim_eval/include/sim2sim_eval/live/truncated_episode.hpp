// SPDX-License-Identifier: BSD-3-Clause
/// The begin of an episode.
#pragma once

#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"

namespace sim2sim {

/// `whole` as it was after `steps` control steps, or after its last one.
Episode truncatedEpisode(const Protocol& protocol, const Episode& whole, int steps);

}  // namespace sim2sim
