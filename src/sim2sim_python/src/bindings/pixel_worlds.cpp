// SPDX-License-Identifier: BSD-3-Clause
#include "pixel_worlds.hpp"

#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "arguments.hpp"
#include "bindings.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/simulator.hpp"
#include "pusht_task/task.hpp"
#include "sim2sim_serving/simulator_kinds.hpp"
#include "without_gil.hpp"

namespace sim2sim::python {
namespace {

namespace py = pybind11;
namespace gym = pusht::gym_pusht;

gym::Variant variantOf(std::optional<PixelWorlds::Point> block_cog, std::optional<double> damping) {
  gym::Variant variant;
  if (block_cog) {
    variant.block_cog = Eigen::Vector2d(block_cog->first, block_cog->second);
  }
  variant.damping = damping;
  return variant;
}

gym::State stateFrom(const double* numbers) {
  gym::State state;
  state.pusher = {numbers[0], numbers[1]};
  state.tee = {numbers[2], numbers[3]};
  state.angle = numbers[4];
  return state;
}

/// pusher x, y, tee x, y [px], angle [rad] that gym-pusht draws.
py::array_t<double> drawn(std::uint32_t seed) {
  const gym::State state = gym::drawn(seed);
  py::array_t<double> numbers(5);
  double* number = numbers.mutable_data();
  *number++ = state.pusher.x();
  *number++ = state.pusher.y();
  *number++ = state.tee.x();
  *number++ = state.tee.y();
  *number = state.angle;
  return numbers;
}

/// [n, 16] gym_pusht::keypoints() of worlds in `states` [n, 7], as PixelWorlds::states().
py::array_t<double> keypointsOf(const PixelWorlds::Numbers& states) {
  const py::ssize_t count = states.shape(0);
  py::array_t<double> corners({count, py::ssize_t{16}});
  double* number = corners.mutable_data();
  for (py::ssize_t world = 0; world < count; ++world) {
    gym::State state;
    state.tee = {states.at(world, 4), states.at(world, 5)};
    state.angle = states.at(world, 6);
    for (const Eigen::Vector2d& corner : gym::keypoints(state)) {
      *number++ = corner.x();
      *number++ = corner.y();
    }
  }
  return corners;
}

}  // namespace

std::array<double, kPixelNumbers> numbersInPixels(const gym::State& state) {
  return {state.pusher.x(), state.pusher.y(), state.pusher_velocity.x(), state.pusher_velocity.y(), state.tee.x(),
          state.tee.y(),    state.angle};
}

PixelWorlds::PixelWorlds(const std::string& kind, const py::dict& parameters, int worlds,
                         std::optional<Point> block_cog, std::optional<double> damping) {
  const pusht::SimulatorKind& chosen = pusht::SimulatorKinds::installed().named(kind);
  const pusht::SimulatorModel model = chosen.load(parametersFrom(chosen, parameters), pusht::gymPusht());
  if (model.make_in_pixels == nullptr && (block_cog || damping)) {
    throw pusht::InvalidInput(std::string(block_cog ? "block_cog" : "damping") + ": must be left out with the engine " +
                              kind + ", which has none");
  }
  for (int i = 0; i < worlds; ++i) {
    worlds_.push_back(model.make_in_pixels == nullptr ? gym::inPixels(model.make_world())
                                                      : model.make_in_pixels(variantOf(block_cog, damping)));
  }
}

void PixelWorlds::reset(int world, const Numbers& asked) {
  const gym::State start = stateFrom(asked.data());
  try {
    pusht::checkedStart(gym::toTable(start));
  } catch (pusht::Error& error) {
    error.addContext("reset_to_state");
    throw;
  }
  const WithoutGil released;
  const std::lock_guard<std::mutex> lock(mutex_);
  worlds_.at(static_cast<std::size_t>(world))->reset(start);
}

void PixelWorlds::step(const Numbers& targets, const Mask& mask) {
  const double* const target = targets.data();
  const bool* const steps = mask.data();
  const WithoutGil released;
  const std::lock_guard<std::mutex> lock(mutex_);
  for (std::size_t world = 0; world < worlds_.size(); ++world) {
    if (steps[world]) {
      worlds_[world]->step({target[2 * world], target[2 * world + 1]});
      pusht::requirePlausibleStep(gym::toTable(worlds_[world]->state()));
    }
  }
}

py::array_t<double> PixelWorlds::states() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  py::array_t<double> rows({static_cast<py::ssize_t>(worlds_.size()), kPixelNumbers});
  double* number = rows.mutable_data();
  for (const auto& world : worlds_) {
    const auto numbers = numbersInPixels(world->state());
    number = std::copy(numbers.begin(), numbers.end(), number);
  }
  return rows;
}

template <class Value, class Function>
py::array_t<Value> PixelWorlds::column(const Function& function) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  py::array_t<Value> values(static_cast<py::ssize_t>(worlds_.size()));
  std::transform(worlds_.begin(), worlds_.end(), values.mutable_data(),
                 [&](const auto& world) { return function(*world); });
  return values;
}

py::array_t<double> PixelWorlds::unwrappedAngles() const {
  return column<double>([](const gym::World& world) { return world.unwrappedAngle(); });
}

py::array_t<double> PixelWorlds::coverages() const {
  return column<double>(
      [](const gym::World& world) { return pusht::coverageOf(gym::toTable(world.state()), pusht::gymPusht()); });
}

py::array_t<double> PixelWorlds::rewards() const {
  return column<double>(
      [](const gym::World& world) { return pusht::reward(gym::toTable(world.state()), false, pusht::gymPusht()); });
}

py::array_t<int> PixelWorlds::contacts() const {
  return column<int>([](const gym::World& world) { return world.contacts(); });
}

void bindPixelWorlds(py::module_& module) {
  module.attr("GYM_PUSHT_FIRST_SEED") = gym::kFirstSeed;
  module.attr("GYM_PUSHT_SUCCESS") = gym::kSuccessCoverage;
  module.def("gym_pusht_drawn", drawn, py::arg("seed"));
  module.def("gym_pusht_keypoints", keypointsOf, py::arg("states"));
  py::class_<PixelWorlds>(module, "PixelWorlds")
      .def(py::init<const std::string&, const py::dict&, int, std::optional<PixelWorlds::Point>,
                    std::optional<double>>(),
           py::arg("kind"), py::arg("parameters"), py::arg("worlds"), py::arg("block_cog"), py::arg("damping"))
      .def("reset", &PixelWorlds::reset, py::arg("world"), py::arg("asked"))
      .def("step", &PixelWorlds::step, py::arg("targets"), py::arg("mask"))
      .def_property_readonly("states", &PixelWorlds::states)
      .def_property_readonly("unwrapped_angles", &PixelWorlds::unwrappedAngles)
      .def_property_readonly("coverages", &PixelWorlds::coverages)
      .def_property_readonly("rewards", &PixelWorlds::rewards)
      .def_property_readonly("contacts", &PixelWorlds::contacts);
}

}  // namespace sim2sim::python
