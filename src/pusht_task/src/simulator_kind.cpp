// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/simulator_kind.hpp"

#include <algorithm>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/joined.hpp"

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
  if (std::find(tasks.begin(), tasks.end(), task.name) == tasks.end()) {
    throw InvalidInput("task " + task.name + ": the kind " + name + " holds only " + joined(tasks));
  }
}

}  // namespace pusht
