// SPDX-License-Identifier: BSD-3-Clause
/// Worlds of one kind with the bookkeeping of their episodes, as arrays.
#pragma once

#include <pybind11/numpy.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "pusht_task/batch_simulator.hpp"
#include "pusht_task/task.hpp"

namespace sim2sim::python {

/// Names of the numbers of a world state, in the order of the arrays.
std::vector<std::string> stateFields();

/// Worlds that step together, each with its success latch and its number of control steps.
class WorldBatch {
 public:
  using Mask = pybind11::array_t<bool, pybind11::array::c_style>;
  using States = pybind11::array_t<double, pybind11::array::c_style>;
  using Actions = pybind11::array_t<float, pybind11::array::c_style>;

  /// `parameters` of the kind by name; `task` as for taskNamed(), empty: the kind's own. Throws as
  /// SimulatorKinds::named, taskNamed(), ParameterSet::set and SimulatorKind::load.
  WorldBatch(const std::string& kind, const pybind11::dict& parameters, int worlds, const std::string& task);

  /// Largest action of the task per axis; infinity: actions are not clipped.
  double actionLimit() const;

  /// Whether coverage decides on success.
  bool isJudgedByCoverage() const { return task_->success.coverage.has_value(); }

  /// First seed of the task's comparisons: below it are those for training.
  std::uint64_t firstSpawnSeed() const { return task_->first_spawn_seed; }

  /// Begins an episode in one world, from the spawn of `seed`.
  void spawn(int world, std::uint64_t seed);

  /// Begins an episode in one world, from the numbers of stateFields().
  void reset(int world, const States& state);

  /// Takes a control step in the worlds of `mask`, with their rows of `actions`. Throws InvalidInput before a step if
  /// an action is not finite; SimulationFault, naming the first world that failed, after all have stepped.
  void step(const Actions& actions, const Mask& mask);

  int worlds() const { return static_cast<int>(episodes_.size()); }

  pybind11::array_t<float> observations() const;     ///< [n, 10]
  pybind11::array_t<double> states() const;          ///< [n, stateFields()]
  pybind11::array_t<double> positionErrors() const;  ///< [n] [m]
  pybind11::array_t<double> angleErrors() const;     ///< [n] [rad]
  pybind11::array_t<double> coverages() const;       ///< [n] share of the target that is covered
  pybind11::array_t<double> rewards() const;         ///< [n] of the last step; 0 after a reset
  pybind11::array_t<bool> successes() const;         ///< [n]
  pybind11::array_t<std::int64_t> steps() const;     ///< [n] control steps since the reset

 private:
  struct Episode {
    pusht::WorldState state;
    pusht::SuccessLatch latch;
    double reward = 0.0;
    std::int64_t steps = 0;
  };

  template <class Reset>
  void begin(int world, const Reset& reset);
  void record(std::size_t world);

  template <class Value, class Function>
  pybind11::array_t<Value> column(const Function& function) const;

  const pusht::Task* task_;
  std::unique_ptr<pusht::BatchSimulator> worlds_;
  std::vector<Episode> episodes_;
  std::vector<std::optional<pusht::Action>> actions_;
  mutable std::mutex mutex_;  // another thread of Python may call it, too, while this one has no GIL
};

}  // namespace sim2sim::python
