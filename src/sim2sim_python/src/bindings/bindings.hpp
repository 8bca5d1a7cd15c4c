// SPDX-License-Identifier: BSD-3-Clause
/// Parts of the module.
#pragma once

#include <pybind11/pybind11.h>

#include <tuple>

#include "pusht_task/types.hpp"

namespace sim2sim::python {

/// Lengths of arrays: of an observation, of an action.
constexpr pybind11::ssize_t kNumbers = std::tuple_size_v<pusht::Observation>;
constexpr pybind11::ssize_t kAxes = std::tuple_size_v<pusht::Action>;

/// Adds run(), which runs a command.
void bindCommands(pybind11::module_& module);

/// Adds audit_policy().
void bindAuditPolicy(pybind11::module_& module);

/// Adds compare() and load().
void bindCompare(pybind11::module_& module);

/// Adds LoadedPolicy and PolicyMemory.
void bindLoadedPolicy(pybind11::module_& module);

/// Adds PixelWorlds, and gym-pusht's draws.
void bindPixelWorlds(pybind11::module_& module);

/// Adds the functions of the statistics.
void bindStatistics(pybind11::module_& module);

/// Adds WorldBatch, and what kinds of simulators there are.
void bindWorldBatch(pybind11::module_& module);

}  // namespace sim2sim::python
