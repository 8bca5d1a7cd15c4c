#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Simulators that are classes of a program, in compare(). live_batch.py tests beside nodes that the
results are those of the same class served as one."""

import json
import os
import tempfile
import threading
import unittest
from dataclasses import replace
from pathlib import Path
from typing import Any, Dict, List

import numpy as np
import sim2sim
from numpy.typing import NDArray
from pusht_task.task import ACTION_LIMITS, WorldState

SHORT: Dict[str, Any] = {"episodes": 3, "horizon": 12, "floor": False}


class Floating:
    """A tee that nothing moves, under a pusher without walls."""

    made = 0
    threads: List[int] = []

    def __init__(self, pace: float = 1.0, fault: str = "none", deep: bool = False) -> None:
        if pace <= 0.0:
            raise ValueError(f"pace {pace}: must be above 0")
        type(self).made += 1
        self.pace = pace
        self.fault = fault

    def reset(self, start: WorldState) -> Any:
        self.threads.append(threading.get_ident())
        self.steps = 0
        self.state = start
        return replace(start, tee_x=start.tee_x + 0.01) if self.fault == "elsewhere" else start

    def step(self, action: NDArray[np.float64]) -> Any:
        assert action.shape == (2,) and action.dtype == np.float64
        self.steps += 1
        if self.steps == 4 and self.fault == "raises":
            raise KeyError("no such place")
        if self.steps == 4 and self.fault == "tuple":
            return 1.0, 2.0
        if self.steps == 4 and self.fault == "text":
            return replace(self.state, tee_yaw="north")
        if self.steps == 4 and self.fault == "nan":
            return replace(self.state, tee_x=float("nan"))
        vx, vy = (self.pace * action).tolist()
        pusher = (self.state.pusher_x + 0.1 * vx, self.state.pusher_y + 0.1 * vy)
        self.state = replace(
            self.state, pusher_x=pusher[0], pusher_y=pusher[1], pusher_vx=vx, pusher_vy=vy
        )
        return self.state


class InTasks:
    """A tee and a pusher that nothing moves, in any task; keeps tasks and actions."""

    tasks: List[str] = []
    actions: List[List[float]] = []

    def __init__(self, task: str = "gym_pusht") -> None:
        self.tasks.append(task)

    def reset(self, start: WorldState) -> WorldState:
        self.state = start
        return start

    def step(self, action: NDArray[np.float64]) -> WorldState:
        self.actions.append(action.tolist())
        return self.state


class Simulators(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(folder.name)
        Floating.made = 0
        Floating.threads = []

    def test_a_class_in_each_role(self) -> None:
        both = sim2sim.compare("expert", reference=Floating, engine=Floating, **SHORT)
        self.assertEqual(both.summary["engine_simulator"], "Floating")
        replays = np.asarray(both.episodes["mode"]) == "engine_replay"
        self.assertEqual(both.episodes["mean_position_divergence_m"][replays].tolist(), [0.0] * 3)
        self.assertEqual(set(Floating.threads), {threading.get_ident()})
        other = sim2sim.compare(
            "expert", reference="two_mass", engine=Floating, engine_parameters={"pace": 2}, **SHORT
        )
        self.assertEqual(other.summary["knobs"], {"pace": 2.0, "fault": "none", "deep": False})
        self.assertEqual(other.provenance["code"]["python:Floating"]["version"], "")

    def test_each_world_is_an_object_whatever_the_threads(self) -> None:
        one = sim2sim.compare("expert", reference="two_mass", engine=Floating, **SHORT)
        self.assertEqual(Floating.made, 1 + 2 * 3)  # a first look; two modes, three episodes
        two = sim2sim.compare("expert", reference="two_mass", engine=Floating, threads=2, **SHORT)
        self.assertEqual(one.summary, two.summary)

    def test_faults(self) -> None:
        at = r"episode 0 .*engine_closed, step 3: python:Floating: "
        for fault, kind, words in (
            ("raises", KeyError, "no such place"),
            ("tuple", sim2sim.BadDependency, f"{at}step returned tuple: must be a .*WorldState"),
            ("text", sim2sim.BadDependency, f"{at}step returned tee_yaw 'north': must be a number"),
            ("nan", sim2sim.SimulationFault, f"{at}step returned tee_x nan: must be finite"),
            (
                "elsewhere",
                sim2sim.SimulationFault,
                "engine_closed, step 0: python:Floating: .*tee_x",
            ),
        ):
            with self.subTest(fault), self.assertRaisesRegex(kind, words):
                sim2sim.compare(
                    "expert",
                    reference="two_mass",
                    engine=Floating,
                    engine_parameters={"fault": fault},
                    **SHORT,
                )
        sim2sim.compare("expert", reference="two_mass", engine=Floating, **SHORT)  # works again

    def test_refused(self) -> None:
        def needs(friction: float) -> Floating:
            return Floating(friction)

        def refused(words: str, error: Any = sim2sim.InvalidInput, **named: Any) -> None:
            with self.subTest(words), self.assertRaisesRegex(error, words):
                asked: Dict[str, Any] = {"reference": "two_mass", **SHORT, **named}
                sim2sim.compare("expert", **asked)

        refused("engine 3: must be a name, a class with reset", engine=3)
        refused("parameter friction: must have a default", engine=needs)
        refused(
            "parameter 'deeper': unknown; known: pace, fault, deep",
            engine=Floating,
            engine_parameters={"deeper": 1},
        )
        refused("pace", engine=Floating, engine_parameters={"pace": "fast"})
        refused("pace -1.0: must be", ValueError, engine=Floating, engine_parameters={"pace": -1})
        refused(
            "engine Floating: must not have the name of another",
            reference=Floating,
            engine=sim2sim.worlds(Floating, version="2"),
        )
        refused(
            "reference_cache kept: must be left out: python:Floating does not say its version",
            reference=Floating,
            engine="two_mass",
            reference_cache="kept",
        )
        with self.assertRaisesRegex(sim2sim.InvalidInput, "name 'a b': must be a word"):
            sim2sim.worlds(Floating, name="a b")

    def test_a_class_holds_tasks(self) -> None:
        """It gets the actions of each, clipped as by nodes in Python."""

        def far(observations: NDArray[np.float32]) -> NDArray[np.float32]:
            return np.full((len(observations), 2), (300.0, -300.0), np.float32)

        with self.assertRaisesRegex(sim2sim.InvalidInput, "task 'none': must be one of") as refusal:
            sim2sim.compare(far, task="none", **SHORT)
        self.assertIn(", ".join(ACTION_LIMITS) + ";", str(refusal.exception))
        for task, limit in ACTION_LIMITS.items():
            with self.subTest(task):
                InTasks.tasks, InTasks.actions = [], []
                named: Dict[str, Any] = {"task": task, "reference": InTasks, "engine": "none"}
                found = sim2sim.compare(far, **named, **SHORT)
                self.assertEqual(set(InTasks.tasks), {task})
                reach = 300.0 if limit is None else limit
                self.assertEqual(InTasks.actions, [[reach, -reach]] * 36)
                self.assertNotIn("task", found.provenance["reference"])
        with self.assertRaisesRegex(sim2sim.InvalidInput, "task gym_pusht: the kind Floating"):
            sim2sim.compare(far, task="gym_pusht", reference=Floating, engine="none", **SHORT)
        with self.assertRaisesRegex(sim2sim.InvalidInput, "task 3: must be a text"):
            sim2sim.worlds(InTasks, parameters={"task": 3})

    def test_a_version_lets_a_run_go_on(self) -> None:
        for version, goes_on in (("1", True), ("", False)):
            out = f"mine{version}"
            broken = sim2sim.worlds(Floating, version=version)

            def run(policy: Any) -> None:
                named: Dict[str, Any] = {**SHORT, "episodes": 20, "out": out, "version": "1"}
                sim2sim.compare(policy, reference="two_mass", engine=broken, **named)

            calls = []

            def stops(observations: NDArray[np.float32]) -> NDArray[np.float32]:
                calls.append(len(observations))
                if len(calls) == 3 + 20:  # after the trials, in the second episode
                    raise RuntimeError("enough")
                return np.zeros((len(observations), 2), np.float32)

            with self.assertRaises(RuntimeError):
                run(stops)
            status = json.loads(Path(out, "status.json").read_text())
            self.assertEqual(status["exit_code"], 4)
            if goes_on:
                run(stops)
                self.assertTrue(Path(out, "metrics.json").is_file())
            else:
                with self.assertRaises(sim2sim.Error):
                    run(stops)


if __name__ == "__main__":
    unittest.main()
