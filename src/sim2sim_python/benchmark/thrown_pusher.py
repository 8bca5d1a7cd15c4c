#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""How far a tee is from the limit of short substeps, half a second after a pusher was thrown at it
and went on pushing: with contacts soft or hard, continuous or not (docs/continuous_contact.md)."""

import sys
from pathlib import Path
from typing import Any, Dict, Iterator, List, Tuple

import numpy as np
import sim2sim

from pusht_task.command import OneLineParser, run_command, say
from pusht_task.json_file import write_json

Vector = Any  # numpy.ndarray of float64
WORLDS: Dict[str, Dict[str, Any]] = {
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


def median(values: Vector) -> Tuple[float, List[float]]:
    """Median with its 95 % interval, by ranks."""
    ranked = np.sort(values)
    half = 0.98 * np.sqrt(len(ranked))
    low, high = ranked[int(len(ranked) / 2 - half)], ranked[int(len(ranked) / 2 + half)]
    return float(np.median(ranked)), [float(low), float(high)]


def distances() -> Iterator[Dict[str, Any]]:
    """For each speed, how far the tee is from its limit in each world [m]."""
    random = np.random.default_rng(1)
    worlds = {name: sim2sim.make("rigid_body", **parameters) for name, parameters in WORLDS.items()}
    limits = {
        name: sim2sim.make("rigid_body", softness=name == "soft", substep=0.0005)
        for name in ("soft", "hard")
    }
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
                away[name].append(np.hypot(*error))
        row: Dict[str, Any] = {"speed": speed, "throws": len(away["soft"])}
        for name, found in away.items():
            key = name.replace(", ", "_")
            row[f"{key}_m"], row[f"{key}_interval_m"] = median(np.array(found))
        yield row


def line(row: Dict[str, Any]) -> str:
    """A row as it is printed [mm]."""
    text = f"{row['speed']:11.2f}"
    for key in (name.replace(", ", "_") for name in WORLDS):
        low, high = row[f"{key}_interval_m"]
        text += f"{1e3 * row[f'{key}_m']:.1f} [{1e3 * low:.1f}, {1e3 * high:.1f}]".rjust(21)
    return text


def main() -> int:
    parser = OneLineParser(prog="thrown_pusher", description=__doc__)
    parser.add_argument("--out", metavar="FILE", type=Path, help="JSON file for all figures")
    options = parser.parse_args()

    def work() -> None:
        say("speed [m/s]" + "".join(f"{name:>21}" for name in WORLDS) + "   median [mm]")
        rows = []
        for row in distances():
            rows.append(row)
            say(line(row))
        if options.out:
            write_json(options.out, {"rows": rows})

    return run_command("thrown_pusher", work)


if __name__ == "__main__":
    sys.exit(main())
