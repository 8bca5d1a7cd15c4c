// SPDX-License-Identifier: BSD-3-Clause
#include "errors.hpp"

#include <pybind11/pybind11.h>

#include <exception>
#include <stdexcept>
#include <system_error>

#include "pusht_task/error.hpp"

namespace sim2sim::python {
namespace {

namespace py = pybind11;

/// Name in sim2sim.errors.
const char* nameOf(const pusht::Error& error) {
  if (dynamic_cast<const pusht::SimulationFault*>(&error) != nullptr) {
    return "SimulationFault";
  }
  switch (error.exitCode()) {
    case pusht::ExitCode::kInvalidInput:
      return "InvalidInput";
    case pusht::ExitCode::kBadDependency:
      return "BadDependency";
    case pusht::ExitCode::kRuntimeFault:
      return "RuntimeFault";
    case pusht::ExitCode::kContractError:
      return "ContractError";
    case pusht::ExitCode::kNotMet:
      return "RequirementNotMet";
    case pusht::ExitCode::kUndecided:
      return "RequirementUndecided";
    case pusht::ExitCode::kOk:
    case pusht::ExitCode::kInternalError:
      break;
  }
  return "InternalError";
}

void raise(const pusht::Error& error) {
  const py::object type = py::module_::import("sim2sim.errors").attr(nameOf(error));
  PyErr_SetString(type.ptr(), error.what());
}

}  // namespace

void translateErrors() {
  py::register_exception_translator([](std::exception_ptr failure) {
    try {
      std::rethrow_exception(failure);
    } catch (const pusht::Error& error) {
      raise(error);
    } catch (const std::domain_error& error) {
      raise(pusht::InvalidInput(error.what()));
    } catch (const std::system_error& error) {  // threads or files that the system does not give
      raise(pusht::RuntimeFault(error.what()));
    }
  });
}

}  // namespace sim2sim::python
