// SPDX-License-Identifier: BSD-3-Clause
/// The two-mass engine as a kind of simulator.
#pragma once

#include "pusht_task/simulator_kind.hpp"

namespace pusht {

/// "two_mass". Its parameters are the knobs.
const SimulatorKind& twoMassKind();

}  // namespace pusht
