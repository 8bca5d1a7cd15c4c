// SPDX-License-Identifier: BSD-3-Clause
/// Interface of a simulator.
#pragma once

#include <cstdint>
#include <string>

#include "pusht_task/constants.hpp"
#include "pusht_task/task.hpp"
#include "pusht_task/types.hpp"

namespace pusht {

namespace gym_pusht {
struct State;
}

// Rules of every reset and step, for implementations without Simulator.

/// `state` with its yaw wrapped. Throws InvalidInput if a number is not finite or beyond what is plausible.
WorldState checkedStart(const WorldState& state);
/// `action` clipped as the task says. Throws InvalidInput if it is not finite.
Action checkedAction(const Action& action, const Task& task = fullCircle());
/// Text of the fault of a world that is in `state` after a reset to `start`; empty if there is none. Faults: a pose off
/// by more than `tolerance` [m, rad], a speed above `tolerance` [m/s, rad/s] if `start` is at rest, a number that is
/// not finite, a yaw that is not wrapped.
std::string faultOfStart(const WorldState& start, const WorldState& state, double tolerance = kStartTolerance);
/// Throws SimulationFault with the result of faultOfStart(), if it is not empty.
void requireStart(const WorldState& start, const WorldState& state, double tolerance);
/// Returns `tolerance` [m, rad, m/s, rad/s]. Throws InvalidInput unless it is above 0 and at most kStartTolerance.
double checkedStartTolerance(double tolerance);
/// Throws SimulationFault with field, value and rule if the `state` after a step is not finite, out of the plausible
/// range, or has a yaw that is not wrapped.
void requirePlausibleStep(const WorldState& state);

/// World of PushT. This class checks and clips actions and checks states, once for all simulators; a simulator
/// implements the physics in the three `do` functions. InvalidInput leaves a world as it was; after any other exception
/// it must be reset. Not thread-safe.
class Simulator {
 public:
  /// `name` stands in front of the faults that this class finds; the `do` functions name the world in theirs.
  /// `start_tolerance`: see startTolerance(). Throws InvalidInput as checkedStartTolerance().
  explicit Simulator(std::string name = "", double start_tolerance = kStartTolerance, const Task& task = fullCircle());
  Simulator(const Simulator&) = delete;
  Simulator& operator=(const Simulator&) = delete;
  virtual ~Simulator() = default;

  /// Sets the world to `state`; velocities may be projected onto what the simulator can represent, poses may not.
  /// Deterministic; clears all hidden state. Throws InvalidInput if a number is not finite or beyond the plausible
  /// range, and leaves the world as it was; SimulationFault if the world then deviates from `state` by more than
  /// startTolerance().
  void reset(const WorldState& state);

  /// Sets the world to the start that its task draws for `seed`, as reset(spawn(seed, task())) does, but with all bits
  /// of the draw, should a WorldState not have them. Throws as reset(), and InvalidInput for a seed beyond the task's
  /// last.
  void spawn(std::uint64_t seed);

  /// Sets the world to `start`, which another process has drawn for `seed`, as spawn(seed). Throws InvalidInput, too,
  /// if it is not that draw to kStartTolerance: last bits are those of a libm.
  void spawn(std::uint64_t seed, const WorldState& start);

  /// Takes one control step with `action`, clipped as the task says. Success never stops a world.
  /// Throws InvalidInput before a reset, the first one or the one after a fault, or if the action is not finite, with
  /// the world as it was;
  /// SimulationFault if the simulation itself fails or leaves the plausible range (constants.hpp).
  void step(const Action& action);

  /// State of the world. After reset(s) it is s to startTolerance(), as far as s can be represented; a reset to it
  /// changes no bit of it. It has no meaning before the first reset or after a fault.
  WorldState state() const { return doState(); }

  /// State in gym-pusht's frame of a world that is computed there, with bits that state() has not. Null for any other
  /// world. It is valid until the world is next reset or stepped.
  virtual const gym_pusht::State* stateInPixels() const { return nullptr; }

  /// Maximum deviation of the state after a reset from the requested state [m, rad, m/s, rad/s].
  double startTolerance() const { return start_tolerance_; }

  /// Task of the world.
  const Task& task() const { return *task_; }

 private:
  virtual void doReset(const WorldState& state) = 0;
  /// `start` is the task's draw for `seed`, but for last bits.
  virtual void doSpawn(const WorldState& start, std::uint64_t /*seed*/) { doReset(start); }
  virtual void doStep(const Action& action) = 0;
  virtual WorldState doState() const = 0;

  template <class Reset>
  void startChecked(const WorldState& start, const Reset& reset);

  std::string name_;
  double start_tolerance_;
  const Task* task_;
  bool ready_ = false;
};

}  // namespace pusht
