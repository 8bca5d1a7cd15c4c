// SPDX-License-Identifier: BSD-3-Clause
/// Interface of a simulator.
#pragma once

#include <string>

#include "pusht_task/constants.hpp"
#include "pusht_task/types.hpp"

namespace pusht {

/// The rules of every reset and step, for whoever implements them without Simulator.

/// `state` with its yaw wrapped. Throws InvalidInput if a number is not finite or beyond what is plausible.
WorldState checkedStart(const WorldState& state);
/// `action` clipped as the task says. Throws InvalidInput if it is not finite.
Action checkedAction(const Action& action);
/// What is wrong with a world that is in `state` after a reset to `start`: a pose that is not the one of `start`,
/// motion where there was none, both to `tolerance` [m, rad, m/s, rad/s]; a yaw that is not wrapped; empty if nothing.
std::string faultOfStart(const WorldState& start, const WorldState& state, double tolerance = kStartTolerance);
/// Throws SimulationFault with what faultOfStart finds.
void requireStart(const WorldState& start, const WorldState& state, double tolerance);
/// `tolerance` [m, rad, m/s, rad/s]. Throws InvalidInput unless it is above 0 and at most kStartTolerance.
double checkedStartTolerance(double tolerance);
/// Throws SimulationFault with field, value and rule if a step has left a `state` that is no data: not finite, out of
/// range, or with a yaw that is not wrapped.
void requirePlausibleStep(const WorldState& state);

/// One world. What is PushT and not physics (checking and clipping of actions, checking of states) happens
/// here, once; a simulator only implements the three `do` functions. After an exception a world
/// must be reset.
class Simulator {
 public:
  /// `name` tells whose faults they are, in their messages. `start_tolerance` [m, rad, m/s, rad/s] is how near to where
  /// it was told to the world starts. Throws InvalidInput as checkedStartTolerance.
  explicit Simulator(std::string name = "", double start_tolerance = kStartTolerance);
  Simulator(const Simulator&) = delete;
  Simulator& operator=(const Simulator&) = delete;
  virtual ~Simulator() = default;

  /// Starts from `state` (projected onto what the simulator can represent); deterministic, clears all
  /// hidden state. Throws InvalidInput if a number is not finite or beyond what is plausible; the world is then as it
  /// was. SimulationFault if the world is elsewhere then, by more than startTolerance().
  void reset(const WorldState& state);

  /// One control step with `action`, clipped as the task says. Success never stops a world.
  /// Throws InvalidInput before the first reset or if the action is not finite, with the world as it was;
  /// SimulationFault if the simulation itself fails or leaves the plausible range (constants.hpp).
  void step(const Action& action);

  /// After reset(s): s to startTolerance() where s can be represented; a reset to that changes nothing, bit for bit.
  WorldState state() const { return doState(); }

  /// [m, rad, m/s, rad/s] How near to where it was told to the world starts.
  double startTolerance() const { return start_tolerance_; }

 private:
  virtual void doReset(const WorldState& state) = 0;
  virtual void doStep(const Action& action) = 0;
  virtual WorldState doState() const = 0;

  std::string name_;
  double start_tolerance_;
  bool ready_ = false;
};

}  // namespace pusht
