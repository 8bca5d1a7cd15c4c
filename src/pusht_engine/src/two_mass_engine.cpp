// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_engine/two_mass_engine.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"

namespace pusht {

using two_mass::Body;
using two_mass::kBar;
using two_mass::kPusher;
using two_mass::kStem;

namespace {

// Yaw and its rate are read from the masses, with rounding errors of some 1e-15. Read on a grid a little
// coarser than that, a state that was read and set is read as it was set, bit for bit (within 4 m, 10 m/s).
constexpr double kYawGrid = 0x1p-46;                                // [rad]
constexpr double kYawRateGrid = 0x1p-44;                            // [rad/s]
const double kGreatestYaw = std::floor(kPi / kYawGrid) * kYawGrid;  // [rad]

/// The multiple of `spacing`, a power of two, that is nearest to `value`.
double onGrid(double value, double spacing) { return std::nearbyint(value / spacing) * spacing; }

Eigen::Vector2d turnLeft(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

}  // namespace

void TwoMassParameters::validate() const {
  if (!(pusher_mass > 0.0) || !std::isfinite(1.0 / pusher_mass)) {
    throw InvalidInput("pusher_mass " + shortestText(pusher_mass) + ": must be > 0 and finite, as its inverse [kg]");
  }
  for (const two_mass::Knob& knob : two_mass::kKnobs) {
    const double value = this->*knob.value;
    if (!std::isfinite(value) || value < 0.0) {
      throw InvalidInput(std::string(knob.name) + " " + shortestText(value) + ": must be finite and >= 0 [" +
                         knob.unit + "]");
    }
  }
}

TwoMassEngine::TwoMassEngine(const TwoMassParameters& parameters)
    : parameters_(parameters), masses_{parameters.pusher_mass, kBarMass, kStemMass} {
  parameters_.validate();
  for (std::size_t body = 0; body < masses_.size(); ++body) {
    inverse_masses_[body] = 1.0 / masses_[body];
    positions_[body].setZero();
    velocities_[body].setZero();
  }
}

void TwoMassEngine::doReset(const WorldState& state) {
  const Eigen::Vector2d offset(kStemOffset * std::sin(state.tee_yaw), -kStemOffset * std::cos(state.tee_yaw));
  positions_ = {state.pusher_position, state.tee_position, state.tee_position + offset};
  velocities_ = {state.pusher_velocity, state.tee_velocity, state.tee_velocity + state.tee_yaw_rate * turnLeft(offset)};
}

WorldState TwoMassEngine::doState() const {
  const Eigen::Vector2d arm = positions_[kStem] - positions_[kBar];
  const Eigen::Vector2d arm_rate = velocities_[kStem] - velocities_[kBar];
  WorldState state;
  state.pusher_position = positions_[kPusher];
  state.pusher_velocity = velocities_[kPusher];
  state.tee_position = positions_[kBar];
  state.tee_velocity = velocities_[kBar];
  state.tee_yaw =
      std::clamp(onGrid(two_mass::yaw(positions_[kBar], positions_[kStem]), kYawGrid), -kGreatestYaw, kGreatestYaw);
  state.tee_yaw_rate = onGrid(turnLeft(arm).dot(arm_rate) / arm.squaredNorm(), kYawRateGrid);
  return state;
}

void TwoMassEngine::doStep(const Action& action) {
  const Eigen::Vector2d command(action[0], action[1]);
  for (int i = 0; i < kSubstepsPerControlStep; ++i) {
    substep(command);
  }
}

void TwoMassEngine::substep(const Eigen::Vector2d& command) {
  // Forces on the tee: the link between its masses, and drag.
  const Eigen::Vector2d link = two_mass::linkForce(positions_, velocities_, masses_, parameters_.baumgarte);
  two_mass::BodyVectors forces = {Eigen::Vector2d::Zero(), link, -link};
  for (const Body block : {kBar, kStem}) {
    forces[block] -= parameters_.block_damp * velocities_[block] * masses_[block];
  }

  // Velocities: the tee by its forces, the pusher by its servo.
  for (const Body block : {kBar, kStem}) {
    velocities_[block] += kSubstep * forces[block] * inverse_masses_[block];
  }
  velocities_[kPusher] += (kSubstep * two_mass::kServoGain) * (command - velocities_[kPusher]);

  // Contacts change velocities, velocities change positions (semi-implicit Euler).
  two_mass::solveContacts(two_mass::findContacts(positions_), inverse_masses_, velocities_);
  for (std::size_t body = 0; body < positions_.size(); ++body) {
    positions_[body] += kSubstep * velocities_[body];
  }
}

}  // namespace pusht
