// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mujoco/mujoco.h>

#include "pusht_mujoco/mujoco_scene.hpp"

namespace pusht {

/// Throws InvalidInput with the first field of `model` that differs from the task's scene, bit for bit: name, value,
/// rule. Only how a scene looks is free: what does not collide, lights, cameras, colors.
void checkScene(const mjModel& model, const mjModel& of_task);

}  // namespace pusht
