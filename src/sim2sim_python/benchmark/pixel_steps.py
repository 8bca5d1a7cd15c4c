#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Control steps per second of gym-pusht's environment: states and images, one world and 64 at once,
whose images all cores draw. The action changes in every step, so that no image is drawn before.
Then how many times as fast all cores draw a batch of images as one does, in turn: median, and the
middle half."""

import statistics
import time
from typing import Any, Callable

import numpy as np
import sim2sim
from sim2sim import renderers

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


def seconds(draw: Callable[..., Any], rows: Any) -> float:
    begin = time.perf_counter()
    draw(rows, 96, 96)
    return time.perf_counter() - begin


drawing = renderers.Renderers()
alone = renderers.pictures().images
for count in (64, 640):
    rows = np.random.default_rng(0).uniform(50.0, 450.0, (count, 18))
    drawing.images(rows, 96, 96)
    assert all(renderer.is_ready(patience=30.0) for renderer in drawing.others)
    gains = [seconds(alone, rows) / seconds(drawing.images, rows) for _ in range(12_800 // count)]
    low, middle, high = statistics.quantiles(gains, n=4)
    print(f"{count:4} images at once, all cores over one: {middle:.2f} [{low:.2f}, {high:.2f}]")
drawing.end()
