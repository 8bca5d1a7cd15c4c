// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <set>

#include "sim2sim_protocol/protocol.hpp"

namespace sim2sim {

/// runProtocol() for a run that goes on: the episodes in `finished`, by index, are not run.
void runRest(const Protocol& protocol, const std::set<int>& finished, const Players& players, int threads,
             const ReferenceCache* references, const std::function<void(Episode&&)>& deliver,
             const std::function<bool()>& stop);

}  // namespace sim2sim
