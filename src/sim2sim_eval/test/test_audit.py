#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Audits of simulators by the command `audit`."""

import json
import re
import unittest
from pathlib import Path
from typing import Any, Dict, List, Tuple

from command_case import CommandCase, executable

AUDIT = executable("sim2sim_eval", "audit")
COMPARE = executable("sim2sim_eval", "compare")
THREE_EPISODES = [("0.1\n", "7\n"), ("0.1\n", "8\n"), ("0.1\n", "7\n")]
DEMONSTRATE = executable("sim2sim_eval", "demonstrate")
RUN = ("--policy", "expert", "--episodes", "1", "--horizon", "20", "--no-floor")


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

    def check_idioms(self, kind: str, expected: Dict[str, List[str]], broken: str = "") -> None:
        """Each idiom alone, by its switch, against what it must be found by.

        The reset of the idiom `broken` is not exact.
        """
        for switch, findings in expected.items():
            with self.subTest(switch):
                engine = ("--engine", kind, "--set", f"{switch}=false", "--against", "task")
                process = self.run_command(AUDIT, "--out", f"{switch}.json", *engine)
                self.assertEqual(process.returncode, 5 * (switch == broken), process.stderr)
                found = self.load(".", f"{switch}.json")["findings"]
                self.assertEqual([key for key in findings if key not in found], [], found)
                if switch in ("servo", "slop", "order"):
                    self.assertEqual(found, findings)

    def test_each_idiom_of_bullet_is_a_finding_of_its_own(self) -> None:
        expected = {
            "servo": ["servo_gain"],
            "table_friction": ["friction_shape"],
            "drag": ["damping_point"],
            "margin": ["pusher_radius"],
        }
        # A tee on a plane has a height and a tilt, which no reset sets.
        self.check_idioms("bullet", expected, broken="table_friction")

    def test_idiomatic_bullet_breaks_no_contract(self) -> None:
        audit = self.audit("--engine", "bullet", "--set", "preset=idiomatic", "--against", "task")
        self.assertIn("pusher_radius", audit["findings"])

    def test_each_idiom_of_box2d_is_a_finding_of_its_own(self) -> None:
        expected = {
            "servo": ["servo_gain"],
            "table_friction": ["friction_shape"],
            "drag": ["damping_point"],
            "scale": ["pusher_radius", "slop"],
        }
        # In the audit's push the pusher loses touch for a substep, and a reset decides when.
        self.check_idioms("box2d", expected, broken="drag")

    def test_each_idiom_of_chipmunk_is_a_finding_of_its_own(self) -> None:
        expected = {
            "servo": ["servo_gain"],
            "table_friction": ["friction_shape"],
            "drag": ["damping_point"],
            "slop": ["slop"],
            "order": ["move_order"],
        }
        self.check_idioms("chipmunk", expected)

    def test_against_the_task(self) -> None:
        audit = self.audit("--engine", "chipmunk", "--against", "task")
        self.assertEqual((audit["reference"], audit["findings"]), ("the task", []))

    def test_every_kind_differs_from_the_task_only_where_it_says_so(self) -> None:
        """A kind is held to the task by being installed, whichever package it is of."""
        kinds = re.search(r"kind of simulator: (.+)", self.run_command(AUDIT, "--help").stdout)
        assert kinds is not None
        names = re.findall(r"\w+", kinds[1])
        self.assertLessEqual(
            {"box2d", "bullet", "chipmunk", "mujoco", "rigid_body", "two_mass"}, set(names)
        )
        other_tasks = {"gym_pusht"}
        for name in other_tasks:
            process = self.run_command(AUDIT, "--engine", name, "--against", "task")
            self.assertEqual(process.returncode, 2)
            self.assertIn(f"task full_circle: the kind {name} holds only {name}", process.stderr)
        for name in sorted(set(names) - other_tasks):
            with self.subTest(name):
                audit = self.audit("--engine", name, "--against", "task")
                differs = [p for p in audit["properties"] if p["verdict"] == "differs"]
                self.assertEqual([p["property"] for p in differs if not p["declared"]], [])

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

    def test_file_names_both_simulators_as_a_run_does(self) -> None:
        pair = ("--set-reference", "timestep=0.005", "--engine", "mujoco")
        audit = self.audit(*pair)
        self.run_all((COMPARE, *RUN, *pair, "--out", "run"))
        self.assertEqual(audit["simulators"], self.load("run", "metrics.json")["simulators"])
        against_task = self.audit("--engine", "mujoco", "--against", "task")
        self.assertIsNone(against_task["simulators"]["reference"])

    def demonstrations(self, episodes: int = 30) -> str:
        """A CSV of the expert's demonstrations, by way of the bag."""
        options = ("--seed", "20000", "--episodes", str(episodes), "--out", "demonstrations.bag")
        self.run_all((DEMONSTRATE, *options))
        return "demonstrations.bag"

    def csv(self, *changes: Tuple[str, str]) -> str:
        """A CSV of enough steps, with changes of its text."""
        names = [f"o{i}" for i in range(10)] + ["a0", "a1", "reward"]
        rows = [["0.1"] * 13 for _ in range(700)]
        text = "\n".join(",".join(row) for row in [names, *rows]) + "\n"
        for old, new in changes:
            self.assertIn(old, text)
            text = text.replace(old, new, 1)
        (self.folder / "lab.csv").write_text(text)
        return "lab.csv"

    def test_a_policy_that_is_asked_wrongly(self) -> None:
        from torch_policies import save_swapped  # takes a second

        save_swapped(str(self.folder / "swapped.pt"))
        bag = self.demonstrations()
        command = (AUDIT, "--demonstrations", bag, "--out", "audit.json", "--overwrite", "--policy")
        process = self.run_command(*command, "swapped.pt")
        self.assert_one_line(process, 5, "audit")
        self.assertIn("with pusher and tee swapped the error falls", process.stdout.splitlines()[0])
        written = self.load(".", "audit.json")
        self.assertEqual((written["verdict"], written["contract_holds"]), ("fault", False))
        self.assertEqual(written["explanations"][0]["corrections"], ["pusher and tee swapped"])
        self.assertIn("its training ended at 0.0119", self.run_all((*command, "bc")))
        self.assertEqual(self.load(".", "audit.json")["verdict"], "near")

    def test_f54_demonstrations_that_are_refused(self) -> None:
        for changes, message in (
            ([("0.1,0.1", "0.1,east")], "line 2: column 'o1' 'east': must be a decimal number"),
            ([("0.1,0.1", "0.1,nan")], "line 2: column 'o1' 'nan': must be a decimal number"),
            ([("o3,", "height,")], "line 1: column 'o3' or 'tee_y': is missing"),
            ([("reward", "a1")], "line 1: column 'a1': must appear only once"),
            ([("reward", "tee_y")], "line 1: column 'o3' or 'tee_y': must appear only once"),
            ([("0.1,0.1,", "0.1,")], "line 2: 12 values: must be 13, one for each column"),
            ([("reward", "episode"), *THREE_EPISODES], "line 4: episode '7': its rows must"),
        ):
            with self.subTest(message):
                process = self.run_command(
                    AUDIT, "--policy", "expert", "--demonstrations", self.csv(*changes)
                )
                self.assert_one_line(process, 2, "audit")
                self.assertIn(f"demonstrations lab.csv: {message}", process.stderr)

    def test_f54_what_is_no_demonstration_or_too_little(self) -> None:
        (self.folder / "short.csv").write_text(
            "\n".join(Path(self.folder / self.csv()).read_text().splitlines()[:300])
        )
        (self.folder / "no.bag").write_text("no bag")
        for name, message in (
            ("missing.bag", "bag missing.bag: must be a readable file"),
            ("missing.csv", "missing.csv"),
            ("no.bag", "bag no.bag: must be a whole bag"),
            ("short.csv", "1 episodes with 14 parts"),
        ):
            with self.subTest(name):
                process = self.run_command(AUDIT, "--policy", "expert", "--demonstrations", name)
                self.assert_one_line(process, 2, "audit")
                self.assertIn(message, process.stderr)
        for arguments in (
            ("--policy", "expert"),
            ("--demonstrations", "lab.csv"),
            ("--policy", "expert", "--demonstrations", "lab.csv", "--engine", "mujoco"),
        ):
            with self.subTest(arguments):
                self.assert_one_line(self.run_command(AUDIT, *arguments), 2, "audit")


if __name__ == "__main__":
    unittest.main()
