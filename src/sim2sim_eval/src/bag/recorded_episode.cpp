// SPDX-License-Identifier: BSD-3-Clause
#include "bag/recorded_episode.hpp"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/policy.hpp"
#include "pusht_task/rollout.hpp"
#include "sim2sim_protocol/flight.hpp"

namespace sim2sim {
namespace {

std::string textOf(const pusht::Action& action) {
  return "(" + std::to_string(action[0]) + ", " + std::to_string(action[1]) + ")";
}

/// Policy that takes the recorded actions.
class RecordedPolicy : public pusht::Policy {
 public:
  explicit RecordedPolicy(const RecordedEpisode& record) : record_(record) {}

  /// Closed loops are begun in the order of their modes.
  std::unique_ptr<Memory> begin(const pusht::Beginning& /*unused*/) const override {
    return std::make_unique<Cursor>(record_.modes.at(begun_++));
  }

  void act(pusht::Span<const Query> queries, pusht::Span<pusht::Action> actions) override {
    std::transform(queries.begin(), queries.end(), actions.begin(),
                   [](const Query& query) { return static_cast<Cursor*>(query.memory)->next(); });
  }

 private:
  /// Position of a rollout in its record. Past the end, the world refuses to go on.
  struct Cursor : Memory {
    explicit Cursor(const pusht::Trace& recorded) : trace(recorded) {}
    pusht::Action next() { return step < trace.steps() ? trace.actions[step++] : pusht::Action{}; }

    const pusht::Trace& trace;
    std::size_t step = 0;
  };

  const RecordedEpisode& record_;
  mutable std::size_t begun_ = 0;
};

/// A closed loop of these states. A bag has no actions of probes, and no quantity reads them.
pusht::Trace closedLoopOf(const std::vector<pusht::WorldState>& states) {
  return {states, std::vector<pusht::Action>(states.empty() ? 0 : states.size() - 1)};
}

/// Throws BadDependency if a closed loop ends neither by success nor at the horizon.
void requireEnd(const std::string& mode, int episode, const pusht::Trace& trace, const Protocol& protocol) {
  if (trace.states.empty() || !pusht::Rollout(trace, protocol.runTask()).finished(protocol.horizon)) {
    throw pusht::BadDependency("episode " + std::to_string(episode) + ", " + mode + ": " +
                               std::to_string(trace.steps()) + " steps are recorded, but the rollout must go on");
  }
}

}  // namespace

void RecordedWorld::doReset(const pusht::WorldState& state) {
  if (trace_.states.empty()) {
    throw pusht::BadDependency("no start is recorded");
  }
  if (!pusht::faultOfStart(state, trace_.states.front()).empty()) {
    throw pusht::BadDependency("the start that is recorded is not that of the episode");
  }
  step_ = 0;
}

void RecordedWorld::doStep(const pusht::Action& action) {
  if (step_ == trace_.steps()) {
    throw pusht::BadDependency("no more is recorded, but the rollout must go on");
  }
  if (action != trace_.actions[step_]) {
    throw pusht::BadDependency("the action that is recorded is " + textOf(trace_.actions[step_]) + ", must be " +
                               textOf(action));
  }
  ++step_;
}

Episode rebuildEpisode(const Protocol& protocol, int index, const RecordedEpisode& record) {
  const auto recorded = [&](Mode mode) {
    return std::make_unique<RecordedWorld>(record.modes[mode], protocol.runTask());
  };
  const Worlds worlds = worldsOf(recorded(kReferenceClosed), recorded(kEngineClosed), recorded(kEngineReplay));
  RecordedPolicy policy(record);
  const auto require_steps = [&](const std::string& mode, std::size_t recorded, std::size_t wanted) {
    if (recorded != wanted) {
      throw pusht::BadDependency("episode " + std::to_string(index) + ", " + mode + ": " + std::to_string(recorded) +
                                 " steps are recorded, must be " + std::to_string(wanted));
    }
  };
  CachedTraces cached;
  const std::vector<Probe> probes = protocol.probes();
  for (std::size_t i = 0; i < probes.size(); ++i) {
    const auto states = i < record.probes.size() ? record.probes[i] : std::vector<pusht::WorldState>();
    cached.probes.emplace_back(probes[i].closed ? closedLoopOf(states)
                                                : pusht::Trace{states, record.modes[kReferenceClosed].actions});
  }
  Episode episode = runEpisode(protocol, index, worlds, policy, std::move(cached));
  for (const Mode mode : kModes) {
    require_steps(modeName(mode), record.modes.at(mode).steps(), episode.rollout(mode).trace().steps());
  }
  for (std::size_t i = 0; i < probes.size(); ++i) {
    if (probes[i].closed) {
      requireEnd(probes[i].name, index, *episode.probe(i), protocol);
      continue;
    }
    const std::size_t states = episode.rollout(kReferenceClosed).trace().states.size();
    require_steps(probes[i].name, episode.probe(i)->states.size(), states);
  }
  return episode;
}

}  // namespace sim2sim
