#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What the commands do, from Python: their figures, words and files."""

import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Any, Dict

import numpy as np
import sim2sim
from catkin.find_in_workspaces import find_in_workspaces  # type: ignore[import]

RUN: Dict[str, Any] = {"episodes": 20, "horizon": 30, "floor": False}
HAS_PANDAS = importlib.util.find_spec("pandas") is not None


def command(name: str, *arguments: object) -> str:
    """What a command prints."""
    path: str = find_in_workspaces(["libexec"], "sim2sim_eval", name, first_match_only=True)[0]
    return subprocess.run(
        [path, *map(str, arguments)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    ).stdout


class CommandsCase(unittest.TestCase):
    """In a folder of its own, which is the current one."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(folder.name)


class Runs(CommandsCase):
    def setUp(self) -> None:
        super().setUp()
        self.first = sim2sim.compare("expert", **RUN)
        self.other = sim2sim.compare("expert", engine="chipmunk", out="other", **RUN)

    def test_contrast_is_that_of_the_command(self) -> None:
        sim2sim.compare("expert", out="first", **RUN)
        found = sim2sim.contrast(self.first, "other", out="contrast.json")
        self.assertEqual(found.text, command("contrast", "first", "other", "--out", "c.json"))
        self.assertEqual(found.figures, json.loads(Path("c.json").read_text()))
        self.assertEqual(Path("contrast.json").read_bytes(), Path("c.json").read_bytes())
        self.assertEqual(str(found), found.text)
        figures = found.figures["contrasts"][0]["figures"]
        self.assertEqual(list(found.columns["figure"]), list(figures))
        row = list(figures).index("engine_success_rate")
        self.assertEqual(
            [found.columns["low"][row], found.columns["high"][row]],
            figures["engine_success_rate"]["interval"],
        )
        turned = sim2sim.contrast(self.first, self.other, against=1)
        np.testing.assert_array_equal(turned.columns["difference"], -found.columns["difference"])

    def test_plan_is_that_of_the_command(self) -> None:
        found = sim2sim.plan("other", episodes=[50, 400], position=0.01)
        said = command("plan", "other", "--episodes", "50,400", "--position", "0.01")
        self.assertEqual(found.text, said)
        self.assertEqual(found.figures["episodes"], [50, 400])
        self.assertEqual(
            list(found.columns),
            ["figure", "smallest_in_50", "smallest_in_400", "episodes_needed", "wanted"],
        )
        for row, line in enumerate(said.splitlines()[1:-1]):
            for cell, n in zip(line[44:].split(), (50, 400)):
                value = found.columns[f"smallest_in_{n}"][row]
                self.assertEqual(cell in ("-", "none"), np.isnan(value), line)
                if not np.isnan(value):
                    self.assertAlmostEqual(float(cell) / value, 1.0, delta=0.05)
        needed = found.columns["episodes_needed"][1]
        self.assertIn(f"0.01: {int(needed)} episodes", said)
        sim2sim.plan(self.first, self.other)

    def test_load(self) -> None:
        found = sim2sim.load("other")
        for name, column in self.other.episodes.items():
            np.testing.assert_array_equal(found.episodes[name], column, name)
        self.assertEqual(found.summary, self.other.summary)
        self.assertEqual(found.provenance, self.other.provenance)
        self.assertEqual(found.folder, Path("other"))
        self.assertIn(found.text, self.other.text)
        for folder in ("none", "."):
            with self.assertRaisesRegex(sim2sim.InvalidInput, "metrics.json"):
                sim2sim.load(folder)

    def test_report(self) -> None:
        page = sim2sim.report(self.other, animate=[3, 4])
        self.assertEqual(page, Path("other/report.html"))
        self.assertEqual(page.read_text()[:9], "<!DOCTYPE")
        refusals = (
            (lambda: sim2sim.report(self.first), "^results: must have files; give compare"),
            (lambda: sim2sim.report("other", pages=2), "--pages=2"),
            (lambda: sim2sim.report(3), "^results 3: must be a name or a path"),  # type: ignore
        )
        for call, line in refusals:
            with self.assertRaisesRegex(sim2sim.InvalidInput, line) as caught:
                call()
            self.assertNotIn("\n", str(caught.exception))

    def test_words_are_the_commands(self) -> None:
        refusals = (
            (lambda: sim2sim.contrast("other"), "^results other: is one run; name two"),
            (lambda: sim2sim.contrast("other", "none"), "^results none: must be the folder of"),
            (lambda: sim2sim.contrast("other", "other", against="b"), "^--against: 'b': must be"),
            (lambda: sim2sim.contrast("a", "b", agianst=1), "did you mean --against"),
            (lambda: sim2sim.contrast("-a", "--out=b"), "^results -a: must be the folder"),
            (lambda: sim2sim.contrast("a\0b", "b"), "must be text without NUL characters$"),
            (lambda: sim2sim.plan("other", success=-1), "^success -1: must be above 0"),
            (lambda: sim2sim.matrix("other"), "^results other"),
            (lambda: sim2sim.load(3), "^results 3: must be a name or a path$"),
            (lambda: sim2sim.plan("other", help=True), "^help: there is no such option"),
        )
        for call, line in refusals:
            with self.subTest(line), self.assertRaisesRegex(sim2sim.InvalidInput, line):
                call()

    def test_a_command_beside_a_run(self) -> None:
        def policy(rows: Any) -> Any:
            sim2sim.contrast("other", "other")

        with self.assertRaisesRegex(sim2sim.InvalidInput, "^contrast: another command runs"):
            sim2sim.compare(policy, **RUN)
        sim2sim.contrast("other", "other")


class Sweeps(CommandsCase):
    PLAN = {"policies": ["expert", "bc"], "engine": ["two_mass", "chipmunk"], **RUN}

    def test_sweep_and_matrix_are_those_of_the_commands(self) -> None:
        found = sim2sim.sweep(self.PLAN, out="in_python", threads=1)
        Path("plan.yaml").write_text(json.dumps(self.PLAN))
        said = command("sweep", "plan.yaml", "--out", "by_command")
        self.assertEqual(found.text, said.replace("by_command", "in_python"))
        self.assertEqual(found.folder, Path("in_python"))
        for name in ("sweep.csv", "sweep.json", "rows/003/episodes.csv"):
            self.assertEqual(
                Path("in_python", name).read_bytes(), Path("by_command", name).read_bytes(), name
            )
        self.assertEqual(len(found.columns["engine_simulator"]), 4)
        rows = found.rows()
        self.assertEqual(
            [row.summary["engine_success_rate"] for row in rows],
            list(found.columns["engine_success_rate"]),
        )
        provenance = json.loads(Path("in_python/provenance.json").read_text())
        self.assertEqual(rows[3].provenance, provenance)
        again = sim2sim.load("in_python")
        self.assertEqual(list(again.columns), list(found.columns))

        matrix = sim2sim.matrix(found)
        self.assertEqual(matrix.text, command("matrix", "by_command"))
        self.assertEqual(matrix.figures, json.loads(Path("by_command/matrix.json").read_text()))
        self.assertEqual(
            list(matrix.columns),
            Path("by_command/matrix.csv").read_text().splitlines()[0].split(","),
        )
        with self.assertRaisesRegex(sim2sim.InvalidInput, "is there already"):
            sim2sim.matrix("in_python")
        rankings = sim2sim.plan(found).columns
        self.assertEqual(list(rankings), ["here", "there", "kendall", "policies_needed"])
        contrasts = sim2sim.contrast(*rows[:2], against=0)
        self.assertEqual(set(contrasts.columns["run"]), {"Chipmunk"})

    def test_a_plan_that_is_refused(self) -> None:
        for plan, line in (
            ({"grid": {"damp": [1]}}, "parameter 'damp': unknown"),
            ({"grid": {1, 2}}, "^plan: "),
            ({}, "^sweep plan.yaml: must have grid"),
            ("none.yaml", "none.yaml"),
        ):
            with self.assertRaisesRegex(sim2sim.InvalidInput, line):
                sim2sim.sweep(plan, out="out")  # type: ignore[arg-type]

    def test_ctrl_c_ends_a_sweep_in_order(self) -> None:
        program = (
            "import pathlib, signal, sim2sim, threading\n"
            "def watch():\n"
            "    journal = pathlib.Path('out/rows/000/episodes.journal')\n"
            "    while not journal.exists() or journal.read_text().count('\\n') < 3: pass\n"
            "    signal.raise_signal(signal.SIGINT)\n"
            "threading.Thread(target=watch).start()\n"
            "try:\n"
            "    plan = {'policy': 'expert', 'grid': {'block_damp': [2]}}\n"
            "    sim2sim.sweep(plan, episodes=50000, out='out')\n"
            "except KeyboardInterrupt:\n"
            "    sim2sim.sweep(plan, episodes=2, out='other')\n"
            "    print('went on')\n"
        )
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
        self.assertEqual((done.stdout, done.returncode), ("went on\n", 0), done.stderr)
        status = json.loads(Path("out/status.json").read_text())
        self.assertRegex(status["reason"], "^interrupted in row")


class Frames(CommandsCase):
    @unittest.skipUnless(HAS_PANDAS, "pandas cannot be imported here")
    def test_they_have_the_columns(self) -> None:
        first, other = (sim2sim.compare("expert", seed=seed, **RUN) for seed in (0, 0))
        frame = first.frame()
        self.assertEqual(list(frame.columns), list(first.episodes))
        self.assertEqual(len(frame), 3 * RUN["episodes"])
        rate = frame[frame["mode"] == "engine_closed"]["success"].mean()
        self.assertEqual(rate, first.summary["engine_success_rate"])
        contrast = sim2sim.contrast(first, other)
        self.assertEqual(
            contrast.frame().set_index("figure").loc["engine_success_rate", "difference"], 0.0
        )

    def test_without_pandas_they_say_so(self) -> None:
        program = (
            "import sys; sys.modules['pandas'] = None\n"
            "import sim2sim\n"
            "found = sim2sim.compare('expert', episodes=1, horizon=3, floor=False)\n"
            "try: found.frame()\n"
            "except sim2sim.BadDependency as error: print(error)\n"
        )
        said = subprocess.run(
            [sys.executable, "-c", program], capture_output=True, text=True, check=True
        ).stdout
        self.assertRegex(said, "^pandas: not found; .* are there as arrays\n$")


if __name__ == "__main__":
    unittest.main()
