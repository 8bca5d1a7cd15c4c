// SPDX-License-Identifier: BSD-3-Clause
/// Chipmunk as a kind of simulator.
#pragma once

#include "pusht_task/simulator_kind.hpp"

namespace pusht {

/// "chipmunk".
const SimulatorKind& chipmunkKind();

}  // namespace pusht
