#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""audit_policy() in Python: the command's words, callables, arrays."""

import subprocess
import tempfile
import unittest
from pathlib import Path
from typing import Any, List, Tuple

import numpy as np
import sim2sim
from catkin.find_in_workspaces import find_in_workspaces  # type: ignore[import]
from numpy.typing import NDArray

Rows = NDArray[np.float32]


def command(name: str) -> str:
    """A command of sim2sim_eval."""
    found: str = find_in_workspaces(["libexec"], "sim2sim_eval", name, first_match_only=True)[0]
    return found


def steer(observations: Rows) -> Rows:
    """From the pusher to beside the tee."""
    return np.clip(5.0 * (observations[:, 2:4] - observations[:, 0:2] + [0.05, 0.02]), -1.0, 1.0)


def late(observations: Rows) -> Rows:
    """By the older one of two observations."""
    return steer(observations[:, 0])


class Steering:
    """A policy with a memory, which it has no use for."""

    def begin(self, seed: int) -> List[int]:
        return []

    def act(self, observations: Rows, memories: List[List[int]]) -> Rows:
        return np.repeat(-steer(observations)[:, None, :], 2, axis=1)


def demonstrations() -> List[Tuple[Rows, Rows]]:
    """Episodes of a pusher that steers, with a tee that is moved at random."""
    generator = np.random.default_rng(0)
    episodes = []
    for _ in range(40):
        observations = np.zeros((30, 10), np.float32)
        pusher, tee = generator.uniform(-0.3, 0.3, (2, 2))
        for row in observations:
            yaw = generator.uniform(-3.0, 3.0)
            row[:] = [*pusher, *tee, np.sin(yaw), np.cos(yaw), 0.0, 0.0, 0.0, 1.0]
            pusher = pusher + 0.1 * steer(row[None])[0]
            tee = np.clip(tee + generator.normal(0.0, 0.05, 2), -0.3, 0.3)
        episodes.append((observations, steer(observations).astype(np.float32)))
    return episodes


class Audits(unittest.TestCase):
    episodes = demonstrations()

    def test_a_callable(self) -> None:
        self.assertEqual(sim2sim.audit_policy(steer, self.episodes).fault, "")
        audit = sim2sim.audit_policy(late, self.episodes, history=2)
        self.assertIn("actions 1 step earlier", audit.fault)
        self.assertIn(audit.fault, str(audit).splitlines()[0])
        self.assertEqual(audit.summary["verdict"], "fault")

    def test_chunks_of_an_object_with_memories(self) -> None:
        audit = sim2sim.audit_policy(Steering(), self.episodes)
        self.assertIn("the other sign of actions", str(audit))
        self.assertEqual(audit.summary["verdict"], "fault")

    def test_a_file_with_the_words_of_the_command(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            bag = str(Path(folder) / "held.bag")
            recording = ("--seed", "20000", "--episodes", "30", "--out", bag)
            subprocess.run([command("demonstrate"), *recording], check=True, capture_output=True)
            asked = [command("audit"), "--policy", "expert", "--demonstrations", bag]
            process = subprocess.run(asked, check=True, capture_output=True, text=True)
            self.assertEqual(sim2sim.audit_policy("expert", bag).text, process.stdout)
            loaded = sim2sim.audit_policy(sim2sim.load_policy("expert"), bag)
            self.assertEqual(loaded.summary["error"]["mean"], 0.0)

    def test_refusals(self) -> None:
        one = self.episodes[0]
        refused: List[Tuple[Any, Any, str]] = [
            (steer, self.episodes[:3], "must be at least 30"),
            (steer, [], "0 episodes"),
            (steer, [(one[0], one[1][:-1])], "30 observations and 29 actions"),
            (steer, [(one[0][:, :9], one[1])], r"must be \(n, 10\)"),
            (steer, [(one[0] * np.nan, one[1])], "row 0: all numbers must be finite"),
            (steer, "missing.csv", "missing.csv"),
            (3, self.episodes, "policy 3: must be a name"),
        ]
        for policy, episodes, message in refused:
            with self.subTest(message):
                with self.assertRaisesRegex(sim2sim.InvalidInput, message):
                    sim2sim.audit_policy(policy, episodes)
        with self.assertRaisesRegex(sim2sim.InvalidInput, "history 2: must be left out"):
            sim2sim.audit_policy("expert", self.episodes, history=2)
        with self.assertRaisesRegex(sim2sim.BadDependency, "must be finite"):
            sim2sim.audit_policy(lambda rows: rows[:, :2] * np.float32("nan"), self.episodes)

    def test_what_the_callable_raises(self) -> None:
        with self.assertRaises(ZeroDivisionError):
            sim2sim.audit_policy(lambda rows: 1 / 0, self.episodes)


if __name__ == "__main__":
    unittest.main()
