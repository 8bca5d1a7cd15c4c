// SPDX-License-Identifier: BSD-3-Clause
#include "world_batch.hpp"

#include <pybind11/stl.h>

#include <algorithm>
#include <cstddef>
#include <exception>
#include <iterator>
#include <limits>
#include <variant>

#include "arguments.hpp"
#include "bindings.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/simulator.hpp"
#include "pusht_task/state_fields.hpp"
#include "sim2sim_serving/simulator_kinds.hpp"
#include "without_gil.hpp"

namespace sim2sim::python {
namespace {

namespace py = pybind11;

/// Runs `action`; an error of it then names the world, where there are several.
template <class Function>
void inWorld(std::size_t world, std::size_t count, const Function& action) {
  try {
    action();
  } catch (pusht::Error& error) {
    if (count > 1) {
      error.addContext("world " + std::to_string(world));
    }
    throw;
  }
}

py::object asObject(const pusht::ParameterValue& value) {
  return std::visit([](const auto& plain) { return py::cast(plain); }, value);
}

py::list parametersOf(const std::string& kind) {
  py::list parameters;
  for (const pusht::ParameterDescriptor& parameter : pusht::SimulatorKinds::installed().named(kind).parameters) {
    py::dict entry;
    entry["name"] = parameter.name;
    entry["type"] = parameter.type();
    entry["unit"] = parameter.unit;
    entry["default"] = asObject(parameter.default_value);
    entry["range"] = parameter.range();
    entry["meaning"] = parameter.meaning;
    parameters.append(entry);
  }
  return parameters;
}

}  // namespace

std::vector<std::string> stateFields() {
  std::vector<std::string> names;
  std::transform(pusht::kStateFields.begin(), pusht::kStateFields.end(), std::back_inserter(names),
                 [](const pusht::StateField& f) { return f.name; });
  return names;
}

WorldBatch::WorldBatch(const std::string& kind, const py::dict& parameters, int worlds, const std::string& task) {
  const pusht::SimulatorKind& chosen = pusht::SimulatorKinds::installed().named(kind);
  task_ = task.empty() ? &chosen.ownTask() : &pusht::taskNamed(task);
  worlds_ = chosen.load(parametersFrom(chosen, parameters), *task_).make_lanes(worlds);
  episodes_.resize(static_cast<std::size_t>(worlds));
  actions_.resize(static_cast<std::size_t>(worlds));
}

double WorldBatch::actionLimit() const { return task_->action_limit.value_or(std::numeric_limits<float>::infinity()); }

void WorldBatch::spawn(int world, std::uint64_t seed) {
  begin(world, [&] { worlds_->spawn(world, seed); });
}

void WorldBatch::reset(int world, const States& state) {
  pusht::WorldState start;
  for (std::size_t i = 0; i < pusht::kStateFields.size(); ++i) {
    pusht::kStateFields[i].of(start) = state.at(static_cast<py::ssize_t>(i));
  }
  begin(world, [&] { worlds_->reset(world, start); });
}

template <class Reset>
void WorldBatch::begin(int world, const Reset& reset) {
  const auto index = static_cast<std::size_t>(world);
  const WithoutGil released;
  const std::lock_guard<std::mutex> lock(mutex_);
  inWorld(index, episodes_.size(), [&] {
    reset();
    episodes_.at(index) = {worlds_->state(world), pusht::SuccessLatch(*task_), 0.0, 0};
  });
}

void WorldBatch::step(const Actions& actions, const Mask& mask) {
  const std::size_t count = episodes_.size();
  std::vector<std::optional<pusht::Action>> wanted(count);
  for (std::size_t world = 0; world < count; ++world) {
    const auto row = static_cast<py::ssize_t>(world);
    if (mask.at(row)) {
      wanted[world] = pusht::Action{actions.at(row, 0), actions.at(row, 1)};
      inWorld(world, count, [&] { pusht::checkedAction(*wanted[world], *task_); });
    }
  }
  const WithoutGil released;
  const std::lock_guard<std::mutex> lock(mutex_);
  actions_ = wanted;
  worlds_->step(actions_);
  std::exception_ptr first_fault;
  for (std::size_t world = 0; world < count; ++world) {
    if (!actions_[world]) {
      continue;
    }
    try {
      inWorld(world, count, [&] { record(world); });
    } catch (const pusht::Error&) {
      first_fault = first_fault ? first_fault : std::current_exception();
    }
  }
  if (first_fault) {
    std::rethrow_exception(first_fault);
  }
}

void WorldBatch::record(std::size_t world) {
  Episode& episode = episodes_[world];
  episode.state = worlds_->state(static_cast<int>(world));
  episode.reward = pusht::reward(episode.state, episode.latch.update(episode.state), *task_);
  ++episode.steps;
}

template <class Value, class Function>
py::array_t<Value> WorldBatch::column(const Function& function) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  py::array_t<Value> values(static_cast<py::ssize_t>(episodes_.size()));
  std::transform(episodes_.begin(), episodes_.end(), values.mutable_data(), function);
  return values;
}

