#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Runs that others disturb: each has the undisturbed bytes, or says that it failed.

Some are disturbed at a chosen moment, others at random ones; the long form has more. By hand:
rostest --text sim2sim_eval live_interference.test runs:=300 seed:=1
"""

import random
import shutil
import threading
import time
from collections import Counter
from pathlib import Path
from typing import Any, Dict, Tuple

import actionlib  # type: ignore[import]
import rospy  # type: ignore[import]
from actionlib_msgs.msg import GoalStatus  # type: ignore[import]
from pusht_msgs.msg import CompareAction, Parameter  # type: ignore[import]
from pusht_msgs.srv import Configure, Reset, Step  # type: ignore[import]
from pusht_testing.long_tests import LONG
from pusht_testing.nodes import run

from command_case import executable
from live_support import (
    DEADLINE,
    UNFINISHED,
    GoalCase,
    files,
    goal_of,
    result_bytes,
    rows,
    status_of,
)

WORLDS = ("reference", "engine", "engine_replay")
MODES = ("reference_closed", "engine_closed")
EPISODES = 4
BATCH = ("--policy", "expert", "--episodes", str(EPISODES))
OURS, OTHERS = "6.0", "60.0"  # block_damp [1/s]
DAMPED = [Parameter("block_damp", OURS)]


class Stranger:
    """Calls the services of the worlds by hand."""

    def __init__(self, chance: random.Random) -> None:
        self.chance = chance
        self.served: "Counter[str]" = Counter()  # requests that were not refused

    def call(self, world: str, name: str, service: Any, **fields: Any) -> None:
        answer = rospy.ServiceProxy(f"/{world}/{name}", service)(**fields)
        self.served[name] += answer.success

    def configure(self, world: str) -> None:
        parameters = [] if world == "reference" else [Parameter("block_damp", OTHERS)]
        self.call(world, "configure", Configure, parameters=parameters, end_episode=True)

    def step(self, world: str) -> None:
        action = (self.chance.uniform(-1, 1), self.chance.uniform(-1, 1))
        index = self.chance.choice([-1, -1, 0, self.chance.randrange(100)])
        self.call(world, "step", Step, step=index, action=action)

    def reset(self, world: str) -> None:
        self.call(world, "reset", Reset, seed=self.chance.randrange(100))
        if self.chance.random() < 0.5:
            self.chance.choice([self.configure, self.step])(world)


class LiveInterference(GoalCase):
    duration: float  # [s] of an undisturbed run
    expected: Dict[str, bytes]  # by block_damp
    rival: Any  # a second evaluator

    @classmethod
    def setUpClass(cls) -> None:
        super().setUpClass()
        cls.rival = actionlib.SimpleActionClient("/rival/compare", CompareAction)
        if not cls.rival.wait_for_server(rospy.Duration(DEADLINE)):
            raise TimeoutError("/rival/compare: no action server")

    def test_exit_code_0_only_with_the_undisturbed_bytes(self) -> None:
        runs = rospy.get_param("~runs", 0) or (12 if LONG else 4)  # each kind once
        seed = rospy.get_param("~seed", 0)
        self.expected = {
            damping: self.batch_bytes(*BATCH, "--block_damp", damping) for damping in (OURS, OTHERS)
        }
        begin = time.monotonic()
        self.begin(self.client, self.folder / "undisturbed", OURS)
        self.assertEqual(self.end(self.client, self.folder / "undisturbed", OURS), 0)
        self.duration = time.monotonic() - begin

        codes: "Counter[Tuple[str, int]]" = Counter()
        served: "Counter[str]" = Counter()
        kinds = ("configure", "step", "reset", "rival")
        for index in range(runs):
            kind = kinds[index % len(kinds)]
            with self.subTest(index=index, kind=kind, seed=seed):
                chance = random.Random(f"{seed}/{index}")
                stranger = Stranger(chance)
                code = self.disturbed_run(chance, kind, stranger)
                codes[kind, code] += 1
                served += stranger.served
        print(f"disturbed runs by (kind, exit code): {dict(codes)}; served: {dict(served)}")
        self.assertEqual(sum(codes.values()), runs)

    def test_world_that_a_stranger_resets_ends_the_run(self) -> None:
        for world in WORLDS:
            with self.subTest(world):
                self.out = self.folder / world
                self.send_and_hold(0, 5, episodes=EPISODES, engine_parameters=DAMPED)
                Stranger(random.Random(0)).call(world, "reset", Reset, seed=1)
                self.assert_ended_by(f"/{world}: the world was reset by another caller")

    def test_world_that_a_stranger_configures_after_its_last_step_ends_the_run(self) -> None:
        """No step can see that: the world is asked now and then, and at the end of the episode."""
        batch = self.folder / "batch"
        self.succeed(executable("sim2sim_eval", "compare"), *BATCH, "--out", str(batch))
        steps = {(int(row["episode"]), row["mode"]): int(row["steps"]) for row in rows(batch)}
        episode = next(i for i in range(EPISODES) if len({steps[i, mode] for mode in MODES}) > 1)
        first = min(MODES, key=lambda mode: steps[episode, mode])  # its world rests then
        world = "engine_replay" if first == "reference_closed" else "engine"
        wanted = {"first_episode": episode, "episodes": 1, "engine_parameters": DAMPED}
        self.send_and_hold(episode, steps[episode, first] + 1, **wanted)
        stranger = Stranger(random.Random(0))
        stranger.call(world, "reset", Reset, seed=1)
        stranger.configure(world)
        self.assertEqual(stranger.served, {"reset": 1, "configure": 1})
        self.assert_ended_by(f"/{world}: .*another caller has configured the world")

    def assert_ended_by(self, reason: str) -> None:
        self.accepted("resume")
        result = self.result(GoalStatus.ABORTED)
        self.assertEqual(result.exit_code, 4)
        self.assert_not_whole(self.out, reason)

    def disturbed_run(self, chance: random.Random, kind: str, stranger: Stranger) -> int:
        """Begins a run and disturbs it at a random moment; its exit code."""
        out, others = self.folder / "disturbed", self.folder / "others"
        self.begin(self.client, out, OURS)
        # The moment, which may be any: this waits for nothing.
        threading.Event().wait(chance.uniform(0.0, self.duration))
        if kind == "rival":
            damping = chance.choice([OURS, OTHERS])
            self.begin(self.rival, others, damping)
            self.end(self.rival, others, damping)
        else:
            for _ in range(chance.randint(1, 3)):
                getattr(stranger, kind)(chance.choice(WORLDS))
        return self.end(self.client, out, OURS)

    def begin(self, client: Any, out: Path, damping: str) -> None:
        shutil.rmtree(out, ignore_errors=True)
        parameters = [Parameter("block_damp", damping)]
        client.send_goal(
            goal_of(out=str(out), episodes=EPISODES, engine_parameters=parameters, record=False)
        )

    def end(self, client: Any, out: Path, damping: str) -> int:
        """The exit code of a run, which must tell the truth."""
        self.assertTrue(client.wait_for_result(rospy.Duration(DEADLINE)))
        result = client.get_result()
        status = status_of(out)
        self.assertEqual((status["exit_code"], status["reason"]), (result.exit_code, result.reason))
        if result.exit_code == 0:
            self.assertEqual(result_bytes(out), self.expected[damping])
            return 0
        self.assertEqual(result.exit_code, 4, result.reason)
        self.assertRegex(result.reason, r"^[^\n]*/(reference|engine|engine_replay)\b[^\n]*$")
        self.assertLessEqual(files(out), UNFINISHED)
        return 4


run(LiveInterference)
