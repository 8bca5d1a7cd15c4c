// SPDX-License-Identifier: BSD-3-Clause
/// Errors of the suite as exceptions of Python.
#pragma once

namespace sim2sim::python {

/// Turns every pusht::Error that leaves a function of the module into the exception of its kind (sim2sim.errors), with
/// the same message.
void translateErrors();

}  // namespace sim2sim::python
