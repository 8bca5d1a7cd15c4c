#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The leading table of the study under noise, from endings.csv.xz, with NumPy and SciPy alone: a
second implementation of what groups.csv has, which shares no code with the suite.

For each loop, group of policies and engine: success in the group's reference, which is its first
simulator in the file, success in the engine, and the engine's less the reference's, over policies
and starts, with a 95 % interval (docs/statistics.md, policies and starts).

    python3 recompute.py [endings.csv.xz]
"""

import csv
import lzma
import sys
from pathlib import Path
from typing import Any, Dict, List, Tuple

import numpy as np
from scipy import stats  # type: ignore[import]

FEWEST = 5  # policies for an interval
HERE = Path(__file__).resolve().parent


def successes(path: Path) -> Dict[Tuple[str, str, str], Any]:
    """Success [policy, start] by loop, group and simulator, the policies in the file's order."""
    rows: Dict[Tuple[str, str, str], List[List[bool]]] = {}
    with lzma.open(path, "rt") as file:
        for row in csv.DictReader(line for line in file if not line.startswith("#")):
            key = row["loop"], f"{row['part']} {row['group']}", row["simulator"]
            rows.setdefault(key, []).append([letter == "S" for letter in row["ends"]])
    return {key: np.array(values, dtype=float) for key, values in rows.items()}


def crossed_error(y: Any) -> Tuple[float, float]:
    """Standard error and degrees of freedom of the mean of [policy, start]; both are samples
    (Satterthwaite)."""
    rows, columns = y.shape
    mean, of_rows, of_columns = y.mean(), y.mean(axis=1), y.mean(axis=0)
    by_row = columns * np.sum((of_rows - mean) ** 2) / (rows - 1)
    by_column = rows * np.sum((of_columns - mean) ** 2) / (columns - 1)
    rest = np.sum((y - of_rows[:, None] - of_columns + mean) ** 2) / ((rows - 1) * (columns - 1))
    parts = [(by_row, rows - 1.0)]
    if by_column > rest:
        parts += [(by_column, columns - 1.0), (-rest, (rows - 1.0) * (columns - 1.0))]
    total = sum(part for part, _ in parts)
    spread = sum(part**2 / freedom for part, freedom in parts)
    freedom = max(rows - 1.0, total**2 / spread) if spread > 0.0 else rows - 1.0
    return float(np.sqrt(max(total, 0.0) / (rows * columns))), freedom


def crossed_mean(y: Any) -> Tuple[float, float, float]:
    """Mean of [policy, start] with Student's interval."""
    error, freedom = crossed_error(y)
    half = stats.t.ppf(0.975, freedom) * error
    return y.mean(), y.mean() - half, y.mean() + half


def main() -> None:
    tables = successes(Path(sys.argv[1]) if sys.argv[1:] else HERE / "endings.csv.xz")
    references: Dict[Tuple[str, str], str] = {}
    for loop, group, simulator in tables:
        references.setdefault((loop, group), simulator)
    print("loop,group,engine,policies,reference,reference_success,success,difference,low,high")
    for (loop, group, simulator), y in tables.items():
        reference = references[loop, group]
        if simulator == reference or len(y) < FEWEST:
            continue
        home = tables[loop, group, reference]
        difference, low, high = crossed_mean(y - home)
        names = f'{loop},{group},"{simulator}",{len(y)},"{reference}"'
        ends = f"{low:+.3f},{high:+.3f}" if high > low else ","  # none where nothing varies
        print(f"{names},{home.mean():.3f},{y.mean():.3f},{difference:+.3f},{ends}")


if __name__ == "__main__":
    main()
