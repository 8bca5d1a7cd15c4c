// SPDX-License-Identifier: BSD-3-Clause
#include "plan_loops.hpp"

#include "plan_values.hpp"
#include "pusht_task/loop.hpp"

namespace sim2sim {
namespace {

/// A loop: the word of a preset, or a map of parameters to values.
LoopSettings loopAt(const YAML::Node& node) {
  if (!node.IsMap()) {
    return {pusht::loopSettingFrom(textAt(node, "loop"))};
  }
  requireDistinctKeys(node);
  LoopSettings settings;
  for (const auto& entry : node) {
    const std::string name = textAt(entry.first, "parameter");
    settings.emplace_back(name, textAt(entry.second, name));
  }
  return settings;
}

/// Puts the policy of a simulator into a loop. Throws InvalidInput in the line of `node` for a parameter that the
/// simulator has in the plan already.
void putInLoop(SimulatorChoice& simulator, const LoopSettings& loop, const YAML::Node& node) {
  for (const auto& [name, value] : loop) {
    inLineOf(node, [&, name = name, value = value] {
      if (simulator.at(pusht::kLoopPrefix + name).set_by_name) {
        throw pusht::InvalidInput(pusht::kLoopPrefix + name + ": must appear only once; " + textOf(simulator) +
                                  " has it too");
      }
      simulator.set(pusht::kLoopPrefix + name, value);
    });
  }
}

/// Names the parameters that any loop of the plan names or changes, with the values that they have here, so that all
/// rows have the same parameters.
void nameAllParameters(SimulatorChoice& simulator, const std::vector<PlannedLoop>& loops) {
  for (const auto& [loop, node] : loops) {
    pusht::ParameterSet there = pusht::plainLoop();
    inLineOf(node, [&, &settings = loop] {
      for (const auto& [name, value] : settings) {
        pusht::setOfLoop(there, name, value);
      }
    });
    for (const pusht::Parameter& parameter : there) {
      if (parameter.set_by_name || !parameter.isDefault()) {
        const std::string name = pusht::kLoopPrefix + parameter.name();
        simulator.set(name, pusht::textOf(simulator.at(name).value));
      }
    }
  }
}

}  // namespace

std::vector<PlannedLoop> loopsIn(const YAML::Node& root) {
  const YAML::Node node = root["loop"];
  if (!node.IsDefined()) {
    return {{{}, node}};
  }
  if (!node.IsSequence()) {
    return {{loopAt(node), node}};
  }
  std::vector<PlannedLoop> loops;
  for (const YAML::Node& loop : node) {
    loops.push_back({loopAt(loop), loop});
  }
  if (loops.empty()) {
    refuse(node, "loop", "must be a loop, or a list of loops");
  }
  return loops;
}

SimulatorChoice inLoop(SimulatorChoice simulator, const PlannedLoop& loop, const std::vector<PlannedLoop>& loops) {
  putInLoop(simulator, loop.settings, loop.node);
  nameAllParameters(simulator, loops);
  return simulator;
}

}  // namespace sim2sim
