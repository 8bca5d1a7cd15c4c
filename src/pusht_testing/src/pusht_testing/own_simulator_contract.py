# SPDX-License-Identifier: BSD-3-Clause
"""The contract of this suite's simulator nodes, beyond that of every simulator.

`serveSimulator` in C++ and `serve_simulator` in Python do it; a node of yours need not.
"""

import contextlib
import math
import subprocess
from typing import Any, Tuple

import numpy as np
import rospy  # type: ignore[import]
import tf2_ros  # type: ignore[import]
import yaml  # type: ignore[import]
from pusht_msgs.msg import Parameter  # type: ignore[import]
from visualization_msgs.msg import MarkerArray  # type: ignore[import]

from pusht_task.task import START_TOLERANCE, spawn
from pusht_testing.nodes import DEADLINE, Inbox
from pusht_testing.served import HELD, data
from pusht_testing.simulator_case import PUSHES, REPRESENTED
from pusht_testing.simulator_contract import SimulatorContract

FULL_CIRCLE = "full_circle"  # the task that a node is of, if it says of none


class OwnSimulatorContract(SimulatorContract):
    """The contract of every simulator, in the words of this suite, and what its nodes add."""

    words_are_ours = True

    def test_order_of_the_checks(self) -> None:
        wrong = {"step": 7, "action": (math.nan, 0.0), "stamp": rospy.Time(0, 1)}
        self.accepted("reset", horizon=1)
        self.refused("episode", "step", **{**wrong, "episode": 9})
        self.refused("expected", "step", **wrong)
        self.refused("action", "step", **{**wrong, "step": 0})
        self.accepted("step")
        self.refused("horizon", "step", **{**wrong, "step": 1})

    def test_diagnostics(self) -> None:
        self.assert_healthy()

    def test_diagnostics_count_what_was_refused(self) -> None:
        def counts_after_a_refusal(name: str) -> Tuple[int, int]:
            response = self.call("configure", parameters=[Parameter(name, "1")], end_episode=True)
            self.assert_refusal(response, name)
            return self.counts_with(response.message)

        answered, refused = counts_after_a_refusal("no_such_one")
        self.accepted("reset", seed=1)
        self.accepted("reset", seed=2)
        self.assertEqual(counts_after_a_refusal("nor_such_one"), (answered + 2, refused + 1))

    def test_version_is_known(self) -> None:
        self.assertTrue(self.call("describe").version)

    def test_rosparam_shows_what_is_configured(self) -> None:
        number, changed = self.number()
        self.accepted("configure", parameters=[changed], end_episode=True)
        shown = rospy.get_param(f"{self.namespace}/{number.name}")
        self.assertEqual(shown, float(changed.value))
        self.accepted("configure", parameters=[number])

    def test_session_on_the_command_line(self) -> None:
        reset = self.rosservice("reset", "{seed: 7}")
        self.assertAlmostEqual(reset["state"]["tee_x"], spawn(7).tee_x, delta=self.start_tolerance)
        step = self.rosservice("step", "{step: -1, action: [0.5, 0.0]}")
        self.assertEqual((step["success"], step["step"]), (True, 0))
        self.assertEqual(step["instance_id"], self.instance_id)
        description = self.rosservice("describe", "{}")
        self.assertEqual(description["stamp"], step["stamp"])

    def rosservice(self, service: str, request: str) -> Any:
        process = subprocess.run(
            ["rosservice", "call", f"{self.namespace}/{service}", request],
            stdout=subprocess.PIPE,
            text=True,
            check=True,
            timeout=DEADLINE,
        )
        return yaml.safe_load(process.stdout)

    # Pictures for late subscribers.

    def test_frames_come_again(self) -> None:
        state = self.begin(seed=3).state
        frames = tf2_ros.Buffer()
        listener = tf2_ros.TransformListener(frames)
        self.addCleanup(listener.unregister)
        for child, x, y in (("tee", state.tee_x, state.tee_y), ("target", 0.0, 0.0)):
            names = (f"{self.frame_prefix}/table", f"{self.frame_prefix}/{child}")
            found = frames.lookup_transform(*names, rospy.Time(), rospy.Duration(DEADLINE))
            place = found.transform.translation
            np.testing.assert_allclose([place.x, place.y], [x, y], atol=1e-12)

    def test_markers_come_again(self) -> None:
        topic = f"{self.namespace}/markers"
        types = dict(rospy.get_published_topics(self.namespace))
        if topic not in types:  # it need not draw itself, but if it does, there
            self.assertNotIn(MarkerArray._type, types.values())
            return
        self.begin()
        latest = Inbox(topic, MarkerArray)
        for _ in range(2):  # the first is latched
            self.assertTrue(latest.until(lambda message: True)[0].markers)

    # Kinds that a node can become.

    def stay(self) -> Any:
        """The description of the node, which is made what it was when the test has ended."""
        before = self.call("describe")

        def restore() -> None:
            kind = before.name if before.kinds else ""
            self.accepted("reset")
            fields = {"parameters": before.parameters, "end_episode": True}
            self.accepted("configure", kind=kind, **fields)
            after = self.call("describe")
            after.stamp = before.stamp
            self.assertEqual(data(after), data(before))

        self.addCleanup(restore)
        return before

    def test_kinds(self) -> None:
        description = self.call("describe")
        self.assertEqual(len(description.kinds), len(set(description.kinds)))
        if description.kinds:
            self.assertIn(description.name, description.kinds)

    def test_describe_what_it_would_be(self) -> None:
        self.begin()
        before = self.call("describe")
        for kind in before.kinds or [before.name]:
            would_be = self.accepted("describe", kind=kind)
            self.assertEqual((would_be.name, would_be.kinds), (kind, before.kinds))
            self.assertTrue(would_be.version)
            self.assertGreaterEqual(would_be.start_tolerance, 0.0)
            self.assertLessEqual(would_be.start_tolerance, START_TOLERANCE)
            self.assertEqual((would_be.parameters_hash, would_be.provenance), ("", ""))
            self.assertEqual(would_be.frame_prefix, before.frame_prefix)
            self.assertEqual(would_be.stamp, before.stamp)
            if would_be.parameter_descriptors:
                defaults = [
                    Parameter(d.name, d.default_value) for d in would_be.parameter_descriptors
                ]
                if _task_of(would_be) != FULL_CIRCLE:  # which is told of where it is another
                    defaults[-1] = Parameter("task", _task_of(would_be))
                self.assertEqual(would_be.parameters, defaults)
            if kind == before.name:
                self.assertEqual(would_be.parameter_descriptors, before.parameter_descriptors)
        self.assertEqual(data(self.call("describe")), data(before))
        self.accepted("step", step=0)

    def test_becomes_each_kind(self) -> None:
        before = self.stay()
        old = before
        for kind in [*before.kinds, before.name]:
            would_be = self.accepted("describe", kind=kind)
            self.accepted("reset", token="mine")
            self.refused("held by another caller", "configure", HELD, kind=kind, end_episode=True)
            self.refused("mid-episode", "configure", token="mine", kind=kind)
            fields = {"kind": kind, "token": "mine", "end_episode": True}
            response = self.accepted("configure", **fields)
            self.assertEqual(data(self.accepted("configure", **fields)), data(response))
            self.assertEqual(response.parameters, would_be.parameters)
            self.refused("reset", "step", step=-1)

            found = self.assert_described()
            self.assertTrue(found.version)
            self.assertEqual(found.parameters_hash, response.parameters_hash)
            would_be.parameters_hash = found.parameters_hash
            would_be.provenance = found.provenance
            would_be.stamp = found.stamp
            self.assertEqual(data(found), data(would_be))
            self.assert_told(found, old)
            reset = self.accepted("reset", seed=3)
            tolerance = found.start_tolerance or REPRESENTED
            if _task_of(found) == FULL_CIRCLE:
                self.assert_near(reset.state, spawn(3), tolerance)
            else:  # a kind of another task alone brings that with it
                course = [Parameter("task", FULL_CIRCLE)]
                only = f"task {FULL_CIRCLE}: the kind {kind} holds only {_task_of(found)}"
                self.refused(only, "configure", parameters=course, end_episode=True)
            self.assertEqual(reset.parameters_hash, found.parameters_hash)
            self.accepted("step", step=0)
            old = found

    def assert_told(self, now: Any, before: Any) -> None:
        """The node's parameters are those with which it would come back as it is `now`."""
        told = rospy.get_param(self.namespace)
        for parameter in now.parameters:
            self.assertEqual(_told(told[parameter.name]), _told(parameter.value), parameter.name)
        others = {p.name for p in before.parameters} - {p.name for p in now.parameters}
        self.assertFalse(others & set(told), f"parameters of {before.name}")
        if now.kinds:
            self.assertEqual(told["kind"], now.name)

    def test_parameters_of_a_kind_are_its_defaults(self) -> None:
        before = self.stay()
        number, changed = self.number()
        defaults = self.accepted("describe", kind=before.name).parameters
        self.accepted("configure", parameters=[changed], end_episode=True)
        response = self.accepted("configure", kind=before.name)
        self.assertEqual(response.parameters, defaults)
        response = self.accepted("configure", kind=before.name, parameters=[changed])
        found = {p.name: p.value for p in response.parameters}
        self.assertEqual(float(found.pop(number.name)), float(changed.value))
        wanted = {p.name: p.value for p in defaults if p.name != number.name}
        self.assertEqual(found, wanted)

    def test_refused_kind_changes_nothing(self) -> None:
        undisturbed = self.trajectory(spawn(3), PUSHES[:2])
        self.trajectory(spawn(3), PUSHES[:1])
        before = self.call("describe")
        told = rospy.get_param(self.namespace)
        there = ", ".join(before.kinds)
        only = f"must be {before.name}, the only kind that this node can be"
        rule = f"unknown; known: {there}" if there else only
        for kind in ("no_such_kind", before.name.upper(), f"{before.name} "):
            reason = f"simulator '{kind}': {rule}"
            self.refused(reason, "configure", kind=kind, end_episode=True)
            self.refused(reason, "describe", kind=kind)
        stray = [Parameter("no_such_parameter", "1.0")]
        for kind in before.kinds or [before.name]:
            fields = {"kind": kind, "parameters": stray, "end_episode": True}
            self.refused("no_such_parameter", "configure", **fields)
        self.assertEqual(data(self.call("describe")), data(before))
        self.assertEqual(rospy.get_param(self.namespace), told)
        step = self.accepted("step", step=1, action=PUSHES[1])
        self.assertEqual(data(step.state), undisturbed[2])


def _task_of(description: Any) -> str:
    """Task of a described world; it is told of only where it is not the course's."""
    return next((p.value for p in description.parameters if p.name == "task"), FULL_CIRCLE)


def _told(value: Any) -> Any:
    """A parameter as it is compared: a number, or a text in lower case."""
    with contextlib.suppress(ValueError):
        return float(str(value))
    return str(value).lower()
