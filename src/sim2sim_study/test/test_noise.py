#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""script/study noise: the least of it, what its parts need, and which parts its tables have."""

import csv
import json
import lzma
import subprocess
import sys
import unittest
from typing import Any, Dict, List, Set
from unittest import mock

from pusht_task.error import Error
from pusht_task.json_file import read_json
from pusht_testing.long_tests import long_form
from sim2sim_study import endings, noise, steps
from sim2sim_study.endings import Cell
from sim2sim_study.parts import NAMES, Part, parts_of, whole_plan, with_trainings
from study_case import StudyCase

DEADLINE = 600.0  # s
PLAN = {"first_episode": 390_000}
SWEEPS = [  # each with its part
    *(("primary-none", "primary"), ("primary-tracker", "primary")),
    *(("draws-none", "draws"), ("draws-tracker", "draws")),
    *(
        (f"curves-observation_noise_position={d}", "curves")
        for d in (0.001, 0.002, 0.005, 0.01, 0.02)
    ),
    *((f"curves-action_noise={v}", "curves") for v in (0.1, 0.2)),
    *(("kinds-none", "kinds"), ("kinds-tracker", "kinds")),
    *(("pushes-none", "pushes"), ("pushes-tracker", "pushes")),
    ("pushes-observation_noise_position=0.01", "pushes"),
]


class Study(StudyCase):
    def run_study(self, *options: str) -> str:
        """What a study in folders of its own prints."""
        folders = ("--work", str(self.folder / "work"), "--tables", str(self.folder / "tables"))
        command = [sys.executable, "-m", "sim2sim_study", "noise", *options, *folders]
        done = subprocess.run(command, timeout=DEADLINE, stdout=subprocess.PIPE, check=True)
        return done.stdout.decode()

    def files(self) -> Set[str]:
        return {path.name for path in (self.folder / "tables").iterdir()}

    @long_form
    def test_the_least_of_it_from_nothing(self) -> None:
        self.run_study("--smoke")
        with lzma.open(self.folder / "tables" / "endings.csv.xz", "rt") as file:
            rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
        self.assertEqual({row["part"] for row in rows}, set(NAMES))
        self.assertEqual({len(row["ends"]) for row in rows}, {2})
        self.assertLessEqual({letter for row in rows for letter in row["ends"]}, set("Stml"))
        of_small = [
            row["policy"]
            for row in rows
            if (row["part"], row["loop"], row["simulator"]) == ("primary", "tracker", "two_mass")
            and row["group"] == "small-mujoco"
        ]
        self.assertEqual(of_small, ["small-mujoco-100"])
        tables = {"groups.csv", "figures.json", "predictions.csv", "pushes.csv", "pushes.csv.xz"}
        self.assertEqual(self.files(), {"endings.csv.xz", "divergences.csv", *tables})
        row = read_json(self.folder / "work" / "pushes-tracker" / "sweep.json")["rows"][0]
        printed = list(csv.DictReader((self.folder / "tables" / "divergences.csv").open()))
        (found,) = (
            float(one["divergence_angle"])
            for one in printed
            if one["loop"] == "tracker"
            and f"{one['policy']}.ts.pt" == row["policy"]
            and one["engine"].partition(":")[0] == row["engine_simulator"]
        )
        self.assertEqual(found, row["mean_ang_divergence_rad"])

    def test_tables_of_nothing_name_all_that_is_missing(self) -> None:
        said = self.run_study("--tables-only").splitlines()
        begins = [f"{name}: MISSING; --part {part} runs it" for name, part in SWEEPS]
        self.assertEqual(said, begins)
        self.assertEqual(self.files(), {"endings.csv.xz", "hypotheses.csv", "figures.json"})
        figures = json.loads((self.folder / "tables" / "figures.json").read_text())
        self.assertEqual(figures["missing"], [name for name, _ in SWEEPS])
        self.assertEqual({one["verdict"] for one in figures["hypotheses"].values()}, {"not run"})

    def test_the_plan_trains_what_it_tests(self) -> None:
        plan = whole_plan()
        for group in plan["groups"].values():
            self.assertIn(group["demonstrations"], plan["demonstrations"])
            self.assertIn(group["recipe"], plan["recipes"])
        tested = [entry["group"] for part in parts_of(plan) for entry in part.policies]
        self.assertLessEqual(set(plan["groups"]), set(tested))
        self.assertEqual(plan["recipes"]["epochs_600-width_256"]["epochs"], 600)


