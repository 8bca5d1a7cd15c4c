// SPDX-License-Identifier: BSD-3-Clause
/// Scene of MuJoCo for any task.
#pragma once

#include <string>

#include "pusht_mujoco/mujoco_scene.hpp"
#include "pusht_task/task.hpp"

namespace pusht {

/// MJCF of a task's scene, in the form of scenes/pusht.xml. The body of the tee has its origin where the table acts on
/// it, because joints damp and rub there. Throws InvalidInput for a task that MuJoCo's joints cannot have.
std::string sceneOf(const Task& task);

/// Compiles MJCF that is known to be good.
MujocoModel compiledScene(const std::string& xml);

}  // namespace pusht
