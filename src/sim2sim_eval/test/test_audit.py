#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Audits of simulators by the command `audit`."""

import json
import unittest
from typing import Any, Dict, List

from command_case import CommandCase, executable

AUDIT = executable("sim2sim_eval", "audit")


class Audits(CommandCase):
    def audit(self, *arguments: str) -> Dict[str, Any]:
        """What an audit without an error of the contract has written."""
        process = self.run_command(AUDIT, "--out", "audit.json", "--overwrite", *arguments)
        self.assertEqual((process.returncode, process.stderr), (0, ""), process.stdout)
        result: Dict[str, Any] = json.loads((self.folder / "audit.json").read_text())
        return result

    def test_a_kind_is_the_same_as_itself(self) -> None:
        self.assertEqual(self.audit("--engine", "mujoco")["findings"], [])

    def test_the_faithful_engine_is_the_same_as_mujoco(self) -> None:
        self.assertEqual(self.audit("--engine", "rigid_body")["findings"], [])

    def test_the_two_mass_engine_keeps_the_contract_and_has_another_physics(self) -> None:
        findings: List[str] = self.audit()["findings"]
        for key in ("servo_limit", "tee_damping", "tee_friction_x", "contact_friction", "wall_up"):
            self.assertIn(key, findings)

    def test_a_switch_is_named(self) -> None:
        audit = self.audit("--engine", "rigid_body", "--set", "coulomb=false")
        self.assertIn(audit["findings"][0], ("tee_friction_x", "tee_friction_y"))

    def test_against_the_task(self) -> None:
        audit = self.audit("--engine", "chipmunk", "--against", "task")
        self.assertEqual((audit["reference"], audit["findings"]), ("the task", []))

    def test_one_screen(self) -> None:
        process = self.run_command(AUDIT)
        self.assertLess(len(process.stdout.splitlines()), 45)

    def test_threads_do_not_change_a_byte(self) -> None:
        outputs = [self.run_command(AUDIT, "--threads", threads).stdout for threads in ("1", "2")]
        self.assertEqual(outputs[0], outputs[1])

    def test_a_file_that_is_there_stays(self) -> None:
        (self.folder / "audit.json").write_text("mine")
        process = self.run_command(AUDIT, "--out", "audit.json")
        self.assertEqual(process.returncode, 2)
        self.assertEqual((self.folder / "audit.json").read_text(), "mine")

    def test_refused(self) -> None:
        for arguments in (
            ("--engine", "nothing"),
            ("--set", "block_damp=1000"),
            ("--against", "nature"),
            ("--against", "task", "--reference", "mujoco"),
            ("--out", ""),
            ("--seed", "-1"),
        ):
            with self.subTest(arguments):
                process = self.run_command(AUDIT, *arguments)
                self.assertEqual((process.returncode, process.stdout), (2, ""))
                self.assertEqual(len(process.stderr.splitlines()), 1)


if __name__ == "__main__":
    unittest.main()
