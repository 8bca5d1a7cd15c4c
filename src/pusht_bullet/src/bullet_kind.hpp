// SPDX-License-Identifier: BSD-3-Clause
/// Bullet as a kind of simulator.
#pragma once

#include "pusht_task/simulator_kind.hpp"

namespace pusht {

/// "bullet".
const SimulatorKind& bulletKind();

}  // namespace pusht
