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

/// Episodes in flight at once in each thread: enough for the engine's lanes and the policy's batches.
constexpr int kEpisodesInFlight = 8;

/// Maximum number of episodes, for each thread, that are in flight or wait to be delivered after an earlier one. A
/// thread that would run farther ahead waits, so memory does not grow with the number of episodes: an episode is about
/// 0.2 MB. Waiting is rare: episodes that end early overtake a long one by fewer than this, mostly.
constexpr int kEpisodesHeld = 8 * kEpisodesInFlight;

/// Factories for each thread's own worlds and policy. They are called in the thread that uses the result.
struct WorkerFactory {
  std::function<Worlds(int lanes)> make_worlds;
  std::function<std::unique_ptr<pusht::Policy>()> make_policy;
  std::function<VariantWorlds()> make_variants{};  ///< empty: the protocol has no model variants
  bool one_at_a_time = false;  ///< run one episode at a time, in the calling thread: there is one world of a simulator
};

/// Runs the episodes of `protocol` in `threads` >= 1 threads (in one if `factory` says so), without those in
/// `finished`. Results depend neither on the number of threads nor on `references`. `deliver` gets the finished
/// episodes in the order of their indices, one at a time, in any of the threads. `stop` is asked before every control
/// step of the modes and before every delivery, by several threads at once; when it is true the run ends early, and
/// what is in flight or waits for delivery is lost. `references` (null: none) has traces of the reference, which are
/// not simulated again; the others are added to it. Throws InvalidInput as Protocol::validate(), RuntimeFault if a
/// thread cannot be started, and what worlds, policy, `deliver` and the cache throw; the first error ends all threads.
void runProtocol(const Protocol& protocol, const WorkerFactory& factory, int threads, const ReferenceCache* references,
                 const std::function<void(Episode&&)>& deliver, const std::function<bool()>& stop,
                 const std::set<int>& finished = {});

}  // namespace sim2sim
