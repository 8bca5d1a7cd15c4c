// SPDX-License-Identifier: BSD-3-Clause
/// Simulator of a planar physics. The physics is a struct:
///
///   struct Physics {
///     struct Parameters;
///     struct Model;                              // constants of a substep
///     struct Bodies;                             // every number of a world that changes, hidden ones too
///     static constexpr double kStartTolerance;   // [m, rad, m/s, rad/s] as SimulatorKind::start_tolerance
///     static Model modelOf(const Parameters&);   // throws InvalidInput if a parameter is out of range
///     static Bodies bodiesOf(const WorldState&);  // bodies of a fresh world that starts there
///     static WorldState stateOf(const Bodies&);
///     static int substepsOf(const Model&);        // number of substeps in a control step
///     // One substep in which the pusher is to move with velocity `command` [m/s].
///     static void substep(const Model&, const Eigen::Vector2d& command, Bodies&);
///   };
///
/// Instantiate PlanarSimulator<Physics> in the engine's library, and declare it `extern template` in its header
/// (two_mass_engine.hpp): the provenance names the libraries whose code decides.
#pragma once

#include "pusht_task/simulator.hpp"

namespace pusht {

/// One world of a planar physics.
template <class Physics>
class PlanarSimulator : public Simulator {
 public:
  using Parameters = typename Physics::Parameters;
  using Bodies = typename Physics::Bodies;

  /// Throws InvalidInput if a parameter is out of range.
  explicit PlanarSimulator(const Parameters& parameters = {});

  const Bodies& bodies() const { return bodies_; }

 private:
  void doReset(const WorldState& state) override;
  void doStep(const Action& action) override;
  WorldState doState() const override;

  typename Physics::Model model_;
  Bodies bodies_;
};

// Members are defined outside the class: inline functions would be compiled by every caller, with its own options.

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
  const Eigen::Vector2d command(action[0], action[1]);
  const int substeps = Physics::substepsOf(model_);
  for (int i = 0; i < substeps; ++i) {
    Physics::substep(model_, command, bodies_);
  }
}

}  // namespace pusht
