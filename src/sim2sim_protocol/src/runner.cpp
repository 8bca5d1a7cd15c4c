// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/runner.hpp"

#include <algorithm>
#include <condition_variable>
#include <future>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "pusht_task/error.hpp"
#include "sim2sim_protocol/reference_cache.hpp"

namespace sim2sim {
namespace {

/// Traces of an episode that the cache has.
CachedTraces cachedTraces(const Protocol& protocol, int episode, const ReferenceCache& references) {
  const std::string key = protocol.cacheKey(episode);
  CachedTraces cached{references.find(key, kReferenceRollout), {}};
  for (const Probe& probe : protocol.probes()) {
    cached.probes.push_back(probe.isOfReference() ? references.find(key, probe.name) : std::nullopt);
  }
  return cached;
}

/// Adds to the cache what an episode has of the reference alone.
void keep(const Protocol& protocol, const Episode& episode, const ReferenceCache& references) {
  const std::string key = protocol.cacheKey(episode.index());
  const std::vector<Probe> probes = protocol.probes();
  for (std::size_t i = 0; i < probes.size(); ++i) {
    if (probes[i].isOfReference()) {
      references.keep(key, probes[i].name, episode.probe(i).value());
    }
  }
  references.keep(key, kReferenceRollout, episode.rollout(kReferenceClosed).trace());
}

/// Episodes of a run, shared by its threads: handed out by index, and delivered by index. Finished episodes wait in a
/// buffer for those before them.
class EpisodeQueue {
 public:
  /// Episodes in `finished` are left out. At most `capacity` episodes are in flight or in the buffer.
  EpisodeQueue(const Protocol& protocol, const std::set<int>& finished, int capacity,
               const std::function<void(Episode&&)>& deliver, const std::function<bool()>& stop)
      : finished_(finished),
        last_(protocol.lastEpisode()),
        capacity_(capacity),
        deliver_(deliver),
        stop_(stop),
        next_begun_(after(protocol.first_episode - 1)),
        next_delivered_(next_begun_) {}

  /// Next episode to begin; empty if there is none, or if the buffer must first get emptier.
  std::optional<int> take() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (next_begun_ > last_ || isFull()) {
      return std::nullopt;
    }
    return std::exchange(next_begun_, after(next_begun_));
  }

  /// Lets waitForEpisode() return.
  void open() {
    const std::lock_guard<std::mutex> lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }

  /// Waits until take() has an episode; returns false if there will be none. Only for a thread without an episode in
  /// flight: the episode that the buffer waits for is then in flight in another thread.
  bool waitForEpisode() {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return ended_ || (open_ && (next_begun_ > last_ || !isFull())); });
    return !ended_ && next_begun_ <= last_;
  }

  /// Takes a finished episode, and delivers all whose turn it is.
  void add(Episode&& episode) {
    const std::lock_guard<std::mutex> lock(mutex_);
    buffer_.emplace(episode.index(), std::move(episode));
    while (!buffer_.empty() && buffer_.begin()->first == next_delivered_ && !stop_()) {
      deliver_(std::move(buffer_.begin()->second));
      buffer_.erase(buffer_.begin());
      next_delivered_ = after(next_delivered_);
    }
    changed_.notify_all();
  }

  /// Ends the run for all threads.
  void end() {
    const std::lock_guard<std::mutex> lock(mutex_);
    ended_ = true;
    changed_.notify_all();
  }

  bool ended() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return ended_;
  }

 private:
  /// First episode behind `index` that is to be run.
  int after(int index) const {
    do {
      ++index;
    } while (finished_.count(index) > 0);
    return index;
  }

  bool isFull() const { return next_begun_ - next_delivered_ >= capacity_; }

  const std::set<int>& finished_;
  const int last_;
  const int capacity_;
  const std::function<void(Episode&&)>& deliver_;
  const std::function<bool()>& stop_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  int next_begun_;
  int next_delivered_;
  bool open_ = false;
  bool ended_ = false;
  std::map<int, Episode> buffer_;
};

/// Runs episodes of `queue` until there are no more, or `stop` or the end of the run.
void work(const Protocol& protocol, const WorkerFactory& factory, int lanes, const ReferenceCache* references,
          EpisodeQueue& queue, const std::function<bool()>& stop) {
  if (!queue.waitForEpisode()) {
    return;  // other threads have begun them all
  }
  const Worlds worlds = factory.make_worlds(lanes);
  const auto policy = factory.make_policy();
  const VariantWorlds variants = factory.make_variants ? factory.make_variants() : VariantWorlds();
  Flight flight(protocol, worlds, *policy, variants);
  while (!stop() && !queue.ended()) {
    while (!flight.full()) {
      const std::optional<int> index = queue.take();
      if (!index) {
        break;
      }
      flight.begin(*index, references != nullptr ? cachedTraces(protocol, *index, *references) : CachedTraces());
    }
    if (!flight.empty()) {
      flight.advance();
    } else if (!queue.waitForEpisode()) {
      return;
    }
    for (Episode& episode : flight.land()) {
      if (references != nullptr) {
        keep(protocol, episode, *references);
      }
      queue.add(std::move(episode));
    }
  }
  queue.end();
}

}  // namespace

void runProtocol(const Protocol& protocol, const WorkerFactory& factory, int threads, const ReferenceCache* references,
                 const std::function<void(Episode&&)>& deliver, const std::function<bool()>& stop,
                 const std::set<int>& finished) {
  protocol.validate();
  threads = factory.one_at_a_time ? 1 : std::min(threads, protocol.episodes);
  const int lanes =
      factory.one_at_a_time ? 1 : std::min(kEpisodesInFlight, (protocol.episodes + threads - 1) / threads);
  EpisodeQueue queue(protocol, finished, kEpisodesHeld * threads, deliver, stop);
  const auto work_or_end = [&] {
    try {
      work(protocol, factory, lanes, references, queue, stop);
    } catch (...) {
      queue.end();
      throw;
    }
  };
  std::vector<std::future<void>> others;
  try {
    while (static_cast<int>(others.size()) + 1 < threads) {
      others.push_back(std::async(std::launch::async, work_or_end));
    }
  } catch (const std::system_error& error) {
    queue.end();
    throw pusht::RuntimeFault("cannot start thread " + std::to_string(others.size() + 2) + " of " +
                              std::to_string(threads) + ": " + error.what() + "; ask for fewer threads");
  } catch (...) {
    queue.end();
    throw;
  }
  queue.open();   // no thread uses memory while another one may fail to start for the lack of it
  work_or_end();  // if it throws, the destructors of the others wait for their ends
  for (std::future<void>& other : others) {
    other.get();
  }
}

}  // namespace sim2sim
