// SPDX-License-Identifier: BSD-3-Clause
/// Running a protocol in several threads.
#pragma once

#include <functional>
#include <memory>
#include <set>

#include "pusht_task/policy.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/flight.hpp"
#include "sim2sim_protocol/protocol.hpp"

namespace sim2sim {

class ReferenceCache;

/// Episodes in flight in each thread: enough for the engine's lanes and the policy's batches.
constexpr int kEpisodesInFlight = 8;

/// Factories for each thread's own worlds and policy.
struct WorkerFactory {
  std::function<Worlds(int lanes)> make_worlds;
  std::function<std::unique_ptr<pusht::Policy>()> make_policy;
};

/// Runs the protocol in `threads` threads. `deliver` gets every episode when it has finished, not in order but one at a
/// time; `stop` is asked before every control step of the modes and ends the run early when true. Neither the reference
/// nor its floor is rolled out for episodes that are in `references`; those of the others are kept there. Results
/// depend neither on the number of threads nor on `references`.
void runProtocol(const Protocol& protocol, const WorkerFactory& factory, int threads, const ReferenceCache* references,
                 const std::function<void(Episode&&)>& deliver, const std::function<bool()>& stop,
                 const std::set<int>& finished = {});

}  // namespace sim2sim
