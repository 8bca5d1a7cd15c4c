// SPDX-License-Identifier: BSD-3-Clause
/// The seam behind which a simulator lives.
#pragma once

#include "pusht_task/types.hpp"

namespace pusht {

/// The rules of every reset and step, for whoever implements them without Simulator.

/// `state` with its yaw wrapped. Throws InvalidInput if a number is not finite.
WorldState checkedStart(const WorldState& state);
/// `action` clipped as the task says. Throws InvalidInput if it is not finite.
Action checkedAction(const Action& action);
/// Throws SimulationFault if the world was left with a `state` that is not finite.
void requireFiniteStep(const WorldState& state);

/// One world. What is PushT and not physics (checking and clipping of actions, finite states) happens
/// here, once; a simulator only implements the three `do` functions. After an exception a world
/// must be reset.
class Simulator {
 public:
  Simulator() = default;
  Simulator(const Simulator&) = delete;
  Simulator& operator=(const Simulator&) = delete;
  virtual ~Simulator() = default;

  /// Starts from `state` (projected onto what the simulator can represent); deterministic, clears all
  /// hidden state. Throws InvalidInput if a number is not finite; the world is then as it was.
  void reset(const WorldState& state);

  /// One control step with `action`, clipped as the task says. Success never stops a world.
  /// Throws InvalidInput before the first reset or if the action is not finite, with the world as it was;
  /// SimulationFault if the simulation itself fails or leaves the finite numbers.
  void step(const Action& action);

  /// After reset(s): s to 1e-12 where s can be represented; a reset to that changes nothing, bit for bit.
  WorldState state() const { return doState(); }

 private:
  virtual void doReset(const WorldState& state) = 0;
  virtual void doStep(const Action& action) = 0;
  virtual WorldState doState() const = 0;

  bool ready_ = false;
};

}  // namespace pusht
