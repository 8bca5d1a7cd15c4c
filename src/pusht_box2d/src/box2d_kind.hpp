// SPDX-License-Identifier: BSD-3-Clause
/// Box2D as a kind of simulator.
#pragma once

#include "pusht_task/simulator_kind.hpp"

namespace pusht {

/// "box2d".
const SimulatorKind& box2dKind();

}  // namespace pusht
