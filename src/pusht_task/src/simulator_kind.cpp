// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/simulator_kind.hpp"

#include <algorithm>
#include <utility>

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

}  // namespace pusht