class Parts(StudyCase):
    def needed(self, *names: str) -> Dict[str, range]:
        """Training seeds by group that parts need."""
        plan = whole_plan()
        needed = with_trainings(plan, [part for part in parts_of(plan) if part.name in names])
        demonstrations = {group["demonstrations"] for group in needed["groups"].values()}
        self.assertEqual(set(needed["demonstrations"]), demonstrations)
        return {
            name: range(group["first_seed"], group["first_seed"] + group["seeds"])
            for name, group in needed["groups"].items()
        }

    def test_a_part_needs_its_own_trainings(self) -> None:
        both = ("small-mujoco", "shipped-mujoco")
        self.assertEqual(self.needed("curves"), dict.fromkeys(both, range(100, 105)))
        self.assertEqual(self.needed("pushes"), dict.fromkeys(both, range(104, 108)))
        self.assertEqual(self.needed("curves", "pushes"), dict.fromkeys(both, range(100, 108)))
        self.assertEqual(self.needed("kinds"), {})
        draws = self.needed("draws")
        self.assertEqual(len(draws), 16)
        self.assertEqual(draws["shipped-draw_5"], range(150, 151))
        self.assertEqual(draws["epochs_60-width_512"], range(100, 105))

    def test_all_parts_need_all_trainings(self) -> None:
        plan = whole_plan()
        groups = with_trainings(plan, parts_of(plan))["groups"]
        self.assertEqual(groups, {n: {"first_seed": 100, **g} for n, g in plan["groups"].items()})
        self.assertEqual(groups["shipped-mujoco"]["also_after"], [10, 30, 60, 180])

    def test_a_part_runs_alone(self) -> None:
        plan = whole_plan()
        (curves,) = (part for part in parts_of(plan) if part.name == "curves")
        with mock.patch.object(steps, "ros") as ros:
            noise.run_parts([curves], plan, self.folder)
        ran = [[str(word) for word in call.args[2:]] for call in ros.call_args_list]
        trained = [words[words.index("--out") + 1] for words in ran if words[0] == "train"]
        self.assertEqual(trained, ["small-mujoco.ts.pt", "shipped-mujoco.ts.pt"])
        swept = [words[1] for words in ran if words[0] == "sweep"]
        self.assertEqual(len(swept), 7)
        self.assertEqual(swept[3], "curves-observation_noise_position=0.01.yaml")
        self.assertEqual([words[0] for words in ran].count("demonstrate"), 1)


SMALL = Part(
    "primary",
    [{"files": "small-*.ts.pt", "group": "small", "reference": "mujoco"}],
    [["small-1", "small-2"]],
    {
        "loops": ["none", {"action_noise": 0.1}],
        "engines": ["two_mass", "mujoco", "box2d:preset=i"],
        "episodes": 2,
    },
)
KINDS = Part(
    "kinds",
    [{"reference": "mujoco", "files": "expert", "group": "expert"}],
    [["expert"]],
    {"loops": ["none"], "engines": ["chipmunk"], "episodes": 3},
)  # fmt: skip
ENDS = {"S": "success", "t": "stuck", "m": "moving", "l": "lost"}


