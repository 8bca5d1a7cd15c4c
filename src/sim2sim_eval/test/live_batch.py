#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Commands that ask for a simulator by its node: `node:/engine`."""

import csv
import signal
import subprocess
import sys
import unittest
from pathlib import Path
from runpy import run_path
from typing import Dict, List, Sequence

import sim2sim

from command_case import executable
from launch_support import environment_of, node_file, shared_master
from live_support import LiveCase, Process, describe, free_port, kill

ATTRIBUTE = executable("sim2sim_eval", "attribute")
AUDIT = executable("sim2sim_eval", "audit")
COMPARE = executable("sim2sim_eval", "compare")
SWEEP = executable("sim2sim_eval", "sweep")
EXAMPLE = Path(__file__).resolve().parents[1] / "examples" / "quasi_static_simulator"
SHORT = ("--policy", "expert", "--episodes", "3", "--horizon", "40")
GYM_TEE = str(Path(__file__).with_name("gym_simulator"))
IN_PIXELS = ("--task", "gym_pusht", *SHORT)
MORTAL = str(Path(__file__).with_name("mortal_simulator"))
SEES = """
import sys
import numpy as np
import sim2sim

def to_a_corner(states):
    seen.append(states)
    return np.tile(np.float32([40.0, 50.0]), (len(states), 1))

seen = []
sim2sim.compare(
    to_a_corner, task="gym_pusht", reference=sys.argv[1], engine="none", obs_type="state",
    episodes=2, horizon=20,
)
rows = np.unique(np.concatenate(seen), axis=0)
pushers = rows[:, :2]
in_meters = (pushers - 256.0) / 1000.0
print(np.sum(in_meters * 1000.0 + 256.0 != pushers), rows.tobytes().hex())
"""
PLAN = """
policy: expert
episodes: 3
horizon: 40
reference: two_mass
engine: node:/engine
"""
SWITCHES = PLAN + "grid: {long: [false, true], slow: [false, true]}"
LOSSES = PLAN + "rows: [{long: false}, {fails: true}, {long: true}]"


class Served(LiveCase):
    def setUp(self) -> None:
        super().setUp()
        master = shared_master()
        master.end_nodes()
        master.forget(keep=set())
        self.environment = environment_of(self, master.uri)

    def start_node(
        self, command: str, name: str = "engine", version: str = "1", arguments: Sequence[str] = ()
    ) -> Process:
        environment = {**self.environment, "VERSION": version}
        node = Process(self, command, f"__name:={name}", *arguments, environment=environment)
        self.addCleanup(kill, node.pid, signal.SIGKILL)  # at an interrupt it takes up to a second
        describe(name)  # it is there
        return node

    def command(self, *command: str) -> "subprocess.CompletedProcess[str]":
        return self.run_command(*command, environment=self.environment)

    def refused(self, code: int, *command: str) -> str:
        """The last line on stderr; before it, that a node is waited for."""
        process = self.command(*command)
        self.assertEqual(process.returncode, code, process.stdout + process.stderr)
        return process.stderr.splitlines()[-1]

    def sweep(self, plan: str, out: str, *arguments: str) -> "subprocess.CompletedProcess[str]":
        path = self.write("plan.yaml", plan.encode())
        return self.command(SWEEP, path, "--out", out, *arguments)

    def rows(self, out: str) -> List[Dict[str, str]]:
        with (self.folder / out / "sweep.csv").open(newline="") as table:
            return list(csv.DictReader(table))


