// SPDX-License-Identifier: BSD-3-Clause
/// MuJoCo's modeling as parameters: numerics, and the physical numbers of the scene. Each sets fields of a compiled
/// model; meanings are those of MuJoCo's XML reference.
#pragma once

#include <mujoco/mujoco.h>

#include <vector>

#include "pusht_task/parameters.hpp"

namespace pusht {

/// Descriptors of all parameters of the modeling; the defaults are the shipped scene's.
const std::vector<ParameterDescriptor>& modelingParameters();

/// Whether a parameter of the modeling differs from its default. `parameters` has all of modelingParameters().
bool changesModel(const ParameterSet& parameters);

/// Sets the fields of `model`, which is the shipped scene's physics, whose parameters differ from their defaults.
/// Throws std::bad_alloc if MuJoCo has no memory.
void applyModeling(const ParameterSet& parameters, mjModel& model);

}  // namespace pusht
