// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_run.hpp"

#include <chrono>
#include <thread>
#include <utility>

#include "pusht_task/error.hpp"
#include "sim2sim_protocol/flight.hpp"

namespace sim2sim {
namespace {

/// Faults in one episode after which the nodes are beyond help.
constexpr int kMostFaults = 5;

/// The nodes of the worlds are asked whether they are still there so often, for those that rest may be lost, too: a
/// rollout may have ended long before the episode does, and probes concern one node.
constexpr std::chrono::milliseconds kCheckPeriod{250};

pusht::RuntimeFault interruptedIn(int episode) {
  return pusht::RuntimeFault("interrupted in episode " + std::to_string(episode));
}

pusht::RuntimeFault interruptedAtFirst() { return pusht::RuntimeFault("interrupted before the first episode"); }

/// Whether `stop` holds within the grace.
bool stopsSoon(const LiveOptions& options) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kStopPeriod{20};
  const Clock::time_point expiry = Clock::now() + options.grace;
  while (!options.wait.stop()) {
    if (Clock::now() >= expiry) {
      return false;
    }
    std::this_thread::sleep_for(kStopPeriod);
  }
  return true;
}

void requireUndisturbedEnd(LiveNodes& nodes, int index) {
  try {
    nodes.requireUndisturbed();
  } catch (pusht::Error& error) {
    error.addContext("end of episode " + std::to_string(index));
    throw;
  }
}

/// Takes `flight`, of one episode, which has begun, to its end.
Episode fly(Flight& flight, const Episode& under_way, LiveNodes& nodes, Pacer& pacer, LiveObserver& observer,
            const std::function<bool()>& stop) {
  using Clock = std::chrono::steady_clock;
  Clock::time_point next_check = Clock::now() + kCheckPeriod;
  const auto check = [&] {
    if (Clock::now() >= next_check) {
      nodes.requireUndisturbed();
      next_check = Clock::now() + kCheckPeriod;
    }
  };
  const int index = under_way.index();
  while (!under_way.finished()) {
    if (!pacer.wait(stop)) {
      throw interruptedIn(index);
    }
    check();
    nodes.stamps().advance();
    flight.advance();
    observer.onStep(under_way, nodes.stamps().now());
  }
  nodes.silence();
  requireUndisturbedEnd(nodes, index);
  const auto watch = [&] {
    if (stop()) {
      throw interruptedIn(index);
    }
    check();
  };
  return std::move(flight.land(watch).front());
}

/// Whether the run needs further episodes.
bool runEpisode(const Protocol& protocol, int index, LiveNodes& nodes, const VariantWorlds& variants, Pacer& pacer,
                LiveObserver& observer, const std::function<bool()>& stop) {
  nodes.announce(index, protocol.horizon);
  nodes.stamps().advance();
  Flight flight(protocol, nodes.worlds(), nodes.policy(), variants);
  const Episode& under_way = flight.begin(index);
  observer.onStep(under_way, nodes.stamps().now());
  const Episode episode = [&] {
    try {
      return fly(flight, under_way, nodes, pacer, observer, stop);
    } catch (const pusht::Error&) {
      observer.onBreak(under_way);
      throw;
    }
  }();
  try {
    requireUndisturbedEnd(nodes, index);
  } catch (const pusht::Error&) {
    observer.onBreak(episode);
    throw;
  }
  return observer.onFinish(episode, nodes.stamps().now());
}

}  // namespace

void connectFirst(LiveNodes& nodes, const LiveOptions& options) {
  try {
    nodes.connect(options.simulators, options.wait);
  } catch (const pusht::PeerFault&) {
    if (stopsSoon(options)) {
      throw interruptedAtFirst();
    }
    throw;
  } catch (const pusht::NodeMissing&) {
    if (options.wait.stop()) {
      throw interruptedAtFirst();
    }
    throw;
  }
}

void runLive(const Protocol& protocol, LiveNodes& nodes, const VariantWorlds& variants, Pacer& pacer,
             LiveObserver& observer, const LiveOptions& options) {
  const std::function<bool()>& stop = options.wait.stop;
  bool lost = false;  // a node
  int faults = 0;     // in this episode
  for (int index = protocol.first_episode; index <= protocol.lastEpisode();) {
    try {
      if (lost) {
        nodes.connect(options.simulators, options.wait);
        lost = false;
        observer.onRecovery();
      }
      if (!runEpisode(protocol, index, nodes, variants, pacer, observer, stop)) {
        return;
      }
      ++index;
      faults = 0;
    } catch (const pusht::PeerFault& fault) {
      if (!options.wait.respawn || ++faults == kMostFaults) {
        if (!stop()) {
          observer.onLoss(index, fault);
        }
        if (stopsSoon(options)) {
          throw interruptedIn(index);
        }
        throw;
      }
      if (stop()) {
        throw interruptedIn(index);
      }
      observer.onFault(index, fault);
      lost = true;
    } catch (const pusht::NodeMissing&) {  // one that was lost has not come back
      if (stop()) {
        throw interruptedIn(index);
      }
      throw;
    }
  }
}

}  // namespace sim2sim
