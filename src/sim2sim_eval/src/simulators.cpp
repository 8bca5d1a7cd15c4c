// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/simulators.hpp"

#include <algorithm>
#include <set>

#include "pusht_chipmunk/chipmunk_kind.hpp"
#include "pusht_engine/rigid_body_kind.hpp"
#include "pusht_engine/two_mass_kind.hpp"
#include "pusht_mujoco/mujoco_kind.hpp"
#include "pusht_task/error.hpp"

namespace sim2sim {

const pusht::SimulatorKinds& simulatorKinds() {
  static const pusht::SimulatorKinds kinds = {pusht::mujocoKind(), pusht::twoMassKind(), pusht::rigidBodyKind(),
                                              pusht::chipmunkKind()};
  return kinds;
}

std::vector<std::string> kindNames() { return pusht::kindNames(simulatorKinds()); }

const pusht::SimulatorKind& simulatorKind(const std::string& name) { return pusht::kindNamed(name, simulatorKinds()); }

SimulatorChoice chooseSimulator(const std::string& kind, const std::vector<std::string>& settings) {
  SimulatorChoice choice{simulatorKind(kind), simulatorKind(kind).defaults()};
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

std::vector<Input> filesIn(const nlohmann::json& provenance) {
  std::vector<Input> files;
  for (const auto& [name, entry] : provenance.items()) {
    if (entry.is_object() && entry.contains("file") && entry.at("file").is_string()) {
      files.push_back({name, entry.at("file").get<std::string>()});
    }
  }
  return files;
}

}  // namespace sim2sim
