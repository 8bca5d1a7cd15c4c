// SPDX-License-Identifier: BSD-3-Clause
/// All of an engine of our own but its physics: one world, and many that step together in SIMD lanes. The physics is
/// written once, over a number type Real that is double for one world and simd::Lanes for several:
///
///   struct Physics {
///     struct Parameters;                         // the knobs
///     struct Model;                              // what a substep depends on, besides the bodies
///     template <class Real> struct Bodies;       // every number of a world that changes, hidden ones too
///     static constexpr double kStartTolerance;   // [m, rad, m/s, rad/s] as SimulatorKind::start_tolerance
///     static Model modelOf(const Parameters&);   // throws InvalidInput if a knob is out of range
///     static Bodies<double> bodiesOf(const WorldState&);  // of a fresh world that starts there
///     static WorldState stateOf(const Bodies<double>&);
///
///     // One substep in which the pusher is to move with velocity `command` [m/s]. A lane comes out as it would alone:
///     // while the others go on, nothing changes in one that has come to its end.
///     template <class Real>
///     static void substep(const Model&, const simd::Vector2<Real>& command, Bodies<Real>&);
///
///     // Calls function(number of `one`, the same number of `many`) for every number of the bodies.
///     template <class One, class Many, class Function>
///     static void forEachNumber(One& one, Many& many, Function function);
///   };
///
/// PlanarSimulator<Physics> and PlanarLanes<Physics> are to be instantiated in the engine's library and declared
/// `extern template` in its header (two_mass_engine.hpp): the provenance names the libraries whose code decides.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "pusht_engine/simd.hpp"
#include "pusht_task/batch_simulator.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/simulator.hpp"

namespace pusht {

/// One world.
template <class Physics>
class PlanarSimulator : public Simulator {
 public:
  using Parameters = typename Physics::Parameters;
  using Bodies = typename Physics::template Bodies<double>;

  /// Throws InvalidInput if a knob is out of range.
  explicit PlanarSimulator(const Parameters& parameters = {});

  const Bodies& bodies() const { return bodies_; }

 private:
  void doReset(const WorldState& state) override;
  void doStep(const Action& action) override;
  WorldState doState() const override;

  typename Physics::Model model_;
  Bodies bodies_;
};

/// The same for many worlds: they step together in SIMD lanes.
template <class Physics>
class PlanarLanes : public BatchSimulator {
 public:
  using Parameters = typename Physics::Parameters;

  /// Throws InvalidInput if a knob is out of range.
  explicit PlanarLanes(int lanes, const Parameters& parameters = {});

  int lanes() const override;
  void reset(int lane, const WorldState& state) override;
  void step(Actions actions) override;
  WorldState state(int lane) const override;

 private:
  using Bodies = typename Physics::template Bodies<double>;
  using Group = typename Physics::template Bodies<simd::Lanes>;

  void stepGroup(std::size_t group, Actions actions);
  void setLane(std::size_t lane, const Bodies& bodies);

  typename Physics::Model model_;
  std::vector<Group> groups_;  // lane i is lane i % kLaneCount of group i / kLaneCount
  std::vector<WorldState> states_;
  LaneFaults faults_;
};

// Not in the classes: as inline functions they would be compiled by whoever calls them, with options of their own.

template <class Physics>
PlanarSimulator<Physics>::PlanarSimulator(const Parameters& parameters)
    : Simulator("", Physics::kStartTolerance),
      model_(Physics::modelOf(parameters)),
      bodies_(Physics::bodiesOf(WorldState())) {}

template <class Physics>
void PlanarSimulator<Physics>::doReset(const WorldState& state) {
  bodies_ = Physics::bodiesOf(state);
}

template <class Physics>
WorldState PlanarSimulator<Physics>::doState() const {
  return Physics::stateOf(bodies_);
}

template <class Physics>
void PlanarSimulator<Physics>::doStep(const Action& action) {
  const simd::Vector2<double> command(action[0], action[1]);
  for (int i = 0; i < kSubstepsPerControlStep; ++i) {
    Physics::substep(model_, command, bodies_);
  }
}

template <class Physics>
PlanarLanes<Physics>::PlanarLanes(int lanes, const Parameters& parameters)
    : model_(Physics::modelOf(parameters)),
      groups_((lanes + simd::kLaneCount - 1) / simd::kLaneCount),
      states_(lanes),
      faults_(lanes) {
  // Lanes that nobody has reset are stepped with the others.
  for (std::size_t lane = 0; lane < groups_.size() * simd::kLaneCount; ++lane) {
    setLane(lane, Physics::bodiesOf(WorldState()));
  }
}

template <class Physics>
int PlanarLanes<Physics>::lanes() const {
  return static_cast<int>(states_.size());
}

template <class Physics>
void PlanarLanes<Physics>::reset(int lane, const WorldState& state) {
  faults_.reset(lane, [&] {
    const WorldState start = checkedStart(state);
    const Bodies bodies = Physics::bodiesOf(start);
    states_.at(lane) = Physics::stateOf(bodies);
    setLane(lane, bodies);
    requireStart(start, states_[lane], Physics::kStartTolerance);
  });
}

template <class Physics>
WorldState PlanarLanes<Physics>::state(int lane) const {
  faults_.raise(lane);
  return states_.at(lane);
}

template <class Physics>
void PlanarLanes<Physics>::step(Actions actions) {
  for (std::size_t group = 0; group < groups_.size(); ++group) {
    stepGroup(group, actions);
  }
}

template <class Physics>
void PlanarLanes<Physics>::stepGroup(std::size_t group, Actions actions) {
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
    Physics::substep(model_, command, stepped);
  }
  for (std::size_t lane = first; lane < end; ++lane) {
    if (stepping[lane - first]) {
      Bodies bodies;
      Physics::forEachNumber(bodies, stepped, [&](double& one, const simd::Lanes& many) { one = many[lane - first]; });
      setLane(lane, bodies);
      states_[lane] = Physics::stateOf(bodies);
      faults_.step(lane, [&] { requirePlausibleStep(states_[lane]); });
    }
  }
}

template <class Physics>
void PlanarLanes<Physics>::setLane(std::size_t lane, const Bodies& bodies) {
  const std::size_t place = lane % simd::kLaneCount;
  Physics::forEachNumber(bodies, groups_[lane / simd::kLaneCount],
                         [place](double one, simd::Lanes& many) { many[place] = one; });
}

}  // namespace pusht
