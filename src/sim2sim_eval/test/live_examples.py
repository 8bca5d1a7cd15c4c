#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A run over the examples in Python."""

import json

import actionlib  # type: ignore[import]
import rospy  # type: ignore[import]
from pusht_msgs.msg import CompareAction, Parameter  # type: ignore[import]
from pusht_testing.nodes import run

from live_support import (
    DEADLINE,
    RECORDED_RESULTS,
    GoalCase,
    files,
    goal_of,
    metrics_of,
    result_bytes,
)


class LiveExamples(GoalCase):
    def test_run_over_the_examples(self) -> None:
        result = self.compare(episodes=2)
        self.assertEqual((result.exit_code, result.reason), (0, "finished"))
        self.assertEqual(files(self.out), RECORDED_RESULTS)
        metrics = metrics_of(self.out)
        self.assertEqual(
            (metrics["policy"], metrics["engine_simulator"]), ("by_hand", "quasi_static")
        )
        self.assertEqual(metrics["knobs"]["characteristic_length"], 0.04)
        provenance = json.loads((self.out / "provenance.json").read_text())
        self.assertTrue(provenance["policy"]["numpy"])
        self.assert_recomputed(self.out)

    def test_same_bytes_again_and_other_ones_with_another_parameter(self) -> None:
        results = []
        for name, length in (("a", "0.04"), ("b", "0.04"), ("c", "0.08")):
            self.out = self.folder / name
            parameters = [Parameter("characteristic_length", length)]
            self.compare(episodes=1, horizon=100, engine_parameters=parameters)
            results.append(result_bytes(self.out))
        self.assertEqual(results[0], results[1])
        self.assertNotEqual(results[0], results[2])

    def test_policy_with_a_memory(self) -> None:
        historian = actionlib.SimpleActionClient("/historian/compare", CompareAction)
        self.assertTrue(historian.wait_for_server(rospy.Duration(DEADLINE)))
        results = []
        for name in ("a", "b"):  # the same rollouts again, under other numbers
            out = self.folder / name
            historian.send_goal(goal_of(out=str(out), episodes=2, record=True))
            self.assertTrue(historian.wait_for_result(rospy.Duration(DEADLINE)))
            result = historian.get_result()
            self.assertEqual((result.exit_code, result.reason), (0, "finished"))
            results.append(result_bytes(out))
        self.assertEqual(results[0], results[1])
        self.assertEqual(metrics_of(out)["policy"], "by_hand_with_memory")
        self.assert_recomputed(out)

    def test_simulators_that_go_wrong_are_named(self) -> None:
        skeptic = actionlib.SimpleActionClient("/skeptic/compare", CompareAction)
        self.assertTrue(skeptic.wait_for_server(rospy.Duration(DEADLINE)))
        episode = r"episode 0 \(spawn seed 10000\), engine_closed, step"
        for fault, reason in (
            ("shifted", rf"{episode} 0: /bad: reset: tee_x -?\d\.\d+: must be"),
            ("far", rf"{episode} 3: /bad: step: tee_x 1e\+300 m: must be within 1000.0 m"),
            ("exit", rf"{episode} 3: /bad: step: SystemExit: lost my way"),
        ):
            with self.subTest(fault):
                out = self.folder / fault
                parameters = [Parameter("fault", fault)]
                skeptic.send_goal(goal_of(out=str(out), episodes=2, engine_parameters=parameters))
                self.assertTrue(skeptic.wait_for_result(rospy.Duration(DEADLINE)))
                self.assertEqual(skeptic.get_result().exit_code, 4)
                self.assert_not_whole(out, reason)


run(LiveExamples)
