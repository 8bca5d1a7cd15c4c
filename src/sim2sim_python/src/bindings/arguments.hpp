// SPDX-License-Identifier: BSD-3-Clause
/// Keywords of Python as the command line of a command, so that options, checks and messages are the command's.
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <vector>

#include "pusht_task/simulator_kind.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace sim2sim::python {

/// Text of one value: True as "true", a path as its name, anything else as Python prints it.
std::string textOf(const pybind11::handle& value);

/// Arguments for `app` that say what `options` say. A keyword is the name of an option, with underscores for dashes;
/// None: left out; True or False: a flag, and True also an option whose value may be left out; a list: the values of
/// an option that may be repeated, or one value with commas; a dict: NAME=VALUE for each entry of an option that may be
/// repeated. Positional arguments come last, in the order of their keywords. Throws InvalidInput for a list or dict
/// where there can be none. Unknown options are for the parser to refuse.
std::vector<std::string> argumentsOf(const CLI::App& app, const pybind11::dict& options);

/// Parameters of `kind`, by default but for what `values` has by name. Throws as ParameterSet::set().
pusht::ParameterSet parametersFrom(const pusht::SimulatorKind& kind, const pybind11::dict& values);

}  // namespace sim2sim::python
