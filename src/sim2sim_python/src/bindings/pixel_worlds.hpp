// SPDX-License-Identifier: BSD-3-Clause
/// Worlds of the task gym_pusht in gym-pusht's own units, as arrays.
#pragma once

#include <pybind11/numpy.h>

#include <array>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pusht_task/gym_pusht.hpp"

namespace sim2sim::python {

/// Numbers of a state for Python: pusher x, y, its velocity, tee x, y, angle [px, px/s, rad].
constexpr pybind11::ssize_t kPixelNumbers = 7;
std::array<double, kPixelNumbers> numbersInPixels(const pusht::gym_pusht::State& state);

/// Worlds that step together, each in the units of gym_pusht::State.
class PixelWorlds {
 public:
  using Numbers = pybind11::array_t<double, pybind11::array::c_style | pybind11::array::forcecast>;
  using Mask = pybind11::array_t<bool, pybind11::array::c_style>;
  using Point = std::pair<double, double>;

  /// `parameters` of the kind by name. A kind other than gym_pusht takes no variant. Throws as SimulatorKinds::named,
  /// ParameterSet::set and SimulatorKind::load, and InvalidInput for a variant of another kind.
  PixelWorlds(const std::string& kind, const pybind11::dict& parameters, int worlds, std::optional<Point> block_cog,
              std::optional<double> damping);

  /// Begins an episode in one world: pusher x, y, tee x, y [px], angle [rad], as gym-pusht's `reset_to_state`.
  /// Throws InvalidInput for a state that is not plausible.
  void reset(int world, const Numbers& asked);

  /// Takes a control step in the worlds of `mask`, towards their rows of `targets` [n, 2] [px]. Throws SimulationFault
  /// if a state is no longer plausible.
  void step(const Numbers& targets, const Mask& mask);

  pybind11::array_t<double> states() const;           ///< [n, kPixelNumbers] numbersInPixels()
  pybind11::array_t<double> unwrappedAngles() const;  ///< [n] gym_pusht::World::unwrappedAngle()
  pybind11::array_t<double> coverages() const;        ///< [n] share of the target that is covered
  pybind11::array_t<double> rewards() const;          ///< [n] pusht::reward()
  pybind11::array_t<int> contacts() const;            ///< [n] gym_pusht::World::contacts()

 private:
  template <class Value, class Function>
  pybind11::array_t<Value> column(const Function& function) const;

  mutable std::mutex mutex_;  // another thread of Python may call it, too, while this one has no GIL
  std::vector<std::unique_ptr<pusht::gym_pusht::World>> worlds_;
};

}  // namespace sim2sim::python
