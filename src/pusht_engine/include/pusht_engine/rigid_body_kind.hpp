// SPDX-License-Identifier: BSD-3-Clause
/// The rigid-body engine as a kind of simulator.
#pragma once

#include "pusht_task/simulator_kind.hpp"

namespace pusht {

/// Kind "rigid_body". Its parameters are the switches, `preset`, which sets those that are not set by name (`faithful`:
/// all on, the default; `shaped`: only the tee's shape and inertia are on; `simple`: all off), and the length of a
/// substep.
const SimulatorKind& rigidBodyKind();

}  // namespace pusht