class Bytes(Served):
    def test_are_those_of_the_kind_that_the_nodes_serve(self) -> None:
        self.start_node(node_file("pusht_engine", "engine_node"))
        self.start_node(node_file("pusht_engine", "engine_node"), "reference")
        setting = ("--set", "block_damp=20", "--reanchor=5")
        here = ("--reference", "two_mass", "--engine", "two_mass")
        there = ("--reference", "node:/reference", "--engine", "node:/engine")
        self.succeed(COMPARE, *SHORT, *setting, *here, "--out", "here")
        self.succeed(
            COMPARE, *SHORT, *setting, *there, "--out", "there", environment=self.environment
        )
        self.assert_same_results("here", "there")
        origin = self.load("there", "provenance.json")
        self.assertEqual(origin["engine"]["node"], "/engine")
        self.assertEqual(origin["code"]["node:/engine"]["simulator"], "two_mass")

    def test_in_process_are_those_of_the_class_as_a_node(self) -> None:
        self.start_node(str(EXAMPLE))
        parameters = {"characteristic_length": 0.05}
        options = (*SHORT, "--reference", "two_mass", "--engine", "node:/engine", "--reanchor=5")
        setting = ("--set", "characteristic_length=0.05", "--out", str(self.folder / "served"))
        self.succeed(COMPARE, *options, *setting, environment=self.environment)
        tee = sim2sim.worlds(
            run_path(str(EXAMPLE))["QuasiStaticTee"],
            name="quasi_static",
            version="2",
            title="quasi-static tee",
            parameters={"characteristic_length": 0.04},
        )
        sim2sim.compare(
            "expert",
            reference="two_mass",
            engine=tee,
            engine_parameters=parameters,
            episodes=3,
            horizon=40,
            reanchor=[5],
            out=str(self.folder / "in_process"),
        )
        self.assert_same_results("in_process", "served")

    def test_in_another_task_of_a_kind(self) -> None:
        """A number of the task has full_circle's value; then the node is asked for the course's."""
        for role, kind in (("reference", "gym_pusht"), ("engine", "mujoco")):
            command = node_file("sim2sim_eval", "simulator_node")
            self.start_node(command, role, arguments=[f"_kind:={kind}"])
        setting = ("--set", "tee_body_mass=0.105", "--reanchor=5")
        here = ("--reference", "gym_pusht", "--engine", "mujoco", *setting)
        there = ("--reference", "node:/reference", "--engine", "node:/engine", *setting)
        self.succeed(COMPARE, *IN_PIXELS, *here, "--out", "here")
        self.succeed(COMPARE, *IN_PIXELS, *there, "--out", "there", environment=self.environment)
        self.assert_same_results("here", "there")
        record = self.load("there", "metrics.json")["knobs"]
        self.assertEqual(record["tee_body_mass"], 0.105)
        alone = (COMPARE, *SHORT, "--reference", "rigid_body", "--engine")
        self.succeed(*alone, "mujoco", "--out", "course")
        self.succeed(*alone, "node:/engine", "--out", "again", environment=self.environment)
        self.assert_same_results("course", "again")
        words = "task full_circle: the kind gym_pusht holds only gym_pusht"
        refused = self.refused(2, *alone[:-1], "--engine", "node:/reference")
        self.assertIn(words, refused)

    def test_what_a_callable_sees_in_pixels(self) -> None:
        """The node's own bits, which are lost in meters and back near the window's corner."""
        self.start_node(node_file("sim2sim_eval", "simulator_node"), arguments=["_kind:=gym_pusht"])
        here = self.succeed(sys.executable, "-c", SEES, "gym_pusht")
        there = self.succeed(
            sys.executable, "-c", SEES, "node:/engine", environment=self.environment
        )
        self.assertEqual(there, here)
        self.assertGreater(int(here.split()[0]), 20, "numbers that a state has not")

    def test_in_another_task_of_a_class(self) -> None:
        """In process, and as a node."""
        self.start_node(GYM_TEE)
        options = (*IN_PIXELS, "--reference", "gym_pusht", "--engine", "node:/engine")
        self.succeed(COMPARE, *options, "--out", "served", environment=self.environment)
        sim2sim.compare(
            "expert",
            task="gym_pusht",
            reference="gym_pusht",
            engine=sim2sim.worlds(run_path(GYM_TEE)["GymTee"], name="gym_tee", version="1"),
            episodes=3,
            horizon=40,
            out=str(self.folder / "in_process"),
        )
        self.assert_same_results("in_process", "served")
        replays = [row for row in self.episodes("served") if row["mode"] == "engine_replay"]
        moved = [
            row["mean_position_divergence_m"] != row["null_position_divergence_m"]
            for row in replays
        ]
        self.assertTrue(any(moved), "no tee has moved")

    def assert_same_results(self, one: str, other: str) -> None:
        for name in ("metrics.json", "statistics.json", "episodes.csv", "divergence.csv"):
            expected = (self.folder / one / name).read_bytes()
            self.assertEqual((self.folder / other / name).read_bytes(), expected, name)

    def episodes(self, out: str) -> List[Dict[str, str]]:
        with (self.folder / out / "episodes.csv").open(newline="") as table:
            return list(csv.DictReader(table))