py::array_t<float> WorldBatch::observations() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  py::array_t<float> rows({static_cast<py::ssize_t>(episodes_.size()), kNumbers});
  float* number = rows.mutable_data();
  for (const Episode& episode : episodes_) {
    const pusht::Observation observation = pusht::observe(episode.state, *task_);
    number = std::copy(observation.begin(), observation.end(), number);
  }
  return rows;
}

py::array_t<double> WorldBatch::states() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  py::array_t<double> rows({episodes_.size(), pusht::kStateFields.size()});
  double* number = rows.mutable_data();
  for (const Episode& episode : episodes_) {
    pusht::WorldState state = episode.state;
    number = std::transform(pusht::kStateFields.begin(), pusht::kStateFields.end(), number,
                            [&](const pusht::StateField& field) { return field.of(state); });
  }
  return rows;
}

py::array_t<double> WorldBatch::positionErrors() const {
  return column<double>([this](const Episode& episode) { return pusht::poseError(episode.state, *task_).position; });
}

py::array_t<double> WorldBatch::angleErrors() const {
  return column<double>([this](const Episode& episode) { return pusht::poseError(episode.state, *task_).angle; });
}

py::array_t<double> WorldBatch::coverages() const {
  return column<double>([this](const Episode& episode) { return pusht::coverageOf(episode.state, *task_); });
}

py::array_t<double> WorldBatch::rewards() const {
  return column<double>([](const Episode& episode) { return episode.reward; });
}

py::array_t<bool> WorldBatch::successes() const {
  return column<bool>([](const Episode& episode) { return episode.latch.latched(); });
}

py::array_t<std::int64_t> WorldBatch::steps() const {
  return column<std::int64_t>([](const Episode& episode) { return episode.steps; });
}

void bindWorldBatch(py::module_& module) {
  module.def("kinds", [] { return pusht::SimulatorKinds::installed().names(); });
  module.def("parameters_of", parametersOf, py::arg("kind"));
  module.attr("STATE_FIELDS") = py::tuple(py::cast(stateFields()));
  py::class_<WorldBatch>(module, "WorldBatch")
      .def(py::init<const std::string&, const py::dict&, int, const std::string&>(), py::arg("kind"),
           py::arg("parameters"), py::arg("worlds"), py::arg("task"))
      .def_property_readonly("action_limit", &WorldBatch::actionLimit)
      .def_property_readonly("judged_by_coverage", &WorldBatch::isJudgedByCoverage)
      .def_property_readonly("first_spawn_seed", &WorldBatch::firstSpawnSeed)
      .def_property_readonly("coverages", &WorldBatch::coverages)
      .def("spawn", &WorldBatch::spawn, py::arg("world"), py::arg("seed"))
      .def("reset", &WorldBatch::reset, py::arg("world"), py::arg("state"))
      .def("step", &WorldBatch::step, py::arg("actions"), py::arg("mask"))
      .def_property_readonly("observations", &WorldBatch::observations)
      .def_property_readonly("states", &WorldBatch::states)
      .def_property_readonly("position_errors", &WorldBatch::positionErrors)
      .def_property_readonly("angle_errors", &WorldBatch::angleErrors)
      .def_property_readonly("rewards", &WorldBatch::rewards)
      .def_property_readonly("successes", &WorldBatch::successes)
      .def_property_readonly("steps", &WorldBatch::steps);
}

}  // namespace sim2sim::python
