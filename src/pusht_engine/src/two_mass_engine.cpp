// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_engine/two_mass_engine.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"

namespace pusht {

using two_mass::Bodies;
using two_mass::kBar;
using two_mass::kLaneCount;
using two_mass::kPusher;
using two_mass::kStem;
using two_mass::Lanes;

namespace {

// Yaw and its rate are read from the masses, with rounding errors of some 1e-15. Read on a grid a little
// coarser than that, a state that was read and set is read as it was set, bit for bit (within 4 m, 10 m/s).
constexpr double kYawGrid = 0x1p-46;                                // [rad]
constexpr double kYawRateGrid = 0x1p-44;                            // [rad/s]
const double kGreatestYaw = std::floor(kPi / kYawGrid) * kYawGrid;  // [rad]

/// The multiple of `spacing`, a power of two, that is nearest to `value`.
double onGrid(double value, double spacing) { return std::nearbyint(value / spacing) * spacing; }

Eigen::Vector2d turnLeft(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

/// Throws InvalidInput if a knob is out of range.
two_mass::Model modelOf(const TwoMassParameters& parameters) {
  parameters.validate();
  return {{parameters.pusher_mass, kBarMass, kStemMass},
          {1.0 / parameters.pusher_mass, 1.0 / kBarMass, 1.0 / kStemMass},
          parameters.block_damp,
          parameters.baumgarte};
}

/// The bodies of a tee with its link at rest length.
Bodies<double> bodiesOf(const WorldState& state) {
  const Eigen::Vector2d offset(kStemOffset * std::sin(state.tee_yaw), -kStemOffset * std::cos(state.tee_yaw));
  return {{state.pusher_position, state.tee_position, state.tee_position + offset},
          {state.pusher_velocity, state.tee_velocity, state.tee_velocity + state.tee_yaw_rate * turnLeft(offset)}};
}

WorldState stateOf(const Bodies<double>& bodies) {
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

/// Calls function(number of one world, number of the same kind of many) for every number of the bodies.
template <class One, class Many, class Function>
void forEachNumber(One& one, Many& many, Function function) {
  for (std::size_t body = 0; body < two_mass::kBodyCount; ++body) {
    for (Eigen::Index axis = 0; axis < 2; ++axis) {
      function(one.positions[body][axis], many.positions[body][axis]);
      function(one.velocities[body][axis], many.velocities[body][axis]);
    }
  }
}

void setLane(Bodies<Lanes>& group, std::size_t lane, const Bodies<double>& bodies) {
  forEachNumber(bodies, group, [lane](double one, Lanes& many) { many[lane] = one; });
}

Bodies<double> laneOf(const Bodies<Lanes>& group, std::size_t lane) {
  Bodies<double> bodies;
  forEachNumber(bodies, group, [lane](double& one, const Lanes& many) { one = many[lane]; });
  return bodies;
}

}  // namespace

ParameterDescriptor two_mass::Knob::descriptor() const {
  return {name, unit, meaning, TwoMassParameters().*value, least, greatest, reason};
}

double two_mass::greatestBaumgarte(double block_damp) {
  return (std::sqrt(8.0 - 2.0 * kSubstep * block_damp) - 2.0) / kSubstep;
}

void TwoMassParameters::validate() const {
  for (const two_mass::Knob& knob : two_mass::kKnobs) {
    knob.descriptor().require(this->*knob.value);
  }
  const double greatest = two_mass::greatestBaumgarte(block_damp);
  if (!(baumgarte < greatest)) {
    throw InvalidInput("baumgarte " + shortestText(baumgarte) + ": must be below " + fixedText(greatest, 2) +
                       " [rad/s] with block_damp " + shortestText(block_damp) + ": a stiffer link shakes itself apart");
  }
}

TwoMassEngine::TwoMassEngine(const TwoMassParameters& parameters)
    : model_(modelOf(parameters)), bodies_(bodiesOf(WorldState())) {}

void TwoMassEngine::doReset(const WorldState& state) { bodies_ = bodiesOf(state); }

WorldState TwoMassEngine::doState() const { return stateOf(bodies_); }

void TwoMassEngine::doStep(const Action& action) {
  const Eigen::Vector2d command(action[0], action[1]);
  for (int i = 0; i < kSubstepsPerControlStep; ++i) {
    two_mass::substep(model_, command, bodies_);
  }
}

TwoMassLanes::TwoMassLanes(int lanes, const TwoMassParameters& parameters)
    : model_(modelOf(parameters)),
      groups_((lanes + kLaneCount - 1) / kLaneCount),
      states_(lanes),
      errors_(lanes, std::make_exception_ptr(InvalidInput("step: the world must be reset first"))) {
  // Lanes that nobody has reset are stepped with the others.
  for (std::size_t lane = 0; lane < groups_.size() * kLaneCount; ++lane) {
    setLane(groups_[lane / kLaneCount], lane % kLaneCount, bodiesOf(WorldState()));
  }
}

void TwoMassLanes::reset(int lane, const WorldState& state) {
  const Bodies<double> bodies = bodiesOf(checkedStart(state));
  setLane(groups_.at(lane / kLaneCount), lane % kLaneCount, bodies);
  states_.at(lane) = stateOf(bodies);
  errors_.at(lane) = nullptr;
}

WorldState TwoMassLanes::state(int lane) const {
  if (errors_.at(lane) != nullptr) {
    std::rethrow_exception(errors_.at(lane));
  }
  return states_.at(lane);
}

void TwoMassLanes::step(Actions actions) {
  for (std::size_t group = 0; group < groups_.size(); ++group) {
    stepGroup(group, actions);
  }
}

void TwoMassLanes::stepGroup(std::size_t group, Actions actions) {
  const std::size_t first = group * kLaneCount;
  const std::size_t end = std::min(first + kLaneCount, states_.size());
  two_mass::Vector2<Lanes> command(Lanes(0.0), Lanes(0.0));
  Lanes::mask_type stepping(false);
  for (std::size_t lane = first; lane < end; ++lane) {
    if (!actions[lane] || errors_[lane] != nullptr) {
      continue;
    }
    try {
      const Action action = checkedAction(*actions[lane]);
      command.x()[lane - first] = action[0];
      command.y()[lane - first] = action[1];
      stepping[lane - first] = true;
    } catch (const Error&) {
      errors_[lane] = std::current_exception();
    }
  }
  if (!two_mass::any(stepping)) {
    return;
  }

  Group stepped = groups_[group];
  for (int i = 0; i < kSubstepsPerControlStep; ++i) {
    two_mass::substep(model_, command, stepped);
  }
  for (std::size_t lane = first; lane < end; ++lane) {
    if (stepping[lane - first]) {
      const Bodies<double> bodies = laneOf(stepped, lane - first);
      setLane(groups_[group], lane - first, bodies);
      states_[lane] = stateOf(bodies);
      try {
        requirePlausibleStep(states_[lane]);
      } catch (const Error&) {
        errors_[lane] = std::current_exception();
      }
    }
  }
}

}  // namespace pusht
