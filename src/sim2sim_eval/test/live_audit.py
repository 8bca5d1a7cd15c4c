#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Audits over nodes: audit.launch as its user meets it, own nodes, and nodes that go wrong."""

import json
import re
import unittest
from pathlib import Path
from typing import Any, Dict

from command_case import executable
from launch_support import (
    LAUNCHES,
    Start,
    environment_of,
    node_file,
    parameters_of,
    shared_master,
)
from live_support import LiveCase, Process, free_port

MOST = 60.0  # [s] that an audit of the suite's own simulators may take, its nodes' start included
AUDIT = LAUNCHES / "audit.launch"
BIG_TEE = LAUNCHES.parent / "config" / "big_tee.json"
DEADLINE = "_deadline:=2"  # [s]


def load(file: Path) -> Dict[str, Any]:
    audit: Dict[str, Any] = json.loads(file.read_text())
    return audit


def first_finding(audit: Dict[str, Any]) -> str:
    return audit["findings"][0] if audit["findings"] else "none"


def of(audit: Dict[str, Any], key: str) -> Dict[str, Any]:
    """What an audit says of a property."""
    (found,) = [entry for entry in audit["properties"] if entry["property"] == key]
    entry: Dict[str, Any] = found
    return entry


class Launches(LiveCase):
    deadline = MOST

    def test_same_bytes_as_in_process(self) -> None:
        """By roslaunch, which says what the audit says, and ends with it."""
        arguments = ("seed:=3", "out:=live.json")
        uri = f"http://127.0.0.1:{free_port()}"
        command = ("roslaunch", "-p", uri.split(":")[-1], "sim2sim_eval", "audit.launch")
        launch = Process(self, *command, *arguments, environment=environment_of(self, uri))
        launch.ended(MOST)
        code = self.assert_same_bytes(launch, "--seed 3")
        how = "process has finished cleanly" if code == 0 else f"exit code {code}, cmd"
        self.assertIn(how, launch.output)

    def test_same_bytes_of_other_kinds(self) -> None:
        cases: Dict[str, Dict[str, Any]] = {
            "--reference chipmunk --set-reference iterations=12 --engine rigid_body"
            " --set preset=simple --set drag=true": {
                "reference": "chipmunk",
                "reference_parameters": "iterations=12",
                "engine": "rigid_body",
                "engine_parameters": "preset=simple drag=true",
            },
            "--engine chipmunk --against task": {"engine": "chipmunk", "against": "task"},
            "--engine gym_pusht --set preset=sound --against task --task gym_pusht": {
                "engine": "gym_pusht",
                "engine_parameters": "preset=sound",
                "against": "task",
                "task": "gym_pusht",
            },
            "--reference chipmunk --engine rigid_body --task gym_pusht": {
                "reference": "chipmunk",
                "engine": "rigid_body",
                "task": "gym_pusht",
            },
        }
        for options, arguments in cases.items():
            with self.subTest(options):
                run = Start(self, file="audit", out="live.json", overwrite=True, **arguments)
                code = run.ended(MOST)
                self.assertEqual(self.assert_same_bytes(run, options), code)

    def assert_same_bytes(self, live: Process, options: str) -> int:
        """An audit over nodes has said what the command says; the command's exit code."""
        command = (executable("sim2sim_eval", "audit"), *options.split())
        process = self.run_command(*command, "--out", "batch.json", "--overwrite")
        self.assertTrue((self.folder / "live.json").exists(), live.output)
        self.assertEqual(load(self.folder / "live.json"), load(self.folder / "batch.json"))
        batch = (self.folder / "batch.json").read_bytes()
        self.assertEqual((self.folder / "live.json").read_bytes(), batch)
        self.assertIn(process.stdout, live.output)
        return process.returncode

    def test_own_node_takes_kind_and_parameters(self) -> None:
        node: Dict[str, Any] = {"engine_node": False, "engine": "two_mass"}
        run = Start(self, file="audit", against="task", **node)
        command = (node_file("pusht_engine", "engine_node"), "__name:=engine", "_block_damp:=20")
        Process(self, *command, environment=run.environment)
        run.line("^audit of two-mass engine against the task, seed 0$")
        run.ended()

    def test_every_parameter_of_the_node_is_an_argument(self) -> None:
        parameters = parameters_of(AUDIT)
        given = {re.sub("^/audit/", "", name) for name in parameters if "/audit/" in name}
        run = Start(self, {"audit/nonsense": 1}, file="audit")
        run.ended()
        (names,) = re.findall(r"known: (.*) \(set by a launch", run.output)
        known = names.split(", ")
        self.assertEqual(given | {"reference_namespace", "engine_namespace"}, set(known))


