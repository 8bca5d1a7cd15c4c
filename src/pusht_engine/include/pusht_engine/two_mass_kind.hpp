// SPDX-License-Identifier: BSD-3-Clause
/// The two-mass engine as a kind of simulator.
#pragma once

#include "pusht_task/simulator_kind.hpp"

namespace pusht {

/// Kind "two_mass". Its parameters are two_mass::kParameters.
const SimulatorKind& twoMassKind();

}  // namespace pusht
