#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""script/study noise: the least of it, its recomputation, its hypotheses."""

import csv
import io
import lzma
import subprocess
import sys
import unittest
from pathlib import Path
from typing import Any

import numpy as np
from pusht_task.testing.long_tests import long_form
from scipy import stats  # type: ignore[import]
from sim2sim_study import hypotheses, noise
from study_case import StudyCase

ROOT = Path(__file__).resolve().parents[3]
STUDY = ROOT / "docs" / "study" / "noise"
sys.path.insert(0, str(STUDY))

import recompute  # noqa: E402

DEADLINE = 600.0  # s


class Study(StudyCase):
    @long_form
    def test_the_least_of_it_from_nothing(self) -> None:
        folders = ("--work", str(self.folder / "work"), "--tables", str(self.folder / "tables"))
        command = [sys.executable, "-m", "sim2sim_study", "noise", "--smoke", *folders]
        subprocess.run(command, check=True, timeout=DEADLINE, stdout=subprocess.DEVNULL)
        with lzma.open(self.folder / "tables" / "endings.csv.xz", "rt") as file:
            rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
        self.assertEqual(
            {row["part"] for row in rows}, {"primary", "draws", "curves", "kinds", "pushes"}
        )
        self.assertEqual({len(row["ends"]) for row in rows}, {2})
        self.assertLessEqual({letter for row in rows for letter in row["ends"]}, set("Stml"))
        shapes = {key: y.shape for key, y in recompute.successes(file_in(self.folder)).items()}
        self.assertEqual(shapes["tracker", "primary small-mujoco", "two_mass"], (1, 2))

    def test_the_plan_trains_what_it_tests(self) -> None:
        plan = noise.whole_plan()
        for group in plan["groups"].values():
            self.assertIn(group["demonstrations"], plan["demonstrations"])
            self.assertIn(group["recipe"], plan["recipes"])
        tested = [entry["group"] for part in noise.parts_of(plan) for entry in part.policies]
        self.assertLessEqual(set(plan["groups"]), set(tested))
        self.assertEqual(plan["recipes"]["epochs_600-width_256"]["epochs"], 600)


def file_in(folder: Path) -> Path:
    return folder / "tables" / "endings.csv.xz"


class Recomputation(StudyCase):
    def test_intervals_are_students_where_starts_do_not_differ(self) -> None:
        rates = np.array([0.1, 0.3, 0.35, 0.4, 0.6])
        mean, low, high = recompute.crossed_mean(np.repeat(rates[:, None], 40, axis=1))
        half = stats.t.ppf(0.975, 4) * rates.std(ddof=1) / np.sqrt(5)
        self.assertAlmostEqual(mean, rates.mean())
        self.assertAlmostEqual(low, mean - half)
        self.assertAlmostEqual(high, mean + half)

    def test_differences_are_those_of_the_same_policies_and_starts(self) -> None:
        text = io.StringIO()
        text.write("# start i: spawn seed 1 + i\npart,group,policy,loop,simulator,ends\n")
        for policy in range(5):
            for simulator, ends in (("mujoco", "SSSt"), ("chipmunk", "SttS" if policy else "SSSS")):
                text.write(f"primary,small,small-{policy},tracker,{simulator},{ends}\n")
        (self.folder / "table.xz").write_bytes(lzma.compress(text.getvalue().encode()))
        script = [sys.executable, str(STUDY / "recompute.py"), "table.xz"]
        done = subprocess.run(script, capture_output=True, text=True, cwd=self.folder, check=True)
        (row,) = csv.DictReader(io.StringIO(done.stdout))
        self.assertEqual((row["mujoco"], row["difference"]), ("0.750", "-0.150"))
        self.assertEqual(row["policies"], "5")
        self.assertLess(float(row["low"]), -0.15)


class Hypotheses(StudyCase):
    """Tables in which the truth is known."""

    STARTS = 120

    def table(self, rate: Any, stuck: float = 0.9, step: float = 0.02) -> hypotheses.Endings:
        """Endings of independent episodes, of which rate(group, loop, simulator) succeed, and
        `step` more with each training seed."""
        generator = np.random.default_rng(5)
        recipes = ("small", "shipped")
        seeds = {f"{recipe}-mujoco": range(100, 108) for recipe in recipes}
        for number in range(1, 6):
            first = 100 + 10 * number
            seeds.update({f"{r}-draw_{number}": range(first, first + 3) for r in recipes})
        seeds.update({f"epochs_{e}-width_{w}": range(100, 105) for e, w in ((60, 512), (600, 256))})
        simulators = (
            "mujoco",
            "two_mass",
            "chipmunk",
            "box2d",
            "bullet",
            "bullet:preset=idiomatic",
        )
        text = io.StringIO()
        text.write("part,group,policy,loop,simulator,ends\n")
        for group, numbers in seeds.items():
            for loop in ("none", "tracker"):
                for simulator in simulators:
                    for seed in numbers:
                        p = rate(group, loop, simulator) + step * (seed % 5 - 2)
                        draw = generator.random((2, self.STARTS))
                        failed = np.where(draw[1] < stuck, "t", "m")
                        ends = "".join(np.where(draw[0] < p, "S", failed))
                        text.write(f"primary,{group},{group}-{seed},{loop},{simulator},{ends}\n")
        path = self.folder / "endings.csv.xz"
        path.write_bytes(lzma.compress(text.getvalue().encode()))
        return hypotheses.Endings(path)

    def verdicts(self, table: hypotheses.Endings) -> Any:
        found = hypotheses.judge(table)
        self.assertEqual([int(one.name.split()[0][1:]) for one in found], list(range(1, 18)))
        return {one.name.split()[0]: one.verdict for one in found}

    def test_what_is_so_is_found(self) -> None:
        def rate(group: str, loop: str, simulator: str) -> float:
            home = 0.7 if loop == "tracker" else 0.4
            if simulator == "two_mass":
                home -= 0.5 if "shipped" in group else 0.3
            return home - (0.3 if "idiomatic" in simulator else 0.0)

        verdicts = self.verdicts(self.table(rate))
        for number in (7, 8, 9, 10, 11, 12, 14, 15, 16, 17):
            self.assertEqual(verdicts[f"N{number}"], "holds", number)

    def test_the_other_way_is_contradicted(self) -> None:
        def rate(group: str, loop: str, simulator: str) -> float:
            home = 0.3 if loop == "tracker" else 0.6
            return home + (0.3 if simulator != "mujoco" else 0.0)

        verdicts = self.verdicts(self.table(rate, stuck=0.1))
        for number in (*range(1, 10), *range(14, 18)):
            self.assertEqual(verdicts[f"N{number}"], "contradicted", number)

    def test_what_is_not_there_is_not_shown(self) -> None:
        verdicts = self.verdicts(self.table(lambda *_: 0.5, stuck=0.5))
        for number in (7, 8, 9, 10, 11, 12, 14, 15, 16, 17):
            self.assertEqual(verdicts[f"N{number}"], "not shown", number)

    def test_ranks_are_of_the_same_policies(self) -> None:
        found = hypotheses.tau_within_recipes(self.table(lambda *_: 0.5, step=0.15))
        self.assertEqual(found.verdict, "holds", "success grows with the seed, in both")


if __name__ == "__main__":
    unittest.main()
