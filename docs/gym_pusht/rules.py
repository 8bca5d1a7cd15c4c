#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What other rules of success say of the study of gym_pusht.md: the share of each figure that a
world keeps of gym-pusht's, for the policies that were trained there. Student's intervals over the
trainings, for these starts.

    docs/gym_pusht/rules.py SWEEP
"""

import csv
import json
import sys
from pathlib import Path
from statistics import mean, stdev
from typing import Dict, List, Tuple

FIGURES = {
    "covered_at_best_share": "0.95 covered",
    "within_20mm_20deg_share": "20 mm, 20 degrees",
    "largest_coverage_share": "coverage at its best",
}
STUDENT = 2.776  # of 4 degrees of freedom, 95 %


def means_of(row: Path) -> Dict[str, Dict[str, float]]:
    """Mean of each figure over the episodes of a row, by mode."""
    with (row / "episodes.csv").open() as file:
        rollouts = list(csv.DictReader(file))
    return {
        mode: {
            name: mean(float(r[name]) for r in rollouts if r["mode"] == mode) for name in FIGURES
        }
        for mode in ("reference_closed", "engine_closed")
    }


def kept(sweep: Path) -> Dict[Tuple[str, str, str], List[float]]:
    """Shares that are kept, one for each training: by group, engine and figure."""
    shares: Dict[Tuple[str, str, str], List[float]] = {}
    for row in sorted((sweep / "rows").iterdir()):
        metrics = json.loads((row / "metrics.json").read_text())
        group = metrics["policy"].split("-")[0]
        engine = metrics["engine_simulator"].replace("gym_pusht", "sound")
        found = means_of(row)
        for name in FIGURES:
            home = found["reference_closed"][name]
            if home > 0.0:
                key = (group, engine, name)
                shares.setdefault(key, []).append(found["engine_closed"][name] / home)
    return shares


def main() -> None:
    """Prints a line for each group, engine and figure."""
    for (group, engine, name), values in sorted(kept(Path(sys.argv[1])).items()):
        if group not in ("mlp", "chunk") or len(values) < 5:
            continue
        half = STUDENT * stdev(values) / len(values) ** 0.5
        low, middle, high = (
            100 * v for v in (mean(values) - half, mean(values), mean(values) + half)
        )
        print(f"{group:6} {engine:8} {FIGURES[name]:22} {middle:3.0f} % [{low:.0f}, {high:.0f}]")


if __name__ == "__main__":
    main()
