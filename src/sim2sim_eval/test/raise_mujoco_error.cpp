// SPDX-License-Identifier: BSD-3-Clause
// Preloaded in a test: MuJoCo raises an error in the middle of a run.
#include <mujoco/mujoco.h>

extern "C" void mj_step(const mjModel* model, mjData* data) {
  static int steps = 0;  // a few of them are taken while the scene is compiled
  if (++steps > 100) {
    mju_error("raised on purpose");
  }
  mj_step1(model, data);
  mj_step2(model, data);
}
