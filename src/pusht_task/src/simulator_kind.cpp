// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/simulator_kind.hpp"

#include <algorithm>
#include <iterator>

#include "pusht_task/error.hpp"
#include "pusht_task/joined.hpp"

namespace pusht {

std::vector<std::string> kindNames(const SimulatorKinds& kinds) {
  std::vector<std::string> names;
  std::transform(kinds.begin(), kinds.end(), std::back_inserter(names),
                 [](const SimulatorKind& kind) { return kind.name; });
  return names;
}

const SimulatorKind& kindNamed(const std::string& name, const SimulatorKinds& kinds) {
  const auto place =
      std::find_if(kinds.begin(), kinds.end(), [&](const SimulatorKind& kind) { return kind.name == name; });
  if (place == kinds.end()) {
    throw InvalidInput("simulator '" + name + "': unknown; known: " + joined(kindNames(kinds)));
  }
  return *place;
}

std::function<std::unique_ptr<BatchSimulator>(int lanes)> lanesOf(
    const std::function<std::unique_ptr<Simulator>()>& make_world) {
  return [make_world](int lanes) {
    std::vector<std::unique_ptr<Simulator>> worlds(static_cast<std::size_t>(lanes));
    std::generate(worlds.begin(), worlds.end(), make_world);
    return std::make_unique<SimulatorLanes>(std::move(worlds));
  };
}

}  // namespace pusht
