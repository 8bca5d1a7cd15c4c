// SPDX-License-Identifier: BSD-3-Clause
#include "arguments.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "pusht_task/error.hpp"

namespace sim2sim::python {
namespace {

namespace py = pybind11;

bool isList(const py::handle& value) { return py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value); }

/// "--first-episode", or "--block_damp" where that is the option; a positional argument as it is.
std::string flagOf(const CLI::App& app, const std::string& name) {
  if (app.get_option_no_throw(name) != nullptr && app.get_option(name)->get_positional()) {
    return name;
  }
  std::string flag = "--" + name;
  if (app.get_option_no_throw(flag) == nullptr) {
    std::replace(flag.begin(), flag.end(), '_', '-');
  }
  return flag;
}

/// Arguments of one option.
class Option {
 public:
  Option(const CLI::App& app, std::string keyword)
      : keyword_(std::move(keyword)), flag_(flagOf(app, keyword_)), option_(app.get_option_no_throw(flag_)) {}

  bool isPositional() const { return option_ != nullptr && option_->get_positional(); }

  std::vector<std::string> arguments(const py::handle& value) const {
    if (py::isinstance<py::bool_>(value) && option_ != nullptr && !isFlag()) {
      return boolean(value.cast<bool>());
    }
    std::vector<std::string> values;
    if (py::isinstance<py::dict>(value)) {
      values = settings(py::reinterpret_borrow<py::dict>(value));
    } else if (isList(value)) {
      for (const py::handle& item : value) {
        values.push_back(textOf(item));
      }
      if (!mayBeRepeated()) {
        values = {CLI::detail::join(values, ",")};
      }
    } else {
      values = {textOf(value)};
    }
    return with(values);
  }

 private:
  bool isFlag() const { return option_->get_items_expected_max() == 0; }
  bool mayBeRepeated() const { return option_ != nullptr && option_->get_items_expected_max() > 1; }

  /// "--name=value" for each; an empty one as an argument of its own, for behind "=" the parser would take the next.
  std::vector<std::string> with(const std::vector<std::string>& values) const {
    if (isPositional()) {
      return values;
    }
    std::vector<std::string> arguments;
    for (const std::string& value : values) {
      if (value.empty()) {
        arguments.insert(arguments.end(), {flag_, value});
      } else {
        arguments.push_back(std::string(flag_).append("=").append(value));
      }
    }
    return arguments;
  }

  /// Arguments of an option whose value may be left out.
  std::vector<std::string> boolean(bool wanted) const {
    if (option_->get_items_expected_min() > 0) {
      return with({wanted ? "true" : "false"});  // which the option refuses, unless it takes any text
    }
    return wanted ? std::vector<std::string>{flag_} : std::vector<std::string>{};
  }

  /// NAME=VALUE for each entry.
  std::vector<std::string> settings(const py::dict& values) const {
    if (!mayBeRepeated()) {
      throw pusht::InvalidInput(keyword_ + " " + std::string(py::repr(values)) + ": must not be a dict");
    }
    std::vector<std::string> settings;
    for (const auto& [name, value] : values) {
      settings.push_back(std::string(py::str(name)).append("=").append(textOf(value)));
    }
    return settings;
  }

  std::string keyword_;
  std::string flag_;
  const CLI::Option* option_;  // null: there is no such option
};

}  // namespace

std::string textOf(const py::handle& value) {
  if (py::isinstance<py::bool_>(value)) {
    return value.cast<bool>() ? "true" : "false";
  }
  const py::object given = py::hasattr(value, "__fspath__") ? value.attr("__fspath__")() : py::object(py::str(value));
  std::string text;
  try {
    text = py::str(given);
  } catch (const py::error_already_set&) {  // a surrogate
    throw pusht::InvalidInput(std::string(py::repr(value)) + ": must be text that UTF-8 can hold");
  }
  if (text.find('\0') != std::string::npos) {
    throw pusht::InvalidInput(std::string(py::repr(value)) + ": must have no NUL character");
  }
  return text;
}

std::vector<std::string> argumentsOf(const CLI::App& app, const py::dict& options) {
  std::vector<std::string> arguments;
  std::vector<std::string> positional = {"--"};
  for (const auto& [name, value] : options) {
    if (value.is_none()) {
      continue;
    }
    if (std::string(py::str(name)) == "help") {  // is the command's
      throw pusht::InvalidInput("help: there is no such option; help(sim2sim.compare) says what there is");
    }
    const Option option(app, py::str(name));
    const std::vector<std::string> more = option.arguments(value);
    std::vector<std::string>& taker = option.isPositional() ? positional : arguments;
    taker.insert(taker.end(), more.begin(), more.end());
  }
  if (positional.size() > 1) {
    arguments.insert(arguments.end(), positional.begin(), positional.end());
  }
  return arguments;
}

pusht::ParameterSet parametersFrom(const pusht::SimulatorKind& kind, const py::dict& values) {
  pusht::ParameterSet parameters = kind.defaults();
  for (const auto& [name, value] : values) {
    parameters.set(py::str(name), textOf(value));
  }
  return parameters;
}

}  // namespace sim2sim::python
