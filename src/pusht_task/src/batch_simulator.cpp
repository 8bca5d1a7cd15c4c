// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/batch_simulator.hpp"

#include <utility>

namespace pusht {
namespace {

std::vector<std::unique_ptr<Simulator>> oneOf(std::unique_ptr<Simulator> world) {
  std::vector<std::unique_ptr<Simulator>> worlds;
  worlds.push_back(std::move(world));
  return worlds;
}

}  // namespace

LaneFaults::LaneFaults(std::size_t lanes)
    : faults_(lanes, std::make_exception_ptr(InvalidInput("the world must be reset first"))) {}

void LaneFaults::raise(std::size_t lane) const {
  if (faults_.at(lane) != nullptr) {
    std::rethrow_exception(faults_[lane]);
  }
}

SimulatorLanes::SimulatorLanes(std::vector<std::unique_ptr<Simulator>> worlds)
    : worlds_(std::move(worlds)), faults_(worlds_.size()) {}

SimulatorLanes::SimulatorLanes(std::unique_ptr<Simulator> world) : SimulatorLanes(oneOf(std::move(world))) {}

void SimulatorLanes::reset(int lane, const WorldState& state) {
  faults_.reset(lane, [&] { worlds_.at(lane)->reset(state); });
}

void SimulatorLanes::spawn(int lane, std::uint64_t seed) {
  faults_.reset(lane, [&] { worlds_.at(lane)->spawn(seed); });
}

void SimulatorLanes::step(Actions actions) {
  for (std::size_t lane = 0; lane < worlds_.size(); ++lane) {
    if (actions[lane] && !faults_.has(lane)) {
      faults_.step(lane, [&] { worlds_[lane]->step(*actions[lane]); });
    }
  }
}

WorldState SimulatorLanes::state(int lane) const {
  faults_.raise(lane);
  return worlds_.at(lane)->state();
}

}  // namespace pusht
