// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/simulators.hpp"

#include <map>
#include <set>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/split.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_protocol/results/provenance.hpp"
#include "sim2sim_serving/simulator_kinds.hpp"

namespace sim2sim {
namespace {

// Begins of the names of foreign kinds.
const std::string kNode = "node:";
const std::string kPython = "python:";

/// What a node serves. Throws as pusht::servedKind.
ForeignKind kindOfNode(const std::string& name) {
  const std::string services = name.substr(kNode.size());
  if (services.empty() || services.front() != '/') {
    throw pusht::InvalidInput("simulator '" + name + "': must be " + kNode + "/NAME, the name of a node");
  }
  auto [kind, code] = pusht::servedKind(services, nodeTimes(), interrupted);
  return {name, std::move(kind), std::move(code), true};
}

/// Foreign kinds that are in use, by name.
std::map<std::string, std::weak_ptr<const ForeignKind>>& foreignKinds() {
  static std::map<std::string, std::weak_ptr<const ForeignKind>> kinds;
  return kinds;
}

/// Foreign kind of that name, one in use or that of a node; null for the name of an installed kind. Throws as
/// kindOfNode().
std::shared_ptr<const ForeignKind> foreignKind(const std::string& name) {
  if (std::shared_ptr<const ForeignKind> known = foreignKinds()[name].lock()) {
    return known;
  }
  return name.compare(0, kNode.size(), kNode) == 0 ? lend(kindOfNode(name)) : nullptr;
}

/// Name of a kind and settings, from "KIND:NAME=VALUE:NAME=VALUE". The name of a foreign kind has two words.
std::vector<std::string> partsOf(const std::string& text) {
  std::vector<std::string> parts = pusht::split(text, ':');
  const std::string begin = parts.front() + ":";
  if ((begin == kNode || begin == kPython) && parts.size() > 1) {
    parts[1].insert(0, begin);
    parts.erase(parts.begin());
  }
  return parts;
}

}  // namespace

std::shared_ptr<const ForeignKind> lend(ForeignKind kind) {
  auto lent = std::make_shared<const ForeignKind>(std::move(kind));
  foreignKinds()[lent->name] = lent;
  return lent;
}

pusht::NodeTimes& nodeTimes() {
  static pusht::NodeTimes times;
  return times;
}

void SimulatorChoice::set(const std::string& name, const std::string& text) {
  const std::string of_loop = pusht::loopParameterOf(name);
  of_loop.empty() ? parameters.set(name, text) : pusht::setOfLoop(loop, of_loop, text);
}

const pusht::Parameter& SimulatorChoice::at(const std::string& name) const {
  const std::string of_loop = pusht::loopParameterOf(name);
  return of_loop.empty() ? parameters.at(name) : loop.at(of_loop);
}

std::vector<std::string> SimulatorChoice::names() const {
  std::vector<std::string> names;
  for (const pusht::Parameter& parameter : parameters) {
    names.push_back(parameter.name());
  }
  for (const pusht::Parameter& parameter : loop) {
    if (parameter.set_by_name || !parameter.isDefault()) {
      names.push_back(pusht::kLoopPrefix + parameter.name());
    }
  }
  return names;
}

SimulatorChoice chooseSimulator(const std::string& kind, const std::vector<std::string>& settings) {
  const std::shared_ptr<const ForeignKind> foreign = foreignKind(kind);
  const pusht::SimulatorKind& chosen = foreign ? foreign->kind : pusht::SimulatorKinds::installed().named(kind);
  SimulatorChoice choice{chosen, chosen.defaults(), pusht::plainLoop(), foreign};
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
    choice.set(name, setting.substr(equals + 1));
  }
  return choice;
}

SimulatorChoice noEngine() {
  static const pusht::SimulatorKind kind = [] {
    pusht::SimulatorKind none;
    none.name = kNoEngine;
    none.title = "no engine";
    none.tasks.clear();
    none.loader = [](const pusht::ParameterSet& parameters) {
      return pusht::SimulatorModel{parameters, nlohmann::json::object(), nullptr, nullptr};  // no worlds
    };
    return none;
  }();
  return {kind, kind.defaults()};
}

SimulatorChoice simulatorFromText(const std::string& text) {
  const std::vector<std::string> parts = partsOf(text);
  return chooseSimulator(parts.front(), {parts.begin() + 1, parts.end()});
}

bool operator==(const SimulatorChoice& a, const SimulatorChoice& b) {
  return &a.kind.get() == &b.kind.get() && a.parameters == b.parameters && a.loop == b.loop;
}

std::vector<std::string> settingsOf(const SimulatorChoice& simulator) {
  std::vector<std::string> settings;
  for (const auto& [name, value] :
       pusht::fewestSettings(simulator.parameters, simulator.kind.get().defaults(simulator.task))) {
    settings.push_back(std::string(name).append("=").append(value));
  }
  for (const auto& [name, value] : pusht::fewestSettings(simulator.loop, pusht::plainLoop())) {
    settings.push_back(pusht::kLoopPrefix + name + "=" + value);
  }
  return settings;
}

std::string textOf(const SimulatorChoice& simulator) {
  std::string text = simulator.name();
  for (const std::string& setting : settingsOf(simulator)) {
    text.append(":").append(setting);
  }
  return text;
}

void requireTwoWorlds(const SimulatorChoice& reference, const SimulatorChoice& engine) {
  if (reference.foreign && reference.foreign->one_world && reference.foreign == engine.foreign) {
    throw pusht::InvalidInput("simulator " + reference.name() +
                              ": must not be in two roles: a node has one world; serve it by two nodes");
  }
}

void requireNoLoop(const SimulatorChoice& simulator, const std::string& command) {
  for (const pusht::Parameter& parameter : simulator.loop) {
    if (!parameter.isDefault()) {
      throw pusht::InvalidInput(pusht::kLoopPrefix + parameter.name() + " " + pusht::textOf(parameter.value) +
                                ": must be left out: " + command + " has no policy in a loop");
    }
  }
}

void setTask(const pusht::Task& task, const std::vector<std::reference_wrapper<SimulatorChoice>>& simulators) {
  for (SimulatorChoice& simulator : simulators) {
    simulator.kind.get().requireTask(task);
    simulator.task = task;
    simulator.parameters = simulator.kind.get().inTask(simulator.parameters, task);
    if (&task != &pusht::fullCircle()) {  // a kind may refuse values of its parameters in it
      simulator.kind.get().load(simulator.parameters, task);
    }
  }
}

LoadedSimulator::LoadedSimulator(const SimulatorChoice& choice)
    : foreign(choice.foreign),
      kind(choice.kind),
      task(choice.task),
      model(kind.load(choice.parameters, task)),
      loop(choice.loop) {}

SimulatorRecord LoadedSimulator::record() const {
  SimulatorRecord record = simulatorRecord();
  record.add(loop);
  return record;
}

SimulatorRecord LoadedSimulator::simulatorRecord() const {
  SimulatorRecord record{kind.name, kind.title};
  for (const pusht::Parameter& parameter : model.parameters) {
    if (!parameter.isRecorded()) {
      continue;
    }
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
