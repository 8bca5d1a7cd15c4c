// SPDX-License-Identifier: BSD-3-Clause
/// How a library offers a kind of simulator to programs that were built without it.
#pragma once

#include "pusht_task/simulator_interface.hpp"
#include "pusht_task/simulator_kind.hpp"

namespace pusht {

/// A kind in a library, as the symbol "pusht_simulator_NAME". A loader compares `interface` with its own
/// kSimulatorInterface before it calls `kind`, because other headers may have other members. So these two stay.
struct SimulatorPlugin {
  const char* interface;
  const SimulatorKind& (*kind)();
};

constexpr const char* kSimulatorPluginSymbol = "pusht_simulator_";  ///< the name of the kind follows

}  // namespace pusht

/// Exports the kind that FUNCTION returns. NAME is the kind's, without quotation marks; plugin_description.xml names it
/// too. The macro stands in one source of the library, outside of namespaces.
#define PUSHT_EXPORT_SIMULATOR_KIND(NAME, FUNCTION)               \
  extern "C" const pusht::SimulatorPlugin pusht_simulator_##NAME; \
  const pusht::SimulatorPlugin pusht_simulator_##NAME = {pusht::kSimulatorInterface, FUNCTION}
