#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""script/policies: the least of everything, from nothing, and after kills; and what it has made."""

import csv
import os
import signal
import subprocess
import sys
import unittest
from pathlib import Path
from typing import Any, Dict

import yaml  # type: ignore[import]
from pusht_policy.checkpoint import provenance_path, read_provenance, sha256_of
from pusht_testing.long_tests import long_form

from command_case import CommandCase, until

ROOT = Path(__file__).resolve().parents[3]
PLAN = ROOT / "docs" / "study" / "policies.yaml"
SHIPPED = ROOT / "src" / "pusht_policy" / "policies"
LARGEST = 1_000_000  # bytes of all checkpoints with their provenance
DEADLINE = 600.0  # s: eight trainings, each a process


class Script(CommandCase):
    def start(self, name: str, *extra: str) -> "subprocess.Popen[str]":
        """The script in a process group of its own, as a shell starts it."""
        options = ["--smoke", *extra]
        for folder in ("work", "shipped", "tables"):
            options += [f"--{folder}", str(self.folder / name / folder)]
        return subprocess.Popen(
            [sys.executable, str(ROOT / "script" / "policies.py"), *options],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )

    def finish(self, name: str, *extra: str) -> Dict[str, bytes]:
        """Checkpoints and tables of a run that must end well."""
        process = self.start(name, *extra)
        output, _ = process.communicate(timeout=DEADLINE)
        self.assertEqual(process.returncode, 0, output)
        made = [*(self.folder / name / "shipped").iterdir()]
        made += (self.folder / name / "tables").iterdir()
        return {path.name: path.read_bytes() for path in made}

    def kill_after(self, name: str, file: str, *extra: str) -> None:
        process = self.start(name, *extra)
        try:
            path = self.folder / name / "work" / file
            until(lambda: path.exists() or process.poll() is not None, DEADLINE)
            self.assertIsNone(process.poll(), f"ended before {file}")
        finally:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()

    @long_form
    def test_ends_with_the_same_bytes_after_kills(self) -> None:
        """The bytes are those of a run that nothing disturbed."""
        plan = yaml.safe_load(PLAN.read_text())
        last = f"{plan['shipped'][-1]}-{plan['first_seed']}.ts.pt"
        self.kill_after("killed", last)
        made = self.finish("killed")
        files = [Path(f"{name}.ts.pt") for name in plan["shipped"]]
        names = {str(path) for file in files for path in (file, provenance_path(file))}
        self.assertEqual(set(made), names)
        for file in files:
            provenance = read_provenance(self.folder / "killed" / "shipped" / file)
            self.assertEqual(provenance["checkpoint"]["file"], file.name)
            self.assertEqual(provenance["evaluation"]["episodes"], 2)
        self.kill_after("killed", "execute-1/rows/003/metrics.json", "--table")
        made = self.finish("killed", "--table")
        rows = list(csv.DictReader(made["policies.csv"].decode().splitlines()))
        expected = {
            (name, str(number), engine)
            for name, group in plan["groups"].items()
            for number in group["execute"]
            for engine in plan["engines"]
        }
        self.assertEqual({(r["group"], r["executed"], r["simulator"]) for r in rows}, expected)
        self.assertEqual(len(rows), len(expected))
        self.finish("whole")
        self.assertEqual(made, self.finish("whole", "--table"))

    def test_smoke_has_folders_of_its_own(self) -> None:
        command = [sys.executable, str(ROOT / "script" / "policies.py"), "--smoke"]
        process = subprocess.run(command, capture_output=True, text=True, timeout=DEADLINE)
        self.assertEqual(process.returncode, 2)
        self.assertIn("--smoke says nothing: give it folders of its own", process.stderr)


class Made(unittest.TestCase):
    """The checkpoints that are shipped, and the table, are those of the plan."""

    def setUp(self) -> None:
        self.plan: Dict[str, Any] = yaml.safe_load(PLAN.read_text())

    def test_checkpoints_are_of_the_plan(self) -> None:
        size = 0
        for name in self.plan["shipped"]:
            with self.subTest(name):
                checkpoint = SHIPPED / f"{name}.ts.pt"
                provenance = read_provenance(checkpoint)
                size += checkpoint.stat().st_size + provenance_path(checkpoint).stat().st_size
                self.assertEqual(provenance["checkpoint"]["sha256"], sha256_of(checkpoint))
                self.assertEqual(provenance["checkpoint"]["file"], checkpoint.name)
                group = self.plan["groups"][name]
                recipe = self.plan["recipes"][group["recipe"]]
                named = ("epochs", "batch", "learning_rate")
                wanted = {key: recipe[key] for key in named if key in recipe}
                wanted["seed"] = self.plan["first_seed"]
                training = provenance["training"]
                self.assertEqual({key: training[key] for key in wanted}, wanted)
                what = self.plan["demonstrations"][group["demonstrations"]]
                [bag] = provenance["demonstrations"]["bags"]
                self.assertEqual(bag["origin"]["action_noise"], what["action_noise"])
                self.assertEqual(provenance["demonstrations"]["episodes"], what["episodes"])
                self.assertEqual(provenance["evaluation"]["episodes"], self.plan["evaluation"])
        self.assertLessEqual(size, LARGEST)

    def test_table_is_of_the_plan(self) -> None:
        with (PLAN.parent / "policies.csv").open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        for row in rows:
            group = self.plan["groups"][row["group"]]
            self.assertIn(int(row["executed"]), group["execute"])
            self.assertEqual(int(row["policies"]), group["seeds"])
        cells = len(self.plan["engines"]) * sum(
            len(g["execute"]) for g in self.plan["groups"].values()
        )
        self.assertEqual(len(rows), cells)


if __name__ == "__main__":
    unittest.main()
