#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Tables of success under noise, on endings whose figures follow by hand."""

import csv
import io
import math
import subprocess
import sys
import unittest
from pathlib import Path
from typing import Any, Dict, Sequence

import numpy as np
from scipy import stats  # type: ignore[import]
from sim2sim_study import curves, groups, tables
from sim2sim_study.endings import Cell, Endings, Table, write_endings
from study_case import StudyCase

STUDY = Path(__file__).resolve().parents[3] / "docs" / "study" / "noise"
sys.path.insert(0, str(STUDY))

import recompute  # noqa: E402


def table(
    of: Dict[str, Sequence[str]], group: str = "small", part: str = "primary", loop: str = "none"
) -> Table:
    """Endings of a group: by simulator, a text for each policy."""
    return {
        Cell(part, group, f"{group}-{number}", loop, simulator): ends
        for simulator, policies in of.items()
        for number, ends in enumerate(policies)
    }


def rows_of(found: Table) -> Dict[Any, tables.Row]:
    rows = list(groups.group_rows(Endings(found)))
    return {(row["part"], row["loop"], row["group"], row["simulator"]): row for row in rows}


class GroupRows(StudyCase):
    # Policy i fails from i of four starts; all succeed in MuJoCo.
    HOME, AWAY = 5 * ["SSSS"], ["SSSS", "tSSS", "ttSS", "tttS", "mmmm"]

    def test_figures_follow_by_hand(self) -> None:
        row = rows_of(table({"mujoco": self.HOME, "chipmunk": self.AWAY}))[
            "primary", "none", "small", "chipmunk"
        ]
        self.assertEqual((row["policies"], row["success"], row["difference"]), (5, 0.5, -0.5))
        self.assertEqual((row["lowest_training"], row["highest_training"]), (-1.0, 0.0))
        self.assertEqual((row["failures"], row["stuck"]), (10, 0.6))
        # Mean squares of policies 5 / 8, of starts 1 / 3, of the rest 1 / 8, so the variance of the
        # mean is (5 / 8 + 1 / 3 - 1 / 8) / 20 = 1 / 24.
        freedom = (5 / 6) ** 2 / ((5 / 8) ** 2 / 4 + (1 / 3) ** 2 / 3 + (1 / 8) ** 2 / 12)
        half = stats.t.ppf(0.975, freedom) / math.sqrt(24)
        self.assertAlmostEqual(row["difference_low"], -0.5 - half, places=5)
        self.assertAlmostEqual(row["difference_high"], -0.5 + half, places=5)
        # In MuJoCo nothing varies, so the ratio is a mean over a constant; it is not below 0.
        self.assertEqual((row["transfer"], row["transfer_low"]), (0.5, 0.0))
        self.assertAlmostEqual(row["transfer_high"], 0.5 + half, places=5)

    def test_a_sign_may_hang_on_one_training(self) -> None:
        for values, hangs in (
            ([-0.5, 0.125, 0.125], True),
            ([-0.5, 0.125, -0.25], False),
            ([0.25, -0.25, 0.25], True),  # the others cancel
            ([0.25, 0.25], False),
            ([0.25], False),
        ):
            self.assertEqual(groups.hangs_on_one(np.array(values)), hangs, values)

    def test_the_reference_is_held_against_nothing(self) -> None:
        row = rows_of(table({"mujoco": self.AWAY, "chipmunk": self.HOME}))[
            "primary", "none", "small", "mujoco"
        ]
        self.assertEqual((row["success"], row["failures"]), (0.5, 10))
        self.assertEqual({row[name] for name in groups.COMPARED}, {None})

    def test_a_reference_is_the_first_simulator(self) -> None:
        found = rows_of(table({"chipmunk": self.AWAY, "mujoco": self.HOME}))
        self.assertEqual(found["primary", "none", "small", "mujoco"]["difference"], 0.5)
        self.assertIsNone(found["primary", "none", "small", "chipmunk"]["difference"])

    def test_few_policies_have_no_interval(self) -> None:
        row = rows_of(table({"mujoco": self.HOME[:4], "chipmunk": self.AWAY[:4]}))[
            "primary", "none", "small", "chipmunk"
        ]
        self.assertEqual((row["difference"], row["transfer"]), (-0.375, 0.625))
        for name in ("success", "difference", "transfer"):
            self.assertEqual((row[f"{name}_low"], row[f"{name}_high"]), (None, None))

    def test_without_success_or_failure(self) -> None:
        lost = 5 * ["llll"]
        found = rows_of(table({"mujoco": lost, "chipmunk": lost, "two_mass": self.HOME}))
        chipmunk = found["primary", "none", "small", "chipmunk"]
        self.assertEqual((chipmunk["difference"], chipmunk["transfer"]), (0.0, None))
        self.assertIsNone(chipmunk["difference_low"], "nothing varies")
        self.assertEqual((chipmunk["failures"], chipmunk["stuck"]), (20, 0.0))
        two_mass = found["primary", "none", "small", "two_mass"]
        self.assertEqual((two_mass["failures"], two_mass["stuck"]), (0, None))

    def test_figures_lie_by_their_keys(self) -> None:
        rows = list(groups.group_rows(Endings(table({"mujoco": self.HOME, "box2d": self.AWAY}))))
        figures = tables.nested(rows, "part", "loop", "group", "simulator")
        place = figures["primary"]["none"]["small"]["box2d"]
        self.assertEqual(place["difference"], -0.5)
        self.assertEqual(
            place["difference_interval"], [rows[1]["difference_low"], rows[1]["difference_high"]]
        )
        home = figures["primary"]["none"]["small"]["mujoco"]
        self.assertIsNone(home["difference_interval"])
        self.assertIsNone(home["success_interval"], "nothing varies")


