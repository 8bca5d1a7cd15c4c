// SPDX-License-Identifier: BSD-3-Clause
/// gym-pusht's world as a kind of simulator.
#pragma once

#include "pusht_task/simulator_kind.hpp"

namespace pusht {

/// "gym_pusht".
const SimulatorKind& gymPushtKind();

}  // namespace pusht
