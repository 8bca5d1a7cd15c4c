#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The numpy engine against the golden vectors, with the tolerances of the C++ tests."""

import inspect
import json
import re
import subprocess
import sys
import unittest
from dataclasses import replace
from pathlib import Path
from typing import Any, Dict, List, Tuple

import numpy as np
from pusht_task.task import spawn, wrap_angle

import numpy_two_mass
from numpy_two_mass import (
    BAR,
    NumpyTwoMass,
    find_contacts,
    link_force,
    solve_contacts,
)

PACKAGE = Path(__file__).parents[1]
GOLDEN_FILE = Path(__file__).parents[2] / "pusht_testing" / "data" / "pusht_golden.json"
GOLDEN = json.loads(GOLDEN_FILE.read_text())
UNIT_TOLERANCE = 1e-12
TRAJECTORY_TOLERANCE = 1e-9
DEADLINE = 60  # s, for one command


class Golden(unittest.TestCase):
    def test_units(self) -> None:
        contact_count = 0
        for unit in GOLDEN["units"]:
            q, v, m = (np.array(unit[key]) for key in "qvm")
            expected = np.array(unit["link_force"])
            scale = max(1.0, float(np.linalg.norm(expected[BAR])))
            error = link_force(q, v, m, baumgarte=40.0) - expected
            self.assertLessEqual(np.linalg.norm(error, axis=1).max(), UNIT_TOLERANCE * scale)

            contacts = find_contacts(q)
            self.assertEqual([c.block for c in contacts], [c["j"] for c in unit["contacts"]])
            for found, wanted in zip(contacts, unit["contacts"]):
                self.assertLessEqual(np.linalg.norm(found.normal - wanted["n"]), UNIT_TOLERANCE)
                self.assertAlmostEqual(found.depth, wanted["depth"], delta=UNIT_TOLERANCE)
            contact_count += len(contacts)

            error = solve_contacts(contacts, m, v) - unit["v_after_contacts"]
            self.assertLessEqual(np.linalg.norm(error, axis=1).max(), UNIT_TOLERANCE)
        self.assertGreater(contact_count, 10, "the golden units must exercise contacts")

    def test_trajectories(self) -> None:
        """Every step of every case and set of parameters, clipping included."""
        for case in GOLDEN["cases"]:
            for expected in case["engine"]:
                with self.subTest(seed=case["seed"], parameters=expected["knobs"]):
                    world = NumpyTwoMass(**expected["knobs"])
                    world.reset(spawn(case["seed"]))
                    self.assert_row(world, expected, 0)
                    for step, action in enumerate(case["actions"], start=1):
                        world.step(np.array(action))
                        self.assert_row(world, expected, step)

    def assert_row(self, world: NumpyTwoMass, expected: Dict[str, Any], step: int) -> None:
        for found, key in ((world.q, "q_pusher_bar_stem"), (world.v, "v_pusher_bar_stem")):
            error = np.abs(found.ravel() - expected[key][step]).max()
            self.assertLessEqual(error, TRAJECTORY_TOLERANCE, f"{key}, step {step}")
        error = abs(wrap_angle(world.yaw - expected["yaw"][step]))
        self.assertLessEqual(error, TRAJECTORY_TOLERANCE, f"yaw, step {step}")


class Parameters(unittest.TestCase):
    def test_are_the_courses_parameters_of_the_engine(self) -> None:
        """Names and defaults as the header has them."""
        header = (PACKAGE / "include" / "pusht_engine" / "two_mass_engine.hpp").read_text()
        table = header[header.index("kParameters = {") :]
        names = re.findall(r'{"(\w+)", "[^"]+", "', table)
        given = inspect.signature(NumpyTwoMass).parameters
        self.assertEqual(list(given), names[: len(given)])
        for name, parameter in given.items():
            self.assertIn(f"double {name} = {parameter.default:.1f};", header)


class Speed(unittest.TestCase):
    def command(self, *arguments: str) -> "subprocess.CompletedProcess[str]":
        return subprocess.run(
            [sys.executable, numpy_two_mass.__file__, *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            timeout=DEADLINE,
        )

    def test_prints_a_rate(self) -> None:
        for where in ("--contact", "--free"):
            process = self.command("--seconds", "0.01", where)
            self.assertEqual((process.returncode, process.stderr), (0, ""))
            self.assertGreater(json.loads(process.stdout)["control_steps_per_second"], 0)

    def test_contact_is_contact(self) -> None:
        """What is timed as contact touches both masses of the tee, what is timed as free none."""
        start = spawn(0)
        for act, begin, contacts in (
            (numpy_two_mass.push, start, 2),
            (numpy_two_mass.rest, replace(start, pusher_x=10.0), 0),
        ):
            world = NumpyTwoMass()
            world.reset(begin)
            for _ in range(30):
                world.step(act(world))
            for _ in range(30):
                world.step(act(world))
                self.assertEqual(len(find_contacts(world.q)), contacts)

    def test_bad_arguments(self) -> None:
        cases: List[Tuple[List[str], str]] = [
            (["--contact", "--seconds", "0"], "'0': must be a number > 0"),
            (["--contact", "--seconds", "nan"], "'nan'"),
            ([], "--contact --free"),
        ]
        for arguments, named in cases:
            process = self.command(*arguments)
            self.assertEqual(process.returncode, 2)
            self.assertEqual(process.stderr.count("\n"), 1, process.stderr)
            self.assertIn(named, process.stderr)


if __name__ == "__main__":
    unittest.main()
