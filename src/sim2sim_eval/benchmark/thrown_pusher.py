#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""How far a tee is from the limit of short substeps, half a second after a pusher was thrown at it
and went on pushing: with contacts soft or hard, continuous or not (docs/continuous_contact.md)."""

from typing import Any, Dict, List

import numpy as np
import sim2sim

Vector = Any  # numpy.ndarray of float64
WORLDS: Dict[str, Dict[str, bool]] = {
    "soft": {},
    "soft, continuous": {"continuous": True},
    "hard": {"softness": False},
    "hard, continuous": {"softness": False, "continuous": True},
}
SPEEDS = (0.25, 0.5, 1.0, 2.0, 3.0, 5.0, 8.0)  # [m/s]
THROWS = 400
AT = {name: i for i, name in enumerate(sim2sim.STATE_FIELDS)}


def gap(place: Vector, yaw: float) -> float:
    """Distance [m] of the pusher's surface from a tee at the origin."""
    x = np.cos(yaw) * place[0] + np.sin(yaw) * place[1]
    y = np.cos(yaw) * place[1] - np.sin(yaw) * place[0]
    bar = np.hypot(max(0.0, abs(x) - 0.06), max(0.0, abs(y) - 0.015))
    stem = np.hypot(max(0.0, abs(x) - 0.015), max(0.0, abs(y + 0.06) - 0.045))
    return float(min(bar, stem) - 0.015)


def tee_after(world: Any, start: Vector, ahead: Vector) -> Vector:
    """Place of the tee [m] half a second later."""
    world.reset(options={"state": start})
    for _ in range(5):
        info = world.step(ahead)[4]
    return np.array(info["state"])[[AT["tee_x"], AT["tee_y"]]]


def median(values: Vector) -> str:
    """Median with its 95 % interval, by ranks."""
    ranked = np.sort(values)
    half = 0.98 * np.sqrt(len(ranked))
    low, high = ranked[int(len(ranked) / 2 - half)], ranked[int(len(ranked) / 2 + half)]
    return f"{np.median(ranked):.1f} [{low:.1f}, {high:.1f}]"


random = np.random.default_rng(1)
worlds = {name: sim2sim.make("rigid_body", **parameters) for name, parameters in WORLDS.items()}
limits = {
    name: sim2sim.make("rigid_body", softness=name == "soft", substep=0.0005)
    for name in ("soft", "hard")
}
print("speed [m/s]" + "".join(f"{name:>21}" for name in WORLDS) + "   median [mm]")
for speed in SPEEDS:
    away: Dict[str, List[float]] = {name: [] for name in WORLDS}
    for _ in range(THROWS):
        yaw, way = random.uniform(-np.pi, np.pi, 2)
        ahead = np.array([np.cos(way), np.sin(way)])
        aim = random.uniform(-0.06, 0.06) * np.array([np.cos(yaw), np.sin(yaw)])
        place = aim - random.uniform(0.03, 0.08) * ahead
        if gap(place, yaw) < 0.0:
            continue
        start = np.zeros(len(AT))
        start[AT["tee_yaw"]] = yaw
        start[[AT["pusher_x"], AT["pusher_y"]]] = place
        start[[AT["pusher_vx"], AT["pusher_vy"]]] = speed * ahead
        exact = {name: tee_after(world, start, ahead) for name, world in limits.items()}
        for name, world in worlds.items():
            error = tee_after(world, start, ahead) - exact[name.split(",")[0]]
            away[name].append(1e3 * np.hypot(*error))
    print(f"{speed:11.2f}" + "".join(f"{median(np.array(found)):>21}" for found in away.values()))
