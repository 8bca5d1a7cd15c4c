#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""script/study: the least of everything, from nothing, and after kills."""

import os
import signal
import subprocess
import sys
import unittest
from pathlib import Path
from typing import Any, Dict

import yaml  # type: ignore[import]
from study_case import StudyCase
from pusht_task.testing.long_tests import long_form
from pusht_task.testing.nodes import until

ROOT = Path(__file__).resolve().parents[3]
STUDY = ROOT / "docs" / "study"
DEADLINE = 600.0  # s: eight trainings, each a process
# Files after which a study is killed, in the middle of a step each.
KILLS = (
    "small-mujoco_2000-100.ts.pt",
    "matrix/rows/010/metrics.json",
    "conduct/small-mujoco-100/metrics.json",
)


class Study(StudyCase):
    def start(self, name: str) -> "subprocess.Popen[str]":
        """The study in a process group of its own, as a shell starts it."""
        folder = self.folder / name
        folder.mkdir(exist_ok=True)
        options = ("--smoke", "--work", str(folder / "work"), "--tables", str(folder / "tables"))
        return subprocess.Popen(
            [sys.executable, "-m", "sim2sim_study", *options],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )

    def finish(self, name: str) -> Dict[str, bytes]:
        """The tables of a study that must end well."""
        process = self.start(name)
        output, _ = process.communicate(timeout=DEADLINE)
        self.assertEqual(process.returncode, 0, output)
        tables = self.folder / name / "tables"
        return {path.name: path.read_bytes() for path in tables.iterdir()}

    def kill_after(self, name: str, file: str) -> None:
        process = self.start(name)
        try:
            path = self.folder / name / "work" / file
            until(lambda: path.exists() or process.poll() is not None, file, DEADLINE)
            self.assertIsNone(process.poll(), f"ended before {file}")
        finally:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()

    @long_form
    def test_ends_with_the_same_bytes_after_kills(self) -> None:
        """The bytes are those of a run that nothing disturbed, wherever it is killed."""
        for file in KILLS:
            self.kill_after("killed", file)
        tables = self.finish("killed")
        csv = [
            *("matrix", "groups", "curves", "failures", "rankings", "ladder", "ladder_ranks"),
            *("variants", "conduct", "predictions"),
        ]
        txt = ("matrix", "recipes", "rankings", "variants")
        names = {
            "curves.png",
            "figures.json",
            *(f"{name}.csv" for name in csv),
            *(f"{name}.txt" for name in txt),
        }
        self.assertEqual(set(tables), names)
        self.assertIn(
            b"H11 the two-mass engine ranks them the other way round:", tables["matrix.txt"]
        )
        self.assertEqual(tables, self.finish("whole"))

    def test_a_folder_is_of_one_plan(self) -> None:
        work = self.folder / "one" / "work"
        work.mkdir(parents=True)
        (work / "plan.yaml").write_text("episodes: 7\n")
        process = self.start("one")
        output, _ = process.communicate(timeout=DEADLINE)
        self.assertNotEqual(process.returncode, 0)
        self.assertIn(f"{work / 'plan.yaml'}: episodes differs from the plan's", output)
        self.assertEqual([path.name for path in work.iterdir()], ["plan.yaml"])

    def test_smoke_has_folders_of_its_own(self) -> None:
        command = [sys.executable, "-m", "sim2sim_study", "--smoke"]
        process = subprocess.run(command, capture_output=True, text=True, timeout=DEADLINE)
        self.assertEqual(process.returncode, 2)
        self.assertIn("--smoke says nothing: give it folders of its own", process.stderr)

    def test_hypotheses_are_about_what_is_run(self) -> None:
        plan: Dict[str, Any] = yaml.safe_load((STUDY / "study.yaml").read_text())
        hypotheses: Dict[str, Any] = yaml.safe_load((STUDY / "hypotheses.yaml").read_text())
        page = (STUDY / "plan.md").read_text(encoding="utf-8")
        groups = set(plan["groups"])
        for name, group in plan["groups"].items():
            groups |= {f"after-{epochs}-{name}" for epochs in group.get("also_after", [])}
            self.assertIn(group["demonstrations"], plan["demonstrations"])
        for name, hypothesis in hypotheses.items():
            with self.subTest(name):
                number, words = name.split(" ", 1)
                self.assertIn(f"| {number} | {words} |", page)
                named = hypothesis.get("ranking") or [hypothesis["more"], hypothesis["less"]]
                self.assertLessEqual(set(named), groups)
        for part in ("ladder", "variants"):
            self.assertLessEqual(set(plan[part]["groups"]), groups)
        self.assertLessEqual(set(plan["rankings"]), groups)
        self.assertLessEqual(set(plan["failures"].values()), groups)
        self.assertLessEqual(set(plan["conduct"]["groups"]), groups)
        self.assertIn(plan["conduct"]["slower"]["group"], groups)

    def test_predictions_are_about_what_is_measured(self) -> None:
        plan: Dict[str, Any] = yaml.safe_load((STUDY / "study.yaml").read_text())["conduct"]
        page = (STUDY / "plan.md").read_text(encoding="utf-8")
        groups = {*plan["groups"], f"slower-{plan['slower']['group']}"}
        for name, prediction in plan["predictions"].items():
            with self.subTest(name):
                number, words = name.split(" ", 1)
                self.assertIn(f"| {number} | {words} |", page)
                self.assertLessEqual({prediction["more"], prediction["less"]}, groups)
                self.assertIn(prediction["in"], ("mujoco", plan["engine"]))
                self.assertIn(f"| {prediction['side']} 0 |", page)


if __name__ == "__main__":
    unittest.main()
