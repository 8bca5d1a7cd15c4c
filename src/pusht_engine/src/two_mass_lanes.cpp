// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_engine/two_mass_lanes.hpp"

#include <algorithm>

namespace pusht {
namespace {

using Group = two_mass::Bodies<simd::Lanes>;

/// Sets the bodies of one lane of a group.
void setLane(Group& group, std::size_t lane, const two_mass::Bodies<double>& bodies) {
  for (std::size_t body = 0; body < two_mass::kBodyCount; ++body) {
    for (Eigen::Index axis = 0; axis < 2; ++axis) {
      group.positions[body][axis][lane] = bodies.positions[body][axis];
      group.velocities[body][axis][lane] = bodies.velocities[body][axis];
    }
  }
}

/// Bodies of one lane of a group.
two_mass::Bodies<double> laneOf(const Group& group, std::size_t lane) {
  two_mass::Bodies<double> bodies;
  for (std::size_t body = 0; body < two_mass::kBodyCount; ++body) {
    for (Eigen::Index axis = 0; axis < 2; ++axis) {
      bodies.positions[body][axis] = group.positions[body][axis][lane];
      bodies.velocities[body][axis] = group.velocities[body][axis][lane];
    }
  }
  return bodies;
}

}  // namespace

TwoMassLanes::TwoMassLanes(int lanes, const TwoMassParameters& parameters)
    : model_(TwoMassPhysics::modelOf(parameters)),
      groups_((lanes + simd::kLaneCount - 1) / simd::kLaneCount),
      states_(lanes),
      faults_(lanes) {
  // Lanes that have not been reset are stepped with the others.
  for (Group& group : groups_) {
    for (std::size_t lane = 0; lane < simd::kLaneCount; ++lane) {
      setLane(group, lane, TwoMassPhysics::bodiesOf(WorldState()));
    }
  }
}

void TwoMassLanes::reset(int lane, const WorldState& state) {
  faults_.reset(lane, [&] {
    const WorldState start = checkedStart(state);
    const auto bodies = TwoMassPhysics::bodiesOf(start);
    states_.at(lane) = TwoMassPhysics::stateOf(bodies);
    setLane(groups_[lane / simd::kLaneCount], lane % simd::kLaneCount, bodies);
    requireStart(start, states_[lane], TwoMassPhysics::kStartTolerance);
  });
}

WorldState TwoMassLanes::state(int lane) const {
  faults_.raise(lane);
  return states_.at(lane);
}

void TwoMassLanes::step(Actions actions) {
  for (std::size_t group = 0; group < groups_.size(); ++group) {
    stepGroup(group, actions);
  }
}

void TwoMassLanes::stepGroup(std::size_t group, Actions actions) {
  const std::size_t first = group * simd::kLaneCount;
  const std::size_t end = std::min(first + simd::kLaneCount, states_.size());
  simd::Vector2<simd::Lanes> command(simd::Lanes(0.0), simd::Lanes(0.0));
  simd::Lanes::mask_type stepping(false);
  for (std::size_t lane = first; lane < end; ++lane) {
    if (!actions[lane] || faults_.has(lane)) {
      continue;
    }
    faults_.step(lane, [&] {
      const Action action = checkedAction(*actions[lane]);
      command.x()[lane - first] = action[0];
      command.y()[lane - first] = action[1];
      stepping[lane - first] = true;
    });
  }
  if (!simd::any(stepping)) {
    return;
  }

  Group stepped = groups_[group];
  for (int i = 0; i < kSubstepsPerControlStep; ++i) {
    two_mass::substep(model_, command, stepped);
  }
  for (std::size_t lane = first; lane < end; ++lane) {
    if (stepping[lane - first]) {
      const auto bodies = laneOf(stepped, lane - first);
      setLane(groups_[group], lane - first, bodies);
      states_[lane] = TwoMassPhysics::stateOf(bodies);
      faults_.step(lane, [&] { requirePlausibleStep(states_[lane]); });
    }
  }
}

}  // namespace pusht
