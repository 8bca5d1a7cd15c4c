#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A disk that fails while a command reads: no command goes on with a part of its input."""

import shutil
import signal
import subprocess
import unittest
from pathlib import Path
from typing import Dict

import rospkg  # type: ignore[import]

from command_case import CommandCase, executable, until

ATTRIBUTE = executable("sim2sim_eval", "attribute")
COMPARE = executable("sim2sim_eval", "compare")
CONTRAST = executable("sim2sim_eval", "contrast")
MATRIX = executable("sim2sim_eval", "matrix")
MERGE = executable("sim2sim_eval", "merge")
PLOT = executable("sim2sim_eval", "plot_sweep")
RECOMPUTE = executable("sim2sim_eval", "recompute")
REPORT = executable("sim2sim_eval", "report")
SWEEP = executable("sim2sim_eval", "sweep")
TRAIN = executable("pusht_policy", "train")
PACKAGES = rospkg.RosPack()
CHECKPOINT = Path(PACKAGES.get_path("pusht_policy"), "policies", "bc_policy.ts.pt")
SCENE = Path(PACKAGES.get_path("pusht_mujoco"), "scenes", "pusht.xml")
SHORT = ("--policy", "expert", "--episodes", "12", "--horizon", "20", "--no-floor")
PLAN = "{policy: expert, episodes: 10, horizon: 20, floor: false, grid: {block_damp: [2, 6]}}"
PRELOAD = "libfail_to_read.so"  # found in the workspace by the loader


class Reading(CommandCase):
    made: "CommandCase"

    @classmethod
    def setUpClass(cls) -> None:
        """A file of each kind that commands read."""
        cls.made = case = CommandCase()
        case.setUp()
        cls.addClassCleanup(case.doCleanups)
        for path in (CHECKPOINT, Path(f"{CHECKPOINT}.provenance.json"), SCENE):
            shutil.copy(path, case.folder)
        case.write("plan.yaml", PLAN.encode())
        case.write("policies.yaml", b"{policies: [expert, bc], episodes: 2, engine: [two_mass]}")
        case.write("expected.yaml", b"e: {more: a, less: b, in: mujoco, side: above}")
        case.run_all(
            (
                COMPARE,
                *SHORT,
                "--write-starts",
                "starts.csv",
                "--out",
                "other",
                "--engine",
                "box2d",
            ),
            (COMPARE, *SHORT, "--record", "--traces", "--reference-cache", "kept", "--out", "run"),
            (SWEEP, "plan.yaml", "--out", "sweep"),
            (SWEEP, "policies.yaml", "--out", "policies"),
            (SWEEP, "plan.yaml", "--shard", "1/2", "--out", "shard-1"),
            (SWEEP, "plan.yaml", "--shard", "2/2", "--out", "shard-2"),
        )

    def setUp(self) -> None:
        super().setUp()
        shutil.copytree(self.made.folder, self.folder, dirs_exist_ok=True)

    def contents(self) -> Dict[Path, bytes]:
        """All files but the status, in which a command says how it ended."""
        files = (path for path in self.folder.rglob("*") if path.is_file())
        return {path: path.read_bytes() for path in files if path.name != "status.json"}

    def assert_told(self, name: str, *command: str) -> None:
        """Reading the file fails after some bytes: a fault that names it, and no results. What a
        run has finished until then may stay, as of every run that fails.
        """
        before = self.contents()
        failing = {"LD_PRELOAD": PRELOAD, "FAIL_TO_READ": f"/{name}"}
        process = self.run_command(*command, environment=failing)
        self.assert_one_line(process, 4, Path(command[0]).name)
        self.assertIn(name, process.stderr)
        self.assertIn("Input/output error", process.stderr)
        new = self.folder / "new"
        after = {path: text for path, text in self.contents().items() if new not in path.parents}
        self.assertEqual(after, before)
        for name in ("metrics.json", "sweep.json"):
            self.assertFalse((new / name).exists())
        shutil.rmtree(new, ignore_errors=True)

    def test_what_commands_read(self) -> None:
        run = (COMPARE, *SHORT, "--out", "new")
        kept = next(path.name for path in (self.folder / "kept").rglob("*") if path.is_file())
        networks = (COMPARE, "--policy", CHECKPOINT.name, *SHORT[2:], "--out", "new")
        for name, command in (
            ("starts.csv", (*run, "--starts", "starts.csv")),
            (SCENE.name, (*run, "--scene", SCENE.name)),
            (kept, (*run, "--reference-cache", "kept")),
            (CHECKPOINT.name, networks),
            (f"{CHECKPOINT.name}.provenance.json", networks),
            ("plan.yaml", (SWEEP, "plan.yaml", "--out", "new")),
            ("run/compare.bag", (RECOMPUTE, "run/compare.bag", "--out", "new")),
            ("run/metrics.json", (CONTRAST, "run", "other")),
            ("other/episodes.csv", (CONTRAST, "run", "other")),
            ("sweep/sweep.json", (CONTRAST, "sweep")),
            ("sweep/rows/001/episodes.csv", (CONTRAST, "sweep")),
            ("sweep/sweep.json", (ATTRIBUTE, "sweep")),
            ("sweep/sweep.json", (SWEEP, "plan.yaml", "--out", "sweep")),
            ("shard-2/sweep.json", (MERGE, "shard-1", "shard-2", "--out", "new")),
            ("policies/sweep.json", (MATRIX, "policies")),
            ("expected.yaml", (MATRIX, "policies", "--hypotheses", "expected.yaml")),
        ):
            with self.subTest(name, command=Path(command[0]).name):
                self.assert_told(name, *command)

    def test_what_programs_in_python_read(self) -> None:
        for name, command in (
            ("run/metrics.json", (REPORT, "run")),
            ("run/episodes.csv", (REPORT, "run")),
            ("run/traces.npy", (REPORT, "run")),
            ("sweep/sweep.json", (PLOT, "sweep", "--out", "new.png")),
            ("run/compare.bag", (TRAIN, "--bag", "run/compare.bag", "--out", "new.ts.pt")),
        ):
            with self.subTest(name, command=Path(command[0]).name):
                self.assert_told(name, *command)

    def test_journal(self) -> None:
        """It stays, and so does what it has of the run."""
        command = (COMPARE, "--policy", "expert", "--episodes", "200", "--out", "long")
        journal = self.folder / "long" / "episodes.journal"

        def begun() -> bool:
            return journal.exists() and journal.read_bytes().count(b"\n") > 2

        with subprocess.Popen(
            command, cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        ) as process:
            until(begun)
            process.send_signal(signal.SIGTERM)
        self.assertEqual(process.returncode, 4)
        before = journal.read_bytes()
        self.assert_told("long/episodes.journal", *command)
        self.assertEqual(journal.read_bytes(), before)


if __name__ == "__main__":
    unittest.main()
