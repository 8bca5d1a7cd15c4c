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
///     // One substep to `command`: a velocity [m/s], or a position [m] as the task has it.
///     static void substep(const Model&, const Eigen::Vector2d& command, Bodies&);
///   };
///
/// Instantiate PlanarSimulator<Physics> in the engine's library, and declare it `extern template` in its header
/// (two_mass_engine.hpp): the provenance names the libraries whose code decides.
#pragma once

#include <optional>
#include <utility>

#include "pusht_task/mapping.hpp"
#include "pusht_task/simulator.hpp"

namespace pusht {

/// One world of a planar physics.
template <class Physics>
class PlanarSimulator : public Simulator {
 public:
  using Parameters = typename Physics::Parameters;
  using Bodies = typename Physics::Bodies;

  using Model = typename Physics::Model;

  /// Throws InvalidInput if a parameter is out of range.
  explicit PlanarSimulator(const Parameters& parameters = {});

  /// World of a task. Its bodies have the tee at the point where the table acts on it.
  PlanarSimulator(Model model, const Task& task);

  const Bodies& bodies() const { return bodies_; }

 private:
  void doReset(const WorldState& state) override;
  void doStep(const Action& action) override;
  WorldState doState() const override;

  Model model_;
  Bodies bodies_;
  std::optional<WorldState> start_;  ///< until the first step, if the bodies do not have the tee at its origin
};

// Members are defined outside the class: inline functions would be compiled by every caller, with its own options.

template <class Physics>
PlanarSimulator<Physics>::PlanarSimulator(const Parameters& parameters)
    : PlanarSimulator(Physics::modelOf(parameters), fullCircle()) {}

template <class Physics>
PlanarSimulator<Physics>::PlanarSimulator(Model model, const Task& task)
    : Simulator("", Physics::kStartTolerance, task),
      model_(std::move(model)),
      bodies_(Physics::bodiesOf(WorldState())) {}

template <class Physics>
void PlanarSimulator<Physics>::doReset(const WorldState& state) {
  const double point = task().physics.table_point;
  bodies_ = Physics::bodiesOf(atPointOfTee(state, point));
  start_.reset();
  if (point != 0.0) {
    requireStart(state, atPointOfTee(Physics::stateOf(bodies_), -point), startTolerance());
    start_ = state;
  }
}

template <class Physics>
WorldState PlanarSimulator<Physics>::doState() const {
  return start_ ? *start_ : atPointOfTee(Physics::stateOf(bodies_), -task().physics.table_point);
}

template <class Physics>
void PlanarSimulator<Physics>::doStep(const Action& action) {
  const Eigen::Vector2d command = commandOf(action, task());
  start_.reset();
  const int substeps = Physics::substepsOf(model_);
  for (int i = 0; i < substeps; ++i) {
    Physics::substep(model_, command, bodies_);
  }
}

}  // namespace pusht
