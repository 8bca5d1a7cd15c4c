// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/batch_simulator.hpp"

#include <utility>

#include "pusht_task/error.hpp"

namespace pusht {
namespace {

std::vector<std::unique_ptr<Simulator>> oneOf(std::unique_ptr<Simulator> world) {
  std::vector<std::unique_ptr<Simulator>> worlds;
  worlds.push_back(std::move(world));
  return worlds;
}

}  // namespace

SimulatorLanes::SimulatorLanes(std::vector<std::unique_ptr<Simulator>> worlds)
    : worlds_(std::move(worlds)),
      errors_(worlds_.size(), std::make_exception_ptr(InvalidInput("step: the world must be reset first"))) {}

SimulatorLanes::SimulatorLanes(std::unique_ptr<Simulator> world) : SimulatorLanes(oneOf(std::move(world))) {}

void SimulatorLanes::reset(int lane, const WorldState& state) {
  worlds_.at(lane)->reset(state);
  errors_.at(lane) = nullptr;
}

void SimulatorLanes::step(Actions actions) {
  for (std::size_t lane = 0; lane < worlds_.size(); ++lane) {
    if (actions[lane] && errors_[lane] == nullptr) {
      try {
        worlds_[lane]->step(*actions[lane]);
      } catch (...) {
        errors_[lane] = std::current_exception();
      }
    }
  }
}

WorldState SimulatorLanes::state(int lane) const {
  if (errors_.at(lane) != nullptr) {
    std::rethrow_exception(errors_.at(lane));
  }
  return worlds_.at(lane)->state();
}

}  // namespace pusht
