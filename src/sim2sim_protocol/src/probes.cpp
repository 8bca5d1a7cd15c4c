// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/probes.hpp"

#include <algorithm>
#include <optional>
#include <sstream>
#include <utility>

#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"

namespace sim2sim {
namespace {

constexpr const char* kReanchored = "engine_reanchored_";

}  // namespace

const std::vector<Probe>& floorProbes() {
  static const std::vector<Probe> probes = {{"floor_1e-9", ProbedWorld::kReference, 1e-9, 0},
                                            {"floor_1e-6", ProbedWorld::kReference, 1e-6, 0}};
  return probes;
}

Probe stateResetReplay(int every) {
  if (every < 1 || every > pusht::kHorizon) {
    throw pusht::InvalidInput("reanchor " + std::to_string(every) + ": must be from 1 to " +
                              std::to_string(pusht::kHorizon) + " control steps");
  }
  return {kReanchored + std::to_string(every), ProbedWorld::kEngine, 0.0, every};
}

std::vector<Probe> probesOf(bool floor, const std::vector<int>& reanchor) {
  std::vector<Probe> probes = floor ? floorProbes() : std::vector<Probe>();
  for (const int every : reanchor) {
    Probe probe = stateResetReplay(every);
    if (std::find(probes.begin(), probes.end(), probe) != probes.end()) {
      throw pusht::InvalidInput("reanchor " + std::to_string(every) + ": is named twice");
    }
    probes.push_back(std::move(probe));
  }
  return probes;
}

std::vector<int> reanchorFrom(const std::string& text) {
  std::vector<int> steps;
  std::istringstream list(text.empty() ? text : text + ",");  // so that an empty last one is seen
  for (std::string number; std::getline(list, number, ',');) {
    const std::optional<int> every = pusht::decimal<int>(number);
    if (!every) {
      throw pusht::InvalidInput("reanchor '" + text + "': must be numbers of control steps like 1,5,20");
    }
    steps.push_back(*every);
  }
  return steps;
}

Probe probeFrom(const std::string& name) {
  for (const Probe& probe : floorProbes()) {
    if (probe.name == name) {
      return probe;
    }
  }
  const bool is_reanchored = name.rfind(kReanchored, 0) == 0;
  const auto every = is_reanchored ? pusht::decimal<int>(name.substr(std::string(kReanchored).size())) : std::nullopt;
  if (!every) {
    throw pusht::InvalidInput("probe '" + name + "': must be floor_1e-9, floor_1e-6 or " + kReanchored + "K");
  }
  return stateResetReplay(*every);
}

pusht::Trace runProbe(const Probe& probe, const pusht::WorldState& initial_state, const pusht::Trace& reference,
                      pusht::BatchSimulator& world, std::size_t lane, const std::function<void(int)>& before_step) {
  const int in_lane = static_cast<int>(lane);
  pusht::WorldState moved = initial_state;
  moved.tee_position.x() += probe.tee_offset;
  world.reset(in_lane, moved);
  pusht::Trace trace;
  trace.states.push_back(world.state(in_lane));
  trace.actions = reference.actions;
  std::vector<std::optional<pusht::Action>> actions(static_cast<std::size_t>(world.lanes()));
  for (int step = 0; step < static_cast<int>(reference.steps()); ++step) {
    before_step(step);
    const auto k = static_cast<std::size_t>(step);
    if (probe.reset_every > 0 && step > 0 && step % probe.reset_every == 0) {
      world.reset(in_lane, reference.states[k]);
    }
    actions[lane] = reference.actions[k];
    world.step(actions);
    trace.states.push_back(world.state(in_lane));
  }
  return trace;
}

}  // namespace sim2sim
