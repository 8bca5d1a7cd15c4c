// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_engine/two_mass_engine.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"

namespace pusht {

using two_mass::kBar;
using two_mass::kPusher;
using two_mass::kStem;

namespace {

// Yaw and its rate are read from the masses, with rounding errors of some 1e-15. They are rounded to a grid a little
// coarser than that, so a state that was read and set again reads the same, bit for bit (within 4 m, 10 m/s).
constexpr double kYawGrid = 0x1p-46;                                // [rad]
constexpr double kYawRateGrid = 0x1p-44;                            // [rad/s]
const double kGreatestYaw = std::floor(kPi / kYawGrid) * kYawGrid;  // [rad]

/// The multiple of `spacing`, a power of two, that is nearest to `value`.
double onGrid(double value, double spacing) { return std::nearbyint(value / spacing) * spacing; }

Eigen::Vector2d turnLeft(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

}  // namespace

ParameterDescriptor two_mass::Parameter::descriptor() const {
  return {name, unit, meaning, TwoMassParameters().*value, least, greatest, reason};
}

double two_mass::greatestBaumgarte(double block_damp) {
  return (std::sqrt(8.0 - 2.0 * kSubstep * block_damp) - 2.0) / kSubstep;
}

void TwoMassParameters::validate() const {
  for (const two_mass::Parameter& parameter : two_mass::kParameters) {
    parameter.descriptor().require(this->*parameter.value);
  }
  const double greatest = two_mass::greatestBaumgarte(block_damp);
  if (!(baumgarte < greatest)) {
    throw InvalidInput("baumgarte " + shortestText(baumgarte) + ": must be below " + fixedText(greatest, 2) +
                       " [rad/s] with block_damp " + shortestText(block_damp) + ": a stiffer link shakes itself apart");
  }
}

two_mass::Model TwoMassPhysics::modelOf(const TwoMassParameters& parameters) {
  parameters.validate();
  return {{parameters.pusher_mass, kBarMass, kStemMass},
          {1.0 / parameters.pusher_mass, 1.0 / kBarMass, 1.0 / kStemMass},
          parameters.block_damp,
          parameters.baumgarte};
}

TwoMassPhysics::Bodies TwoMassPhysics::bodiesOf(const WorldState& state) {
  const Eigen::Vector2d offset(kStemOffset * std::sin(state.tee_yaw), -kStemOffset * std::cos(state.tee_yaw));
  return {{state.pusher_position, state.tee_position, state.tee_position + offset},
          {state.pusher_velocity, state.tee_velocity, state.tee_velocity + state.tee_yaw_rate * turnLeft(offset)}};
}

WorldState TwoMassPhysics::stateOf(const Bodies& bodies) {
  const auto& [positions, velocities] = bodies;
  const Eigen::Vector2d arm = positions[kStem] - positions[kBar];
  const Eigen::Vector2d arm_rate = velocities[kStem] - velocities[kBar];
  WorldState state;
  state.pusher_position = positions[kPusher];
  state.pusher_velocity = velocities[kPusher];
  state.tee_position = positions[kBar];
  state.tee_velocity = velocities[kBar];
  state.tee_yaw =
      std::clamp(onGrid(two_mass::yaw(positions[kBar], positions[kStem]), kYawGrid), -kGreatestYaw, kGreatestYaw);
  state.tee_yaw_rate = onGrid(turnLeft(arm).dot(arm_rate) / arm.squaredNorm(), kYawRateGrid);
  return state;
}

void TwoMassPhysics::substep(const Model& model, const Eigen::Vector2d& command, Bodies& bodies) {
  two_mass::substep(model, command, bodies);
}

template class PlanarSimulator<TwoMassPhysics>;

}  // namespace pusht
