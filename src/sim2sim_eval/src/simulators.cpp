// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/simulators.hpp"

#include <algorithm>
#include <set>

#include "pusht_chipmunk/chipmunk_kind.hpp"
#include "pusht_engine/two_mass_kind.hpp"
#include "pusht_mujoco/mujoco_kind.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/joined.hpp"

namespace sim2sim {

const std::vector<std::reference_wrapper<const pusht::SimulatorKind>>& simulatorKinds() {
  static const std::vector<std::reference_wrapper<const pusht::SimulatorKind>> kinds = {
      pusht::mujocoKind(), pusht::twoMassKind(), pusht::chipmunkKind()};
  return kinds;
}

std::vector<std::string> kindNames() {
  std::vector<std::string> names;
  names.reserve(simulatorKinds().size());
  for (const pusht::SimulatorKind& kind : simulatorKinds()) {
    names.push_back(kind.name);
  }
  return names;
}

const pusht::SimulatorKind& simulatorKind(const std::string& name) {
  for (const pusht::SimulatorKind& kind : simulatorKinds()) {
    if (kind.name == name) {
      return kind;
    }
  }
  throw pusht::InvalidInput("simulator '" + name +
                            "': there is none of that name; there are: " + pusht::joined(kindNames()));
}

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
