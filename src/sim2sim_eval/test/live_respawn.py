#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Nodes that are lost and come back: the run is the one that nothing has disturbed."""

import os
import signal
import time

from actionlib_msgs.msg import GoalStatus  # type: ignore[import]
from pusht_task.testing import run
from rosgraph_msgs.msg import Log  # type: ignore[import]

from live_support import GoalCase, Topic, connections, kill, pid_of, result_bytes, status_of, until

EPISODES = 3
BATCH = ("--policy", "expert", "--episodes", str(EPISODES))


class LiveRespawn(GoalCase):
    log: Topic

    @classmethod
    def setUpClass(cls) -> None:
        super().setUpClass()
        cls.log = Topic("/rosout", Log)
        until(lambda: connections("/sim2sim", "/rosout") > 0, "the evaluator's log")

    def under_way(self) -> None:
        self.send(episodes=EPISODES, rate=300.0)
        self.feedback_of(1, 10)

    def assert_survived(self, faults: int) -> None:
        result = self.result()
        self.assertEqual((result.exit_code, result.faults_survived), (0, faults))
        self.assertEqual(status_of(self.out)["faults_survived"], faults)
        self.assertEqual(result_bytes(self.out), self.batch_bytes(*BATCH))
        self.assert_recomputed(self.out)

    def test_f13_killed_node(self) -> None:
        for node in ("engine", "engine_replay", "mujoco", "policy"):
            with self.subTest(node):
                self.out = self.folder / node
                self.under_way()
                since = time.monotonic()
                os.kill(pid_of(f"/{node}"), signal.SIGKILL)
                warning = self.log.until(lambda m: "is void and begins again" in m.msg)[-1]
                self.assertLess(time.monotonic() - since, 1.0)
                self.assertIn(f"/{node}/", warning.msg)
                self.assert_survived(1)

    def test_f13_two_nodes_one_after_the_other(self) -> None:
        self.send(episodes=EPISODES, rate=300.0)
        for episode, node in ((0, "mujoco"), (1, "policy")):
            self.feedback_of(episode, 10)
            os.kill(pid_of(f"/{node}"), signal.SIGKILL)
        self.assert_survived(2)

    def test_f14_stopped_node_that_goes_on(self) -> None:
        """The answer comes too late to count; the node itself is still there."""
        self.under_way()
        pid = pid_of("/engine")
        self.addCleanup(kill, pid, signal.SIGCONT)
        os.kill(pid, signal.SIGSTOP)
        self.log.until(lambda message: "/engine/step: no answer within 500 ms" in message.msg)
        os.kill(pid, signal.SIGCONT)
        self.assert_survived(1)

    def test_f14_node_that_stays_stopped(self) -> None:
        self.under_way()
        pid = pid_of("/mujoco")
        self.addCleanup(kill, pid, signal.SIGCONT)
        os.kill(pid, signal.SIGSTOP)
        result = self.result(GoalStatus.ABORTED)
        self.assertEqual((result.exit_code, result.faults_survived), (4, 1))
        self.assert_not_whole(self.out, "/mujoco/describe: nobody answers within 3000 ms")


run(LiveRespawn)
