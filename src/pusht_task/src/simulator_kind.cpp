// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/simulator_kind.hpp"

#include <algorithm>

namespace pusht {

std::function<std::unique_ptr<BatchSimulator>(int lanes)> lanesOf(
    const std::function<std::unique_ptr<Simulator>()>& make_world) {
  return [make_world](int lanes) {
    std::vector<std::unique_ptr<Simulator>> worlds(static_cast<std::size_t>(lanes));
    std::generate(worlds.begin(), worlds.end(), make_world);
    return std::make_unique<SimulatorLanes>(std::move(worlds));
  };
}

}  // namespace pusht
