// SPDX-License-Identifier: BSD-3-Clause
/// Simulator whose worlds are objects of Python.
#pragma once

#include <pybind11/pybind11.h>

#include "desk.hpp"
#include "sim2sim_eval/batch/simulators.hpp"

namespace sim2sim::python {

/// Kind of the simulator that `worlds` describes, a Worlds of sim2sim.simulator. Its worlds ask at the desk, which must
/// outlive them. Needs the GIL, as the end of the kind and of its models does. Throws InvalidInput for a start
/// tolerance that is not allowed.
ForeignKind kindOf(const pybind11::object& worlds, Desk& desk);

}  // namespace sim2sim::python
