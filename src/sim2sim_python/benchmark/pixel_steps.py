#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Control steps per second of gym-pusht's environment: states and images, one world and 64 at once,
whose images all cores draw. The action changes in every step, so that no image is drawn before."""

import time
from typing import Any

import numpy as np
import sim2sim

STEPS = {"state": 30_000, "pixels": 4_000}


def rate(env: Any, worlds: int, steps: int) -> float:
    """Control steps per second of all worlds together."""
    env.reset(seed=1)
    begin = time.perf_counter()
    for step in range(steps):
        target = 256.0 + 100.0 * np.sin(0.37 * step)
        env.step(np.full((worlds, 2) if worlds > 1 else 2, target))
    return worlds * steps / (time.perf_counter() - begin)


for obs_type, count in STEPS.items():
    one = rate(sim2sim.make("gym_pusht", obs_type=obs_type, horizon=10**6), 1, count)
    many = sim2sim.make_vec("gym_pusht", 64, obs_type=obs_type, horizon=10**6)
    print(f"{obs_type:7} {one:8.0f}   64 worlds {rate(many, 64, count // 10):8.0f}")