class Gathered(StudyCase):
    """The table of a study of two parts, of made-up sweeps."""

    def setUp(self) -> None:
        super().setUp()
        self.path = self.folder / "endings.csv.xz"

    def sweep(self, folder: str, rows: List[Any], exit_code: int = 0) -> None:
        """A sweep whose rows have policy, engine, and the letters of both roles."""
        path = self.folder / folder
        listed = []
        for number, (policy, engine, home, there) in enumerate(rows):
            listed.append({"policy": policy, "engine_simulator": engine, "episodes": len(home)})
            lines = ["mode,ending"]
            for pair in zip(home, there):
                for mode, letter in zip(("reference_closed", "engine_closed"), pair):
                    lines += [f"{mode},{ENDS[letter]}", "engine_replay,moving"]
            row = path / "rows" / f"{number:03}"
            row.mkdir(parents=True)
            (row / "episodes.csv").write_text("\n".join(lines) + "\n")
        (path / "sweep.json").write_text(json.dumps({"rows": listed}))
        (path / "status.json").write_text(json.dumps({"exit_code": exit_code}))

    def sweep_small(self, last: int = 0) -> None:
        for folder, code in (("primary-none", 0), ("primary-action_noise=0.1", last)):
            rows = [
                ("small-1.ts.pt", "two_mass", "St", "mm"),
                ("small-1.ts.pt", "box2d", "St", "tl"),
                ("small-2.ts.pt", "two_mass", "SS", "Sm"),
                ("small-2.ts.pt", "box2d", "SS", "tS"),
            ]
            self.sweep(folder, rows, code)

    def gather(self, *parts: Part) -> endings.Table:
        table = endings.gather(parts, PLAN, self.folder, self.path)
        endings.write_endings(self.path, PLAN, table)
        return table

    def test_rows_are_those_of_the_sweeps(self) -> None:
        self.sweep_small()
        table = self.gather(SMALL, KINDS)
        of_none = {cell[1:]: ends for cell, ends in table.items() if cell.loop == "none"}
        self.assertEqual(
            of_none,
            {
                ("small", "small-1", "none", "mujoco"): "St",
                ("small", "small-1", "none", "two_mass"): "mm",
                ("small", "small-1", "none", "box2d:preset=i"): "tl",
                ("small", "small-2", "none", "mujoco"): "SS",
                ("small", "small-2", "none", "two_mass"): "Sm",
                ("small", "small-2", "none", "box2d:preset=i"): "tS",
            },
        )
        self.assertEqual(len(table), 12)
        self.assertEqual(endings.read_endings(self.path, PLAN), table)

    def test_parts_that_were_run_elsewhere_are_kept(self) -> None:
        self.sweep_small()
        self.gather(SMALL, KINDS)
        here = self.folder / "here"  # another machine, with the tables alone
        here.mkdir()
        with mock.patch.object(self, "folder", here):
            self.sweep("kinds-none", [("expert", "chipmunk", "SSt", "Sml")])
            table = self.gather(SMALL, KINDS)
        self.assertEqual(len(table), 14)
        self.assertEqual(table[Cell("primary", "small", "small-1", "none", "mujoco")], "St")
        self.assertEqual(table[Cell("kinds", "expert", "expert", "none", "chipmunk")], "Sml")
        self.assertEqual([cell.part for cell in table], 12 * ["primary"] + 2 * ["kinds"])

    def test_a_sweep_that_is_not_finished_is_missing(self) -> None:
        self.sweep_small(last=4)
        self.sweep("kinds-none", [("expert", "chipmunk", "SSt", "Sml")])
        with mock.patch.object(endings, "say") as said:
            table = self.gather(SMALL, KINDS)
        self.assertEqual(
            {(cell.part, cell.loop) for cell in table}, {("primary", "none"), ("kinds", "none")}
        )
        lines = [call.args[0] for call in said.call_args_list]
        self.assertEqual(
            lines,
            [
                f"primary-none: from {self.folder}",
                "primary-action_noise=0.1: MISSING; --part primary runs it",
                f"kinds-none: from {self.folder}",
            ],
        )

    def test_tables_of_another_study_are_refused(self) -> None:
        self.sweep_small()
        table = self.gather(SMALL)
        endings.write_endings(self.path, {"first_episode": 0}, table)
        with self.assertRaisesRegex(Error, "endings.csv.xz: must begin with .*400000"):
            self.gather(SMALL, KINDS)
        shorter = {cell: ends[:1] for cell, ends in table.items()}
        fewer = dict(list(table.items())[1:])
        for wrong in (shorter, fewer):
            endings.write_endings(self.path, PLAN, wrong)
            with mock.patch.object(self, "folder", self.folder / "nowhere"):
                with self.assertRaisesRegex(Error, "its rows of primary-none must be"):
                    self.gather(SMALL, KINDS)

    def test_a_row_of_another_engine_is_refused(self) -> None:
        self.sweep("kinds-none", [("expert", "two_mass", "SSt", "Sml")])
        with self.assertRaisesRegex(Error, "row of a sweep is .'expert', 'two_mass', 3."):
            self.gather(KINDS)


if __name__ == "__main__":
    unittest.main()
