#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""All tables of the study under noise, of made-up results of its whole plan."""

import csv
import functools
import json
import unittest
from pathlib import Path
from typing import Any, Dict, List, Set
from unittest import mock

import numpy as np
from sim2sim_study import divergences, endings, hypotheses, noise_tables, push_hypotheses, pushes
from sim2sim_study.endings import Cell, Table
from sim2sim_study.parts import Part, parts_of, whole_plan
from sim2sim_study.tables import Row, write_table
from study_case import StudyCase

RATES = {"mujoco": 0.6, "chipmunk": 0.6, "two_mass": 0.2}  # success; elsewhere 0.4


def cells_of(part: Part) -> List[Cell]:
    return [cell for loop in part.plan["loops"] for cell, *_ in endings.cells(part, loop)]


def made_up(part: Part) -> Table:
    generator = np.random.default_rng(3)
    table: Table = {}
    for cell in cells_of(part):
        won = generator.random(part.plan["episodes"]) < RATES.get(cell.simulator, 0.4)
        table[cell] = "".join(np.where(won, "S", "t"))
    return table


def made_up_pushes(part: Part, windows: Any) -> Any:
    """Pushes of each window, policy and engine: ten from each start."""
    generator = np.random.default_rng(4)
    starts = np.repeat(np.arange(part.plan["episodes"]), 10)
    return {
        window: {
            f"/elsewhere/{policy}.ts.pt": {
                engine: {
                    "episode": starts,
                    **{name: generator.random(len(starts)) for name in pushes.FIGURES},
                    "missed": np.zeros(len(starts)),
                }
                for engine in part.plan["engines"]
            }
            for (policy,) in part.members
        }
        for window in windows
    }


def made_up_divergences(part: Part, path: Path) -> None:
    generator = np.random.default_rng(5)
    rows: List[Row] = []
    for cell in cells_of(part):
        of: Row = {"loop": cell.loop, "policy": cell.policy, "engine": cell.simulator}
        rows.append({**of, **{name: generator.random() for name in divergences.DIVERGENCES}})
    write_table(path, rows)


class Tables(StudyCase):
    def setUp(self) -> None:
        super().setUp()
        self.plan = whole_plan()
        for name in ("primary", "draws", "curves", "kinds", "pushes"):
            self.plan[name]["episodes"] = 20
        self.parts = parts_of(self.plan)
        self.work, self.tables = self.folder / "work", self.folder / "tables"
        for folder in (self.work, self.tables):
            folder.mkdir()

    def write(self) -> Dict[str, bytes]:
        """All tables, with few resamples."""
        judge = functools.partial(push_hypotheses.judge, count=20)
        with mock.patch.object(hypotheses, "RESAMPLES", 20), mock.patch.object(
            noise_tables, "judge_pushes", judge
        ):
            noise_tables.write_tables(self.parts, self.plan, self.work, self.tables)
        return {path.name: path.read_bytes() for path in self.tables.iterdir()}

    def keep(self, *names: str) -> None:
        """Puts made-up endings of parts where the tables are."""
        table: Table = {}
        for part in self.parts:
            if part.name in names:
                table.update(made_up(part))
        endings.write_endings(self.tables / "endings.csv.xz", self.plan, table)

    def keys(self, figures: Any) -> Set[str]:
        return {key for key, value in figures.items() if value}

    def test_of_all_parts(self) -> None:
        self.keep(*(part.name for part in self.parts))
        made = made_up_pushes(self.parts[-1], self.plan["pushes"]["windows"])
        pushes.write_pushes(self.work / "pushes.csv", made)
        pushes.write_sums(self.work / "pushes.csv.xz", made[5], 20)
        made_up_divergences(self.parts[-1], self.tables / "divergences.csv")
        files = self.write()
        csvs = ["curves", "divergences", "groups", "hypotheses", "hypotheses_pushes"]
        csvs += ["predictions", "pushes"]
        others = ("curves.png", "endings.csv.xz", "figures.json", "pushes.csv.xz")
        self.assertEqual(set(files), {*others, *(f"{name}.csv" for name in csvs)})
        figures = json.loads(files["figures.json"])
        self.assertEqual(figures["missing"], [])
        self.assertEqual(
            set(figures["hypotheses"]),
            {*(f"N{i}" for i in range(1, 18)), *(f"P{i}" for i in range(1, 5))},
        )
        self.assertEqual(figures["hypotheses"]["N7"]["verdict"], "holds")
        place = figures["groups"]["primary"]["tracker"]["shipped-mujoco"]["two_mass"]
        rows = list(csv.DictReader(files["groups.csv"].decode().splitlines()))
        (row,) = (
            row
            for row in rows
            if (row["part"], row["loop"]) == ("primary", "tracker")
            and (row["group"], row["simulator"]) == ("shipped-mujoco", "two_mass")
        )
        self.assertEqual(place["transfer"], float(row["transfer"]))
        ends = [float(row["transfer_low"]), float(row["transfer_high"])]
        self.assertEqual(place["transfer_interval"], ends)
        best = figures["predictions"]["small-mujoco"]["tracker"]["pair"]
        self.assertIn(" + ", best["numbers"])
        for name in ("direction_5", "divergence_angle_2s"):
            number = figures["numbers"]["small-mujoco"]["none"][name]
            self.assertLessEqual(abs(number["kendall_tau"]), 1.0)
        self.assertEqual(files, self.write(), "the tables say all that they were made of")

    def test_of_the_first_part_alone(self) -> None:
        self.keep("primary")
        files = self.write()
        self.assertEqual(
            set(files), {"endings.csv.xz", "groups.csv", "hypotheses.csv", "figures.json"}
        )
        figures = json.loads(files["figures.json"])
        parts = [name.partition("-")[0] for name in figures["missing"]]
        self.assertEqual([*dict.fromkeys(parts)], ["draws", "curves", "kinds", "pushes"])
        verdicts = {name: one["verdict"] for name, one in figures["hypotheses"].items()}
        self.assertEqual(verdicts["N12"], "not run")
        self.assertEqual(verdicts["N8"], "holds")

    def test_pushes_that_were_not_measured_are_named(self) -> None:
        self.keep("pushes")
        with mock.patch.object(noise_tables, "say") as said:
            files = self.write()
        line = "pushes.csv, pushes.csv.xz, divergences.csv: not all there; --part pushes makes them"
        said.assert_called_once_with(line)
        self.assertNotIn("predictions.csv", files)


if __name__ == "__main__":
    unittest.main()
