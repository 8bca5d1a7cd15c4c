// SPDX-License-Identifier: BSD-3-Clause
/// MuJoCo as a kind of simulator.
#pragma once

#include "pusht_task/simulator_kind.hpp"

namespace pusht {

/// "mujoco". Its parameters are the scene, the numerics, and the physical numbers of the task.
const SimulatorKind& mujocoKind();

}  // namespace pusht
