#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Nodes that are lost and come back: the run is the one that nothing has disturbed."""

import os
import signal

import rospy  # type: ignore[import]
from actionlib_msgs.msg import GoalStatus  # type: ignore[import]
from pusht_msgs.msg import Nodes, NodeStatus, Parameter  # type: ignore[import]
from pusht_msgs.srv import Configure  # type: ignore[import]
from pusht_testing.nodes import Inbox, run
from rosgraph_msgs.msg import Log  # type: ignore[import]

from live_support import (
    NODES,
    GoalCase,
    Topic,
    connected,
    describe,
    kill,
    pid_of,
    result_bytes,
    status_of,
)

EPISODES = 3
BATCH = ("--policy", "expert", "--episodes", str(EPISODES))


class LiveRespawn(GoalCase):
    log: Topic

    @classmethod
    def setUpClass(cls) -> None:
        super().setUpClass()
        cls.log = Topic("/rosout", Log)

    def setUp(self) -> None:
        """The parameters of another test would stay."""
        super().setUp()
        for engine in ("engine", "engine_replay"):
            configure = connected(f"/{engine}/configure", Configure)
            answer = configure("", [Parameter("block_damp", "6.0")], True, "")
            configure.close()
            self.assertTrue(answer.success, answer.message)

    def under_way(self) -> None:
        """A run that stands still in its second episode."""
        self.log.forget(rospy.Time.now())
        self.send_and_hold(1, 10, episodes=EPISODES)

    def kill_node(self, node: str) -> None:
        os.kill(pid_of(f"/{node}"), signal.SIGKILL)

    def assert_survived(self, faults: int, *settings: str) -> None:
        result = self.result()
        self.assertEqual((result.exit_code, result.faults_survived), (0, faults))
        self.assertEqual(status_of(self.out)["faults_survived"], faults)
        self.assertEqual(result_bytes(self.out), self.batch_bytes(*BATCH, *settings))
        self.assert_recomputed(self.out)

    def test_f13_killed_node(self) -> None:
        for node in ("engine", "engine_replay", "reference", "policy"):
            with self.subTest(node):
                self.out = self.folder / node
                self.under_way()
                self.kill_node(node)
                since = rospy.Time.now()
                self.accepted("resume")
                warning = self.log.until(lambda m: "is void and begins again" in m.msg)[-1]
                self.assertLess((warning.header.stamp - since).to_sec(), 1.0)
                self.assertIn(f"/{node}/", warning.msg)
                self.assert_survived(1)

    def test_f13_two_nodes_one_after_the_other(self) -> None:
        self.send_and_hold(0, 10, episodes=EPISODES)
        self.kill_node("reference")
        self.accepted("step")
        self.go_on_to(1, 10)
        self.kill_node("policy")
        self.accepted("resume")
        self.assert_survived(2)

    def test_f13_node_that_dies_again_before_all_are_back(self) -> None:
        """It gets its parameters once more, from the evaluator."""
        parameters = [Parameter("block_damp", "20.0")]
        self.log.forget(rospy.Time.now())
        self.send_and_hold(0, 10, episodes=EPISODES, engine_parameters=parameters)
        last = pid_of("/engine_replay")  # it is connected to after the engine
        self.addCleanup(kill, last, signal.SIGCONT)
        os.kill(last, signal.SIGSTOP)
        self.kill_node("engine")
        self.accepted("resume")
        self.log.until(lambda message: "waiting for the node of /engine_replay" in message.msg)
        rospy.delete_param("/engine/block_damp")  # or it would start with what it had
        self.kill_node("engine")
        os.kill(last, signal.SIGCONT)
        self.assert_survived(2, "--block_damp", "20")

    def test_f13_node_of_a_kind_that_was_set_by_hand(self) -> None:
        """It comes back as another one, and the goal names no kind."""

        def become(kind: str) -> None:
            for engine in ("engine", "engine_replay"):
                configure = connected(f"/{engine}/configure", Configure)
                answer = configure(kind, [], True, "")
                configure.close()
                self.assertTrue(answer.success, answer.message)

        before = rospy.get_param("/engine")
        become("chipmunk")
        self.addCleanup(become, "two_mass")
        self.under_way()
        for name in rospy.get_param("/engine"):
            rospy.delete_param(f"/engine/{name}")
        rospy.set_param("/engine", {**before, "kind": "two_mass"})
        self.kill_node("engine")
        self.accepted("resume")
        self.assert_survived(1, "--engine", "chipmunk")

    def test_f14_stopped_node_that_goes_on(self) -> None:
        """The answer comes too late to count; the node itself is still there."""
        self.under_way()
        pid = pid_of("/engine")
        self.addCleanup(kill, pid, signal.SIGCONT)
        os.kill(pid, signal.SIGSTOP)
        self.accepted("resume")
        self.log.until(lambda message: "/engine/step: no answer within 2000 ms" in message.msg)
        os.kill(pid, signal.SIGCONT)
        self.assert_survived(1)

    def test_f14_node_that_stays_stopped(self) -> None:
        self.under_way()
        pid = pid_of("/reference")
        self.addCleanup(kill, pid, signal.SIGCONT)
        os.kill(pid, signal.SIGSTOP)
        self.accepted("resume")
        result = self.result(GoalStatus.ABORTED)
        self.assertEqual((result.exit_code, result.faults_survived), (4, 0))
        self.assert_not_whole(self.out, "/reference/describe: no node answers within 10000 ms")

    def test_presence_of_a_node_that_hangs_and_dies(self) -> None:
        nodes = Inbox("/sim2sim/nodes", Nodes)
        self.addCleanup(nodes.close)

        def becomes(presence: int) -> Nodes:
            return nodes.until(lambda message: message.nodes[1].presence == presence)[-1]

        first = becomes(NodeStatus.ALIVE)
        self.assertEqual([node.services for node in first.nodes], [f"/{node}" for node in NODES])
        self.assertEqual(first.nodes[1].instance_id, describe("engine").instance_id)
        self.assertIn("/policy", first.policies)
        pid = pid_of("/engine")
        self.addCleanup(kill, pid, signal.SIGCONT)
        os.kill(pid, signal.SIGSTOP)
        becomes(NodeStatus.SILENT)
        os.kill(pid, signal.SIGCONT)
        becomes(NodeStatus.ALIVE)
        self.kill_node("engine")
        others = {node.presence for node in becomes(NodeStatus.LOST).nodes if node.role != "engine"}
        self.assertEqual(others, {NodeStatus.ALIVE})
        back = becomes(NodeStatus.ALIVE)
        self.assertNotEqual(back.nodes[1].instance_id, first.nodes[1].instance_id)


run(LiveRespawn)