class OwnNodes(LiveCase):
    """Nodes in Python, audited against the task."""

    deadline = MOST

    def setUp(self) -> None:
        super().setUp()
        master = shared_master()
        master.end_nodes()
        master.forget(keep=set())
        self.environment = environment_of(self, master.uri)

    def start_node(self, name: str, *arguments: str) -> Process:
        command = (node_file("sim2sim_eval", name), "__name:=engine", *arguments)
        return Process(self, *command, environment=self.environment)

    def audit(self, code: int, *arguments: str) -> str:
        """What an audit says on stderr."""
        command = (executable("sim2sim_eval", "audit_node"), "_against:=task", "_out:=audit.json")
        process = self.run_command(*command, *arguments, environment=self.environment)
        self.assertEqual(process.returncode, code, process.stdout + process.stderr)
        return process.stderr

    def audit_of_fault(self, fault: str, code: int, *arguments: str) -> Dict[str, Any]:
        self.start_node("faulty_simulator", f"_fault:={fault}")
        self.said = self.audit(code, *arguments)
        return load(self.folder / "audit.json")

    def assert_asked_besides(self, audit: Dict[str, Any]) -> None:
        """Before the fault, and after it."""
        for name, verdict in (("delay", "same"), ("pusher_radius", "same"), ("wall_up", "differs")):
            found = of(audit, name)
            self.assertEqual(found["verdict"], verdict, found.get("reason"))

    def test_the_example_keeps_the_contract(self) -> None:
        self.start_node("quasi_static_simulator")
        self.audit(0)
        audit = load(self.folder / "audit.json")
        self.assertEqual(audit["engine"], "quasi-static tee")
        self.assertTrue(audit["contract_holds"])

    def test_acts_late(self) -> None:
        self.assertEqual(first_finding(self.audit_of_fault("late", 5)), "delay")
        self.assertIn("audit: the contract is broken: acts 1 control step late", self.said)

    def test_mirrored_axis(self) -> None:
        self.assertEqual(first_finding(self.audit_of_fault("mirrored", 5)), "axes_mirror")

    def test_degrees_per_second(self) -> None:
        self.assertEqual(first_finding(self.audit_of_fault("degrees", 5)), "yaw_rate_factor")

    def test_answers_nan(self) -> None:
        audit = self.audit_of_fault("nan", 0)
        self.assertIn("left the finite numbers", of(audit, "servo_gain")["reason"])
        self.assert_asked_besides(audit)

    def test_refuses_a_start(self) -> None:
        audit = self.audit_of_fault("refuses", 0)
        reason = of(audit, "servo_gain")["reason"]
        self.assertRegex(reason, r"^reset: ValueError: too fast for me \(reset, line \d+\)$")
        self.assert_asked_besides(audit)

    def test_describes_itself_otherwise_each_time(self) -> None:
        self.start_node("faulty_simulator", "_fault:=other version")
        last = self.audit(3).splitlines()[-1]  # before it, that the node is waited for
        rule = r"must be in '.*', as it said before"
        self.assertRegex(last, rf"\Aaudit: /engine: is 'faulty' in version '.*': {rule}\Z")

    def test_describes_more_parameters_than_anyone_reads(self) -> None:
        self.start_node("faulty_simulator", "_fault:=many parameters")
        last = self.audit(3).splitlines()[-1]
        rule = "describes 100000 parameters: must be at most 1000"
        self.assertEqual(last, f"audit: /engine: {rule}")

    def assert_lost(self, audit: Dict[str, Any], reason: str) -> None:
        """Nothing was asked of the node after its loss, which every property says that is left."""
        self.assertEqual(of(audit, "delay")["verdict"], "same")
        later = {of(audit, key)["reason"] for key in ("servo_gain", "pusher_radius", "wall_up")}
        self.assertEqual(len(later), 1, later)
        self.assertRegex(later.pop(), f"^{reason}$")
        self.assertRegex(self.said, f"audit: {reason}\n$")

    def test_dies(self) -> None:
        audit = self.audit_of_fault("dies", 4, DEADLINE)
        self.assert_lost(audit, "/engine/step: the node has died or is out of reach")

    def test_hangs(self) -> None:
        audit = self.audit_of_fault("hangs", 4, DEADLINE)
        self.assert_lost(audit, "/engine/step: no answer within 2000 ms")

    def test_dies_and_comes_back(self) -> None:
        (self.folder / "mine.launch").write_text(
            '<launch><node name="engine" pkg="sim2sim_eval" type="faulty_simulator" respawn="true">'
            '<param name="fault" value="dies"/></node></launch>'
        )
        Process(self, "roslaunch", "mine.launch", environment=self.environment)
        self.said = self.audit(4, "_deadline:=20")
        audit = load(self.folder / "audit.json")
        self.assertIn("the node has died", of(audit, "servo_gain")["reason"])
        self.assert_asked_besides(audit)

    def test_interrupted(self) -> None:
        node = self.start_node("faulty_simulator", "_fault:=hangs")
        command = (executable("sim2sim_eval", "audit_node"), "_against:=task", "_out:=audit.json")
        process = Process(self, *command, DEADLINE, environment=self.environment)
        node.line("^hangs$")
        process.interrupt()
        self.assertEqual(process.ended(), 4)
        self.assertTrue(process.output.endswith("audit: interrupted\n"), process.output)
        self.assertFalse((self.folder / "audit.json").exists())

    def test_policy_in_place_of_a_simulator(self) -> None:
        self.start_node("python_policy")
        said = self.audit(2)
        self.assertIn("audit: /engine: is the policy 'by_hand', must be a simulator\n", said)

    def test_node_of_another_task(self) -> None:
        (self.folder / "other.py").write_text(
            "import rospy\nfrom pusht_msgs.srv import Control\nrospy.init_node('engine')\n"
            "rospy.Service('~describe', Control, lambda _: None)\nrospy.spin()\n"
        )
        Process(self, "/usr/bin/python3", "other.py", environment=self.environment)
        said = self.audit(2)
        self.assertRegex(said, r"audit: /engine/describe: .* is it a node of another task\?\n")

    def test_description_that_raises(self) -> None:
        (self.folder / "raises.py").write_text(
            "import rospy\nfrom pusht_msgs.srv import Describe\nrospy.init_node('engine')\n"
            "def describe(_): raise ValueError('no idea')\n"
            "rospy.Service('~describe', Describe, describe)\nrospy.spin()\n"
        )
        Process(self, "/usr/bin/python3", "raises.py", environment=self.environment)
        said = self.audit(3)
        self.assertRegex(said, r"no idea(.|\n)*\naudit: /engine/describe: .* answers with an error")
        self.assertLess(said.count("\n"), 25, said)

    def test_one_node_in_both_roles(self) -> None:
        self.start_node("quasi_static_simulator")
        said = self.audit(2, "_against:=none", "_reference_namespace:=engine")
        self.assertIn("audit: /engine and /engine are one node", said)

    def test_refused(self) -> None:
        (self.folder / "mine.json").write_text("mine")
        for argument, reason in (
            ("_against:=nature", "against 'nature': must be task, or left out"),
            ("_reference:=mujoco", "reference, reference_parameters: must be left out with"),
            ("_out:=mine.json", "out mine.json: is there already; name a new file"),
            ("_engine_parameters:=x", "engine_parameters 'x': must be NAME=VALUE"),
            ("_seed:=-1", "seed -1: must be an integer from 0"),
            ("_deadline:=0", "deadline 0: must be finite and > 0"),
            (f"_task:={BIG_TEE}", "task big_tee: must have a tee no larger than full_circle's"),
            ("_task:=pusht", "task 'pusht': must be one of: full_circle, gym_pusht; or a file"),
        ):
            with self.subTest(argument):
                shared_master().forget(keep=set())
                said = self.audit(2, argument)
                self.assertEqual(said.count("\n"), 1, said)
                self.assertIn(reason, said)


if __name__ == "__main__":
    unittest.main()
