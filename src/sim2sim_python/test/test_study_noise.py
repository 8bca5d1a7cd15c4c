#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""script/study noise: the least of it, its recomputation, and what its figures of pushes mean."""

import csv
import io
import lzma
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Any

import numpy as np
from pusht_task.testing.long_tests import long_form
from scipy import stats  # type: ignore[import]
from sim2sim import STATE_FIELDS

ROOT = Path(__file__).resolve().parents[3]
STUDY = ROOT / "docs" / "study" / "noise"
sys.path[:0] = [str(ROOT / "script"), str(STUDY)]

import recompute  # noqa: E402
import study_noise  # noqa: E402
import study_noise_findings  # noqa: E402
import study_pushes  # noqa: E402

DEADLINE = 600.0  # s


class FolderCase(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)


class Study(FolderCase):
    @long_form
    def test_the_least_of_it_from_nothing(self) -> None:
        folders = ("--work", str(self.folder / "work"), "--tables", str(self.folder / "tables"))
        command = [sys.executable, str(ROOT / "script" / "study_noise.py"), "--smoke", *folders]
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
        plan = study_noise.whole_plan()
        for group in plan["groups"].values():
            self.assertIn(group["demonstrations"], plan["demonstrations"])
            self.assertIn(group["recipe"], plan["recipes"])
        tested = [entry["group"] for part in study_noise.parts_of(plan) for entry in part.policies]
        self.assertLessEqual(set(plan["groups"]), set(tested))
        self.assertEqual(plan["recipes"]["epochs_600-width_256"]["epochs"], 600)


def file_in(folder: Path) -> Path:
    return folder / "tables" / "endings.csv.xz"


class Recomputation(FolderCase):
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


class Hypotheses(FolderCase):
    """Tables in which the truth is known."""

    STARTS = 120

    def table(
        self, rate: Any, stuck: float = 0.9, step: float = 0.02
    ) -> study_noise_findings.Endings:
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
        return study_noise_findings.Endings(path)

    def verdicts(self, table: study_noise_findings.Endings) -> Any:
        found = study_noise_findings.judge(table)
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
        found = study_noise_findings.tau_within_recipes(self.table(lambda *_: 0.5, step=0.15))
        self.assertEqual(found.verdict, "holds", "success grows with the seed, in both")


def state(x: float, y: float, yaw: float) -> Any:
    values = dict.fromkeys(STATE_FIELDS, 0.0)
    values.update(tee_x=x, tee_y=y, tee_yaw=yaw)
    return [values[name] for name in STATE_FIELDS]


class Pushes(unittest.TestCase):
    def figures(self, reference: Any, engine: Any) -> Any:
        """Figures of one push that begins in the middle of the table."""
        start, end = np.array([state(0.0, 0.0, 0.0)]), np.array([state(*reference)])
        pushes = study_pushes.Pushes(np.zeros(1, int), start, np.zeros((1, 5, 2)), end)
        found = study_pushes.figures_of(pushes, np.array([state(*engine)]))
        return {name: float(values[0]) for name, values in found.items()}

    def test_the_same_answer(self) -> None:
        same = self.figures((0.01, 0.0, 0.2), (0.01, 0.0, 0.2))
        for name in ("position_error", "missed", "other_way", "direction", "size", "weak"):
            self.assertAlmostEqual(same[name], 0.0, places=5, msg=name)

    def test_other_answers(self) -> None:
        back = self.figures((0.01, 0.0, 0.0), (-0.02, 0.0, 0.0))
        self.assertEqual((back["missed"], back["other_way"]), (0.0, 1.0))
        self.assertAlmostEqual(back["direction"], 180.0)
        self.assertAlmostEqual(back["size"], np.log(2.0))
        self.assertAlmostEqual(back["position_error"], 0.03)
        missed = self.figures((0.01, 0.0, 0.0), (0.0, 0.002, 0.0))
        self.assertEqual((missed["missed"], missed["direction"]), (1.0, 90.0))
        self.assertTrue(np.isnan(missed["other_way"]))
        self.assertAlmostEqual(missed["weak"], 0.8)

    def test_a_turn_about_the_center_of_mass_moves_it_nowhere(self) -> None:
        center = 0.06 * 0.045 / 0.105  # [m] along body -y
        turned = (-center * np.sin(0.5), -center + center * np.cos(0.5), 0.5)
        move = study_pushes.displacement(np.zeros(3), np.array(turned))
        np.testing.assert_allclose(move, [0.0, 0.0, 0.022], atol=1e-12)

    def test_engines_are_drawn_once_and_no_two_are_alike(self) -> None:
        plan = study_noise.whole_plan()["pushes"]
        engines = study_pushes.population(plan)
        self.assertEqual(len(set(engines)), 39)
        self.assertEqual(engines, study_pushes.population(plan))
        self.assertFalse(set(engines) & set(plan["seen"]))

    def judged(self, lost_by: str) -> Any:
        """Forty engines whose lost success is one of the figures, with noise of starts."""
        generator = np.random.default_rng(3)
        engines, shape = np.linspace(0.0, 1.0, 40), (4, 40, 100)
        figures = {name: generator.permutation(engines) for name in study_pushes.FIGURES}
        figures["size"] = np.where(figures["weak"] > 0.5, -0.2, 0.2)
        recipes = []
        for _ in range(2):
            spread = generator.normal(0.0, 0.1, shape)
            lost = figures[lost_by][None, :, None] + generator.normal(0.0, 0.5, shape)
            values = {name: y[None, :, None] + spread for name, y in figures.items()}
            counts = {name: np.ones(shape) for name in figures}
            recipes.append(study_pushes.Sums(values, counts, lost))
        return {one.name.split()[0]: one.verdict for one in study_pushes.judge(recipes, 300)}

    def test_what_orders_engines_is_found(self) -> None:
        by_direction = self.judged("direction")
        self.assertEqual((by_direction["P1"], by_direction["P2"]), ("holds", "not shown"))
        by_error = self.judged("position_error")
        self.assertEqual((by_error["P1"], by_error["P2"]), ("contradicted", "contradicted"))
        self.assertEqual(by_error["P3"], "contradicted", "they cost a half")
        by_weakness = self.judged("weak")
        self.assertEqual(by_weakness["P4"], "holds")

    def test_the_reference_answers_its_own_pushes(self) -> None:
        import sim2sim

        rollouts = study_pushes.roll_out(sim2sim.load_policy("expert"), [400_000, 400_001])
        pushes = study_pushes.pushes_in(rollouts, 5, 0.002)
        self.assertGreater(len(pushes.start), 5)
        found = study_pushes.figures_of(pushes, study_pushes.answers("mujoco", pushes))
        self.assertLess(found["position_error"].max(), 1e-6, "contacts are found to 1e-6 m")


if __name__ == "__main__":
    unittest.main()
