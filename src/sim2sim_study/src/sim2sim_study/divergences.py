# SPDX-License-Identifier: BSD-3-Clause
"""The divergences that runs print, by policy and engine: exploratory numbers beside those of
pushes."""

import csv
import io
from pathlib import Path
from typing import Any, Dict, Sequence

import numpy as np
from pusht_task.files import read_text
from pusht_task.json_file import read_json
from sim2sim_protocol.result_files import name_of

from sim2sim_study.crossed import Numbers
from sim2sim_study.endings import ENGINE, cells
from sim2sim_study.parts import Part
from sim2sim_study.tables import Row, write_table

DIVERGENCES = {  # by the name of the number: a mean over episodes of the replay, in metrics.json
    "divergence_position": "mean_pos_divergence_m",
    "divergence_angle": "mean_ang_divergence_rad",
    "divergence_position_2s": "engine_replay_early_position_divergence_m",
    "divergence_angle_2s": "engine_replay_early_angle_divergence_rad",
}


def write_divergences(path: Path, part: Part, work: Path) -> None:
    """Writes a row for each loop, policy and engine of finished sweeps."""
    rows = []
    for loop in part.plan["loops"]:
        swept = read_json(work / part.folder(loop) / name_of("sweep"))["rows"]
        for cell, number, role in cells(part, loop):
            if role == ENGINE:
                values = {name: swept[number][key] for name, key in DIVERGENCES.items()}
                of: Row = {"loop": cell.loop, "policy": cell.policy, "engine": cell.simulator}
                rows.append({**of, **values})
    write_table(path, rows)


def read_divergences(
    path: Path, loop: str, policies: Sequence[str], engines: Sequence[str]
) -> Dict[str, Numbers]:
    """Each number by engine, the mean over policies, in one loop."""
    rows: Dict[Any, Row] = {
        (row["policy"], row["engine"]): row
        for row in csv.DictReader(io.StringIO(read_text(path)))
        if row["loop"] == loop
    }

    def mean(name: str, engine: str) -> Any:
        return np.mean([float(rows[policy, engine][name]) for policy in policies])

    return {name: np.array([mean(name, e) for e in engines]) for name in DIVERGENCES}
