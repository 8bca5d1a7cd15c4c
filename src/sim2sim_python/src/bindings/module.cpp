// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/pybind11.h>

#include "bindings.hpp"
#include "errors.hpp"
#include "pusht_task/constants.hpp"
#include "served_run.hpp"

PYBIND11_MODULE(_sim2sim, module) {
  module.doc() = "What the package sim2sim has in C++; _sim2sim.pyi has its types.";
  sim2sim::python::translateErrors();
  sim2sim::python::endRunsAtExit();
  sim2sim::python::bindCommands(module);
  sim2sim::python::bindAuditPolicy(module);
  sim2sim::python::bindCompare(module);
  sim2sim::python::bindLoadedPolicy(module);
  sim2sim::python::bindPixelWorlds(module);
  sim2sim::python::bindStatistics(module);
  sim2sim::python::bindWorldBatch(module);
  module.attr("HORIZON") = pusht::kHorizon;
  module.attr("FIRST_SPAWN_SEED") = pusht::kFirstSpawnSeed;
}
