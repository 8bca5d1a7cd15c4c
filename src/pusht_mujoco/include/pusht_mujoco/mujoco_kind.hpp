// SPDX-License-Identifier: BSD-3-Clause
/// MuJoCo as a kind of simulator.
#pragma once

#include "pusht_task/simulator_kind.hpp"

namespace pusht {

/// "mujoco". Its parameter is the scene.
const SimulatorKind& mujocoKind();

}  // namespace pusht
