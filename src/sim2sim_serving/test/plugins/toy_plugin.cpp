// SPDX-License-Identifier: BSD-3-Clause
// A library of kinds: one that is right, and two that a loader must refuse.
#include "pusht_task/simulator_plugin.hpp"
#include "pusht_testing/toy_world.hpp"

namespace {

const pusht::SimulatorKind& toy() {
  static const pusht::SimulatorKind kind = pusht::toyKind();
  return kind;
}

const pusht::SimulatorKind& neverCalled() { std::abort(); }

}  // namespace

PUSHT_EXPORT_SIMULATOR_KIND(toy, toy);
PUSHT_EXPORT_SIMULATOR_KIND(other_name, toy);

// NOLINTBEGIN(readability-identifier-naming): the loader looks for this name
extern "C" const pusht::SimulatorPlugin pusht_simulator_stale;
const pusht::SimulatorPlugin pusht_simulator_stale = {"0.0.1 0123456789ab", neverCalled};
// NOLINTEND(readability-identifier-naming)
