// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/simulators.hpp"

#include <set>

#include "pusht_task/error.hpp"
#include "pusht_task/ros/simulator_kinds.hpp"
#include "sim2sim_protocol/results/provenance.hpp"

namespace sim2sim {

SimulatorChoice chooseSimulator(const std::string& kind, const std::vector<std::string>& settings) {
  const pusht::SimulatorKind& chosen = pusht::SimulatorKinds::installed().named(kind);
  SimulatorChoice choice{chosen, chosen.defaults()};
  std::set<std::string> seen;
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    const std::string name = setting.substr(0, equals);
    if (equals == std::string::npos) {
      throw pusht::InvalidInput("setting '" + setting + "': must be NAME=VALUE");
    }
    if (!seen.insert(name).second) {
      throw pusht::InvalidInput(std::string("setting '").append(setting).append("': ").append(name) +
                                " must be set once");
    }
    choice.parameters.set(name, setting.substr(equals + 1));
  }
  return choice;
}

SimulatorRecord LoadedSimulator::record() const {
  SimulatorRecord record{kind.name, kind.title};
  for (const pusht::Parameter& parameter : model.parameters) {
    record.add(parameter.name(), parameter.value, parameter.descriptor.unit, parameter.isDefault(), model.provenance);
  }
  return record;
}

nlohmann::json LoadedSimulator::provenance() const {
  nlohmann::json provenance = model.provenance;
  provenance["version"] = kind.version;
  return provenance;
}

std::vector<Input> LoadedSimulator::inputs() const { return filesIn(model.provenance); }

}  // namespace sim2sim
