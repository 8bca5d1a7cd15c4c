// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/simulator_kind.hpp"

#include <algorithm>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/physics_numbers.hpp"

namespace pusht {

SimulatorModel modelOfWorlds(ParameterSet parameters, std::function<std::unique_ptr<Simulator>()> make_world) {
  SimulatorModel model;
  model.parameters = std::move(parameters);
  model.make_lanes = [make_world](int lanes) {
    std::vector<std::unique_ptr<Simulator>> worlds(static_cast<std::size_t>(lanes));
    std::generate(worlds.begin(), worlds.end(), make_world);
    return std::make_unique<SimulatorLanes>(std::move(worlds));
  };
  model.make_world = std::move(make_world);
  return model;
}

void SimulatorKind::requireTask(const Task& task) const {
  if (!tasks.empty() && std::find(tasks.begin(), tasks.end(), task.name) == tasks.end()) {
    throw InvalidInput("task " + task.name + ": the kind " + name + " holds only " + joined(tasks));
  }
}

const Task& SimulatorKind::ownTask() const { return tasks.empty() ? fullCircle() : taskNamed(tasks.front()); }

ParameterSet SimulatorKind::defaults(const Task& task) const { return inTask(ParameterSet(parameters), task); }

ParameterSet SimulatorKind::inTask(ParameterSet set, const Task& task) const {
  for (const PhysicsNumber& number : physicsNumbers()) {
    const std::string& name = number.descriptor.name;
    if (std::any_of(parameters.begin(), parameters.end(),
                    [&](const ParameterDescriptor& each) { return each.of_task && each.name == name; })) {
      set.setDefault(name, number.of(task.physics));
    }
  }
  return set;
}

SimulatorModel SimulatorKind::load(const ParameterSet& set, const Task& task) const {
  requireTask(task);
  return loader(inTask(set, task), task);
}

}  // namespace pusht
