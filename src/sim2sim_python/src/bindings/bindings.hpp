// SPDX-License-Identifier: BSD-3-Clause
/// Parts of the module.
#pragma once

#include <pybind11/pybind11.h>

namespace sim2sim::python {

/// Adds compare().
void bindCompare(pybind11::module_& module);

/// Adds LoadedPolicy and PolicyMemory.
void bindLoadedPolicy(pybind11::module_& module);

/// Adds WorldBatch, and what kinds of simulators there are.
void bindWorldBatch(pybind11::module_& module);

}  // namespace sim2sim::python
