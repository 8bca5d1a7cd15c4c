// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/runner.hpp"

#include <algorithm>
#include <atomic>
#include <future>
#include <mutex>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "pusht_task/error.hpp"
#include "sim2sim_protocol/reference_cache.hpp"

namespace sim2sim {
namespace {

/// The name in a reference cache of what the policy does in the reference.
constexpr const char* kKeptReference = "reference";

/// What is kept of an episode.
CachedTraces cachedTraces(const Protocol& protocol, int episode, const ReferenceCache& references) {
  const std::string start = protocol.initialStateKey(episode);
  CachedTraces cached{references.find(start, kKeptReference), {}};
  for (const Probe& probe : protocol.probes()) {
    cached.probes.push_back(probe.world == ProbedWorld::kReference ? references.find(start, probe.name) : std::nullopt);
  }
  return cached;
}

/// Keeps all of an episode that depends on the reference alone.
void keep(const Protocol& protocol, const Episode& episode, const ReferenceCache& references) {
  const std::string start = protocol.initialStateKey(episode.index());
  const std::vector<Probe> probes = protocol.probes();
  for (std::size_t i = 0; i < probes.size(); ++i) {
    if (probes[i].world == ProbedWorld::kReference) {
      references.keep(start, probes[i].name, episode.probe(i).value());
    }
  }
  references.keep(start, kKeptReference, episode.rollout(kReferenceClosed).trace());
}

}  // namespace

void runProtocol(const Protocol& protocol, const WorkerFactory& factory, int threads, const ReferenceCache* references,
                 const std::function<void(Episode&&)>& deliver, const std::function<bool()>& stop,
                 const std::set<int>& finished) {
  protocol.validate();
  threads = std::min(threads, protocol.episodes);
  const int in_flight = std::min(kEpisodesInFlight, (protocol.episodes + threads - 1) / threads);
  std::atomic<int> next_episode = protocol.first_episode;
  std::atomic<bool> failed = false;
  std::mutex delivery;

  const auto begin = [&](Flight& flight, int index) {
    flight.begin(index, references != nullptr ? cachedTraces(protocol, index, *references) : CachedTraces());
  };
  const auto finish = [&](Episode&& episode) {
    if (references != nullptr) {
      keep(protocol, episode, *references);
    }
    const std::lock_guard<std::mutex> one_at_a_time(delivery);
    deliver(std::move(episode));
  };
  const auto work = [&] {
    if (next_episode > protocol.lastEpisode()) {
      return;  // others have begun them all
    }
    const Worlds worlds = factory.make_worlds(in_flight);
    const auto policy = factory.make_policy();
    Flight flight(protocol, worlds, *policy);
    while (!stop() && !failed) {
      while (!flight.full() && next_episode <= protocol.lastEpisode()) {
        if (const int index = next_episode++; index <= protocol.lastEpisode() && finished.count(index) == 0) {
          begin(flight, index);
        }
      }
      if (flight.empty()) {
        return;
      }
      flight.advance();
      for (Episode& episode : flight.land()) {
        finish(std::move(episode));
      }
    }
  };

  const auto work_or_fail = [&] {
    try {
      work();
    } catch (...) {
      failed = true;  // ends the other threads
      throw;
    }
  };
  std::vector<std::future<void>> others;
  try {
    while (static_cast<int>(others.size()) + 1 < threads) {
      others.push_back(std::async(std::launch::async, work_or_fail));
    }
  } catch (const std::system_error& error) {
    failed = true;
    throw pusht::RuntimeFault("cannot start thread " + std::to_string(others.size() + 2) + " of " +
                              std::to_string(threads) + ": " + error.what() + "; ask for fewer threads");
  }
  work_or_fail();  // if it throws, the destructors of the others wait for their ends
  for (std::future<void>& other : others) {
    other.get();
  }
}

}  // namespace sim2sim