class Sweeps(Served):
    def test_the_example_is_swept(self) -> None:
        self.start_node(str(EXAMPLE))
        process = self.sweep(PLAN + "grid: {characteristic_length: [0.03, 0.06]}", "lengths")
        self.assertEqual(process.returncode, 0, process.stderr)
        self.assertEqual(
            [row["characteristic_length"] for row in self.rows("lengths")], ["0.03", "0.06"]
        )
        ends = {row["engine_replay_final_position_error_m"] for row in self.rows("lengths")}
        self.assertEqual(len(ends), 2, "the parameter changes nothing")
        code = self.load("lengths", "provenance.json")["code"]["node:/engine"]
        self.assertEqual((code["simulator"], code["version"]), ("quasi_static", "2"))

    def test_switches_are_attributed(self) -> None:
        self.start_node(MORTAL)
        self.assertEqual(self.sweep(SWITCHES, "switches").returncode, 0)
        self.assertIn("slow", self.command(ATTRIBUTE, "switches").stdout)
        self.assertIn("attribution.json", self.files("switches"))

    def test_f58_a_node_that_dies_costs_its_row(self) -> None:
        failure = self.folder / "failure"
        failure.write_text("dies")
        node = self.start_node(MORTAL)
        path = self.write("plan.yaml", LOSSES.encode())
        sweep = Process(self, SWEEP, path, "--out", "losses", environment=self.environment)
        self.assertEqual(node.ended(), 1)
        again = self.start_node(MORTAL)  # the sweep waits for it
        self.assertEqual(sweep.ended(), 4, sweep.output)
        lost = (
            r"1 of 3 rows failed, first row 1 \(.*fails true\): episode 0 .*engine_closed, step 9"
        )
        self.assertRegex(sweep.output, rf"sweep: {lost}.*/engine/step: the node has died")
        status = self.load("losses", "status.json")
        self.assertEqual((status["exit_code"], status["rows_finished"]), (4, 2))
        failure.unlink()
        kept = (self.folder / "losses" / "rows" / "000" / "metrics.json").stat().st_ino
        process = self.sweep(LOSSES, "losses")
        self.assertEqual(process.returncode, 0, process.stderr)
        self.assertEqual(
            (self.folder / "losses" / "rows" / "000" / "metrics.json").stat().st_ino, kept
        )
        self.assertEqual(self.sweep(LOSSES, "at_once").returncode, 0)
        self.assertEqual(self.rows("losses"), self.rows("at_once"))
        kill(again.pid, signal.SIGKILL)
        again.ended()
        self.start_node(MORTAL, version="2")
        said = self.refused(2, SWEEP, path, "--out", "losses")
        self.assertIn('holds another sweep (/code/node:~1engine/version is "1", must be "2")', said)

    def test_f58_a_node_that_comes_back_as_another(self) -> None:
        (self.folder / "failure").write_text("dies")
        node = self.start_node(MORTAL)
        path = self.write("plan.yaml", LOSSES.encode())
        sweep = Process(self, SWEEP, path, "--out", "losses", environment=self.environment)
        self.assertEqual(node.ended(), 1)
        self.start_node(MORTAL, version="2")
        self.assertEqual(sweep.ended(), 3, sweep.output)
        said = '): /engine: has the version "2": must have "1", as it said before\n'
        self.assertTrue(sweep.output.endswith(said), sweep.output)

    def test_f58_a_node_that_raises_or_hangs_costs_its_row(self) -> None:
        self.start_node(MORTAL)
        for failure, lost in (
            ("raises", r"/engine: step: RuntimeError: lost my way \(step, line \d+\)"),
            ("hangs", "/engine/step: no answer within 500 ms"),
        ):
            (self.folder / "failure").write_text(failure)
            process = self.sweep(LOSSES, failure, "--deadline", "0.5", "--patience", "0.5")
            self.assertEqual(process.returncode, 4)
            self.assertRegex(process.stderr, rf"of 3 rows failed, first row 1 .*{lost}")


class Faults(Served):
    def test_f58_a_node_that_is_not_there(self) -> None:
        missing = ("--engine", "node:/engine", "--patience", "0.3", "--out", "missing")
        said = self.refused(4, COMPARE, *SHORT, *missing)
        self.assertEqual(said, "compare: /engine/describe: no node answers within 300 ms")
        self.assertFalse((self.folder / "missing").exists())

    def test_f58_no_master(self) -> None:
        uri = f"http://127.0.0.1:{free_port()}"
        self.environment["ROS_MASTER_URI"] = uri
        process = self.sweep(SWITCHES, "none")
        self.assertEqual(process.returncode, 4)
        self.assertIn(f"no ROS master at {uri}: start roscore", process.stderr)
        self.assertFalse((self.folder / "none").exists())

    def test_f58_refused(self) -> None:
        self.start_node(MORTAL)
        self.start_node(node_file("sim2sim_eval", "python_policy"), "policy")
        compare = (COMPARE, *SHORT, "--out", "refused", "--engine")
        plan = self.write("plan.yaml", (PLAN + "rows: [{slow: true, fails: true}]").encode())
        for command, reason in (
            ((*compare, "node:engine"), "simulator 'node:engine': must be node:/NAME"),
            ((*compare, "node:/policy"), "/policy: is the policy 'by_hand', must be a simulator"),
            (
                (*compare, "node:/engine", "--task", "gym_pusht", "--reference", "gym_pusht"),
                "/engine: parameter task: unknown; known:",
            ),
            (
                (*compare, "node:/engine", "--set", "deep=1"),
                "parameter 'deep': unknown; known: long, slow",
            ),
            (
                (*compare, "node:/engine", "--reference", "node:/engine"),
                "simulator node:/engine: must not be in two roles",
            ),
            (
                (*compare, "two_mass", "--reference", "node:/engine", "--model-variants=long=true"),
                "model variants: must be left out: the reference node:/engine is a node",
            ),
            (
                (AUDIT, "--engine", "node:/engine", "--against", "task"),
                "simulator node:/engine: must be a kind: audit.launch audits nodes",
            ),
            (
                (SWEEP, plan, "--out", "refused"),
                f"sweep {plan}: line 7: /engine: slow true: must be false with fails",
            ),
        ):
            with self.subTest(reason):
                self.assertIn(reason, self.refused(2, *command))
                self.assertFalse((self.folder / "refused").exists())


if __name__ == "__main__":
    unittest.main()