class Recomputation(StudyCase):
    def recomputed(self, found: Table) -> Dict[Any, Dict[str, str]]:
        """What recompute.py prints of a table."""
        write_endings(self.folder / "table.xz", {"first_episode": 390_000}, found)
        script = [sys.executable, str(STUDY / "recompute.py"), "table.xz"]
        done = subprocess.run(script, capture_output=True, text=True, cwd=self.folder, check=True)
        rows = csv.DictReader(io.StringIO(done.stdout))
        return {(row["loop"], row["group"], row["engine"]): row for row in rows}

    def test_published_table_follows_from_the_published_endings(self) -> None:
        script = [sys.executable, str(STUDY / "recompute.py")]
        done = subprocess.run(script, capture_output=True, text=True, check=True)
        recomputed = list(csv.DictReader(io.StringIO(done.stdout)))
        with (STUDY / "groups.csv").open() as file:
            rows = {
                (row["loop"], f"{row['part']} {row['group']}", row["simulator"]): row
                for row in csv.DictReader(file)
            }
        self.assertGreater(len(recomputed), 100)
        for other in recomputed:
            row = rows[other["loop"], other["group"], other["engine"]]
            for name, known in (
                ("success", "success"),
                ("difference", "difference"),
                ("low", "difference_low"),
                ("high", "difference_high"),
            ):
                with self.subTest(name, **other):
                    self.assertAlmostEqual(float(other[name]), float(row[known]), delta=5.1e-4)

    def test_intervals_are_students_where_starts_do_not_differ(self) -> None:
        rates = np.array([0.1, 0.3, 0.35, 0.4, 0.6])
        mean, low, high = recompute.crossed_mean(np.repeat(rates[:, None], 40, axis=1))
        half = stats.t.ppf(0.975, 4) * rates.std(ddof=1) / np.sqrt(5)
        self.assertAlmostEqual(mean, rates.mean())
        self.assertAlmostEqual(low, mean - half)
        self.assertAlmostEqual(high, mean + half)

    def test_differences_are_those_of_the_same_policies_and_starts(self) -> None:
        away = ["SSSS" if policy == 0 else "SttS" for policy in range(5)]
        found = self.recomputed(table({"mujoco": 5 * ["SSSt"], "chipmunk": away}))
        row = found["none", "primary small", "chipmunk"]
        self.assertEqual((row["reference"], row["reference_success"]), ("mujoco", "0.750"))
        self.assertEqual((row["difference"], row["policies"]), ("-0.150", "5"))
        self.assertLess(float(row["low"]), -0.15)

    def test_agrees_with_the_table_of_groups(self) -> None:
        """Two implementations, on groups of several sizes, references and loops."""
        generator = np.random.default_rng(7)

        def ends(count: int, p: float) -> Sequence[str]:
            spread = generator.normal(0.0, 0.1, (count, 1)) + generator.normal(0.0, 0.1, (1, 40))
            won = generator.random((count, 40)) < p + spread
            return ["".join(row) for row in np.where(won, "S", "t")]

        found = {
            **table({"mujoco": ends(8, 0.6), "two_mass": ends(8, 0.3), "box2d:a=b": ends(8, 0.6)}),
            **table({"mujoco": ends(5, 0.6), "two_mass": ends(5, 0.5)}, "big", loop="tracker"),
            **table({"two_mass": ends(5, 0.4), "mujoco": ends(5, 0.9)}, "other", "curves"),
            **table({"mujoco": ends(3, 0.4), "two_mass": ends(3, 0.9)}, "few", "draws"),
            **table({"mujoco": 5 * ["SSSt"], "two_mass": 5 * ["SSSt"]}, "same", "draws"),
        }
        recomputed, rows = self.recomputed(found), rows_of(found)
        compared = 0
        for (part, loop, group, simulator), row in rows.items():
            other = recomputed.get((loop, f"{part} {group}", simulator))
            if row["difference"] is None or group == "few":
                self.assertIsNone(other)
                continue
            assert other
            compared += 1
            home = rows[part, loop, group, other["reference"]]
            for name, value in (
                ("policies", row["policies"]),
                ("reference_success", home["success"]),
                ("success", row["success"]),
                ("difference", row["difference"]),
                ("low", row["difference_low"]),
                ("high", row["difference_high"]),
            ):
                if value is None:
                    self.assertEqual(other[name], "")
                else:
                    self.assertAlmostEqual(float(other[name]), value, delta=5.1e-4)
        self.assertEqual(compared, 5)


