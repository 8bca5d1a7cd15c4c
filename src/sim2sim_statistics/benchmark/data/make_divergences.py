#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes divergences.inc: mean divergences of the same episodes in several runs, for `coverage`.

    compare --episodes 2000 --engine rigid_body --out faithful
    compare --episodes 2000 --no-floor --engine rigid_body --set narrow_phase=false --out nearest
    compare --episodes 2000 --no-floor --engine chipmunk --out chipmunk
    compare --episodes 2000 --no-floor --out two_mass
    make_divergences.py faithful nearest chipmunk two_mass > divergences.inc
"""

import csv
import sys
from pathlib import Path
from typing import Dict, List

EPISODES = 2000
DIGITS = 3  # significant ones
SMALLEST = 3  # decimals [um, urad]
COMPONENTS = ("position_divergence_m", "angle_divergence_rad")

Rollouts = Dict[int, Dict[str, str]]


def rollouts(folder: str, mode: str) -> Rollouts:
    """The lines of episodes.csv of that mode, by episode."""
    with (Path(folder) / "episodes.csv").open(newline="") as file:
        return {int(line["episode"]): line for line in csv.DictReader(file) if line["mode"] == mode}


def text(value: str) -> str:
    """In millionths, short: "81500", "3.1", ".012"."""
    micro = float(f"{float(value) * 1e6:.{DIGITS}g}")
    short = f"{micro:.{SMALLEST}f}".rstrip("0").rstrip(".")
    return short[1:] if short.startswith("0.") else short


def main(faithful: str, *engines: str) -> None:
    """Null model, faithful engine, floor, then the other engines: positions, then angles."""
    replay, floor = rollouts(faithful, "engine_replay"), rollouts(faithful, "floor_1e-6")
    others = [rollouts(engine, "engine_replay") for engine in engines]
    for episode in range(EPISODES):
        cells: List[str] = []
        for component in COMPONENTS:
            cells.append(replay[episode][f"null_{component}"])
            cells += [run[episode][f"mean_{component}"] for run in (replay, floor, *others)]
        print("Episode{" + ",".join(text(cell) for cell in cells) + "},")


if __name__ == "__main__":
    main(*sys.argv[1:])
