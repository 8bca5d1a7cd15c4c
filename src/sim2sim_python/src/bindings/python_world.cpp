// SPDX-License-Identifier: BSD-3-Clause
#include "python_world.hpp"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <variant>

#include "bindings.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/simulator.hpp"
#include "pusht_task/state_fields.hpp"
#include "pusht_task/task.hpp"
#include "sim2sim_serving/node_parameters.hpp"

namespace sim2sim::python {
namespace {

namespace py = pybind11;

/// What makes the worlds. Python's objects are used with the GIL alone: at the desk, and at the end.
struct Maker {
  py::object make;
  py::object world_state;  // class of the states
  std::string name;        // "python:mine"
  bool takes_task;         // as a keyword
};

py::object asObject(const pusht::ParameterValue& value) {
  return std::visit([](const auto& plain) -> py::object { return py::cast(plain); }, value);
}

py::dict keywordsOf(const pusht::ParameterSet& parameters) {
  py::dict keywords;
  for (const pusht::Parameter& parameter : parameters) {
    keywords[py::str(parameter.name())] = asObject(parameter.value);
  }
  return keywords;
}

py::object asObject(const Maker& maker, pusht::WorldState state) {
  py::dict numbers;
  for (const pusht::StateField& field : pusht::kStateFields) {
    numbers[field.name] = field.of(state);
  }
  return maker.world_state(**numbers);
}

/// State that `call` has returned. Throws BadDependency for anything else.
pusht::WorldState stateFrom(const Maker& maker, const char* call, const py::object& returned) {
  if (!py::isinstance(returned, maker.world_state)) {
    throw pusht::BadDependency(maker.name + ": " + call + " returned " +
                               std::string(py::str(py::type::of(returned).attr("__name__"))) +
                               ": must be a pusht_task.task.WorldState");
  }
  pusht::WorldState state;
  for (const pusht::StateField& field : pusht::kStateFields) {
    const py::object number = returned.attr(field.name);
    const double value = PyFloat_AsDouble(number.ptr());
    if (PyErr_Occurred() != nullptr) {
      PyErr_Clear();
      throw pusht::BadDependency(maker.name + ": " + call + " returned " + field.name + " " +
                                 std::string(py::repr(number)) + ": must be a number");
    }
    if (!std::isfinite(value)) {
      throw pusht::SimulationFault(maker.name + ": " + call + " returned " + field.name + " " +
                                   std::string(py::repr(number)) + ": must be finite");
    }
    field.of(state) = value;
  }
  return state;
}

class PythonWorld : public pusht::Simulator {
 public:
  PythonWorld(Desk& desk, std::shared_ptr<const Maker> maker, double start_tolerance,
              const pusht::ParameterSet& parameters, const pusht::Task& task)
      : Simulator(maker->name, start_tolerance, task), desk_(desk), maker_(std::move(maker)) {
    at([&] {
      py::dict keywords = keywordsOf(parameters);
      if (maker_->takes_task) {
        keywords[pusht::kTaskParameter] = textOf(task);
      }
      world_ = maker_->make(**keywords).release().ptr();
    });
  }
  PythonWorld(const PythonWorld&) = delete;
  PythonWorld& operator=(const PythonWorld&) = delete;
  ~PythonWorld() override {
    if (world_ != nullptr) {
      desk_.drop(world_);
    }
  }

 private:
  void doReset(const pusht::WorldState& state) override {
    at([&] { state_ = stateFrom(*maker_, "reset", world().attr("reset")(asObject(*maker_, state))); });
  }

  void doStep(const pusht::Action& action) override {
    at([&] {
      py::array_t<double> numbers(kAxes);  // a new one each time: the world may keep it
      std::copy(action.begin(), action.end(), numbers.mutable_data());
      state_ = stateFrom(*maker_, "step", world().attr("step")(numbers));
    });
  }

  pusht::WorldState doState() const override { return state_; }

  void at(const std::function<void()>& call) const { desk_.call(maker_->name, call); }
  py::handle world() const { return {world_}; }

  Desk& desk_;
  std::shared_ptr<const Maker> maker_;
  PyObject* world_ = nullptr;  // owned
  pusht::WorldState state_;
};

pusht::ParameterValue valueFrom(const py::handle& value) {
  if (py::isinstance<py::bool_>(value)) {
    return value.cast<bool>();
  }
  if (py::isinstance<py::int_>(value)) {
    return value.cast<std::int64_t>();
  }
  return py::isinstance<py::float_>(value) ? pusht::ParameterValue(value.cast<double>())
                                           : pusht::ParameterValue(value.cast<std::string>());
}

}  // namespace

ForeignKind kindOf(const py::object& worlds, Desk& desk) {
  const auto text = [&](const char* name) { return worlds.attr(name).cast<std::string>(); };
  ForeignKind foreign;
  foreign.name = "python:" + text("name");
  pusht::SimulatorKind& kind = foreign.kind;
  kind.name = text("name");
  kind.title = text("title").empty() ? kind.name : text("title");
  kind.version = text("version");
  const auto parameters = worlds.attr("parameters").cast<py::dict>();
  const bool takes_task = parameters.contains(pusht::kTaskParameter);
  if (takes_task) {
    kind.tasks.clear();  // the class refuses those that it does not hold
  }
  for (const auto& [name, value] : parameters) {
    if (name.cast<std::string>() == pusht::kTaskParameter) {
      continue;  // which the run has
    }
    pusht::ParameterDescriptor parameter;
    parameter.name = name.cast<std::string>();
    parameter.default_value = valueFrom(value);
    kind.parameters.push_back(std::move(parameter));
  }
  const auto tolerance = worlds.attr("start_tolerance").cast<double>();
  kind.start_tolerance = tolerance == 0.0 ? pusht::kStartTolerance : pusht::checkedStartTolerance(tolerance);
  const std::string python = py::str(py::module_::import("platform").attr("python_version")());
  foreign.code = {{"simulator", kind.name}, {"version", kind.version}, {"provenance", {{"python", python}}}};
  const auto maker = std::make_shared<const Maker>(
      Maker{worlds.attr("make"), py::module_::import("pusht_task.task").attr("WorldState"), foreign.name, takes_task});
  kind.loader = [&desk, maker, start_tolerance = kind.start_tolerance, python](const pusht::ParameterSet& set,
                                                                               const pusht::Task& task) {
    const auto make_world = [&desk, maker, start_tolerance, set, &task] {
      return std::make_unique<PythonWorld>(desk, maker, start_tolerance, set, task);
    };
    make_world();  // parameters that it refuses are refused before the run
    pusht::SimulatorModel model = pusht::modelOfWorlds(set, make_world);
    model.provenance = {{"python", python}, {"note", "a Python class: known by its name and version, not by its code"}};
    return model;
  };
  return foreign;
}

}  // namespace sim2sim::python
