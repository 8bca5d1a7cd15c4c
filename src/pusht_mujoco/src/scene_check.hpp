// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mujoco/mujoco.h>

namespace pusht {

/// Throws InvalidInput with the first field of `model` that is not what PushT expects: name, value, rule.
void checkScene(const mjModel& model);

}  // namespace pusht