class Curves(StudyCase):
    def found(self) -> Table:
        """Two of three policies over noise."""
        loop = groups.NOISE
        return {
            **table({"mujoco": ["SS", "SS", "tt"], "box2d": ["SS", "St", "SS"]}),
            **table(
                {"mujoco": ["SS", "SS"], "box2d": ["St", "tt"]}, "small", "curves", f"{loop}0.01"
            ),
            **table(
                {"mujoco": ["tt", "tt"], "box2d": ["St", "tt"]}, "small", "curves", f"{loop}0.02"
            ),
            **table({"mujoco": ["SS", "SS"]}, "small", "curves", "action_noise=0.1"),
        }

    def test_policies_are_the_same_at_every_noise(self) -> None:
        rows = list(groups.curve_rows(Endings(self.found())))
        of_box2d = {r["noise_mm"]: r["transfer"] for r in rows if r["simulator"] == "box2d"}
        self.assertEqual(of_box2d, {0.0: 0.75, 10.0: 0.25, 20.0: None})
        self.assertEqual({row["policies"] for row in rows}, {2})

    def test_without_the_part_that_has_no_noise(self) -> None:
        found = {cell: ends for cell, ends in self.found().items() if cell.part == "curves"}
        rows = list(groups.curve_rows(Endings(found)))
        self.assertEqual([row["noise_mm"] for row in rows], [10.0, 10.0, 20.0, 20.0])

    def test_picture_has_a_line_for_each_engine(self) -> None:
        rows = list(groups.curve_rows(Endings(self.found())))
        figure = curves.draw_noise(rows, narrow=False)
        (axes,) = figure.axes
        line = next(line for line in axes.lines if line.get_label() == "box2d")
        self.assertEqual(list(line.get_ydata()), [0.75, 0.25])
        self.assertEqual([tick.get_text() for tick in axes.get_xticklabels()], ["0", "10", "20"])


if __name__ == "__main__":
    unittest.main()
