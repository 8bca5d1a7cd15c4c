# SPDX-License-Identifier: BSD-3-Clause
"""A served simulator under test: requests, trajectories, what it publishes."""

import math
import re
from dataclasses import replace
from typing import Any, List, Tuple

import numpy as np
import rospy  # type: ignore[import]
import tf2_ros  # type: ignore[import]
from pusht_msgs.msg import Parameter, WorldStateStamped  # type: ignore[import]
from pusht_msgs.srv import Configure, Reset, Step  # type: ignore[import]

from pusht_task.task import WorldState, spawn, wrap_angle
from pusht_testing.nodes import DEADLINE, Inbox, sends, until
from pusht_testing.served import ServedCase, data, message_of, numbers_of

CONTROL_STEP = rospy.Duration(0, 100_000_000)
# [m, rad, m/s, rad/s] Maximum deviation of a state after a reset from the requested state, if the
# node does not say.
REPRESENTED = 1e-12
PUSHES = [(0.5 * math.cos(k), 0.5 * math.sin(k)) for k in range(20)]  # [m/s]
MOVING = replace(spawn(3), pusher_vx=0.3, pusher_vy=-0.2, tee_vx=-0.4, tee_vy=0.1, tee_yaw_rate=2.0)


class SimulatorCase(ServedCase):
    """A served simulator under test. The node must be driven by nothing else."""

    subject = "simulator"
    states: Inbox
    frames: tf2_ros.Buffer
    listener: tf2_ros.TransformListener
    frame_prefix: str
    start_tolerance: float
    before_reset: Any  # answer to a step before the first reset

    @classmethod
    def setUpClass(cls) -> None:
        cls.find(reset=Reset, step=Step, configure=Configure)
        description = cls.call("describe")
        cls.frame_prefix = description.frame_prefix
        cls.start_tolerance = description.start_tolerance or REPRESENTED
        cls.before_reset = None if description.stamp else cls.call("step", step=-1)
        cls.states = Inbox(f"{cls.namespace}/state", WorldStateStamped)
        cls.frames = tf2_ros.Buffer()
        cls.listener = tf2_ros.TransformListener(cls.frames)
        for topic in (f"{cls.namespace}/state", "/tf"):
            until(lambda: sends(cls.namespace, topic), f"{topic} from {cls.namespace}")

    @classmethod
    def frame(cls, child: str, stamp: Any) -> Any:
        """The transform table -> child at exactly `stamp`."""
        parent = f"{cls.frame_prefix}/table"
        child = f"{cls.frame_prefix}/{child}"
        return cls.frames.lookup_transform(parent, child, stamp, rospy.Duration(DEADLINE))

    def begin(self, **fields: Any) -> Any:
        """Resets the world, and forgets what ~state held before."""
        response = self.accepted("reset", **fields)
        self.updates_until(response)
        return response

    @classmethod
    def updates_until(cls, response: Any) -> List[Any]:
        """The messages on ~state up to that of an answer."""
        return cls.states.until(lambda update: update.header.stamp == response.stamp)

    def trajectory(self, start: WorldState, actions: Any) -> List[bytes]:
        """The states of an episode, one after the reset and one after each action."""
        states = [self.accepted("reset", start=[message_of(start)]).state]
        for action in actions:
            states.append(self.accepted("step", step=-1, action=action).state)
        return [data(state) for state in states]

    def number(self) -> Tuple[Parameter, Parameter]:
        """A parameter that is a number but zero, as it is and with another value."""
        description = self.call("describe")
        descriptors = {known.name: known for known in description.parameter_descriptors}
        for found in description.parameters:
            if re.fullmatch(r"[+-]?\d+(\.\d*)?(e[+-]?\d+)?", found.value):
                value = float(found.value)
                if value != 0.0:
                    known = descriptors.get(found.name)
                    whole = known is not None and known.type == "integer"
                    other = int(found.value) + 1 if whole else 1.01 * value
                    if known is not None and other > known.greatest:
                        other = int(known.least) if whole else known.least
                    return found, Parameter(found.name, repr(other))
        self.skipTest(f"{self.namespace} has no parameter that is a number")

    def assert_near(self, found: Any, wanted: WorldState, tolerance: float = 0.0) -> None:
        """Checks a state to `tolerance`; 0 stands for that of the node as it was at first."""
        tolerance = tolerance or self.start_tolerance
        self.assertLess(abs(wrap_angle(found.tee_yaw - wanted.tee_yaw)), tolerance)
        numbers = numbers_of(message_of(replace(wanted, tee_yaw=found.tee_yaw)))
        np.testing.assert_allclose(numbers_of(found), numbers, rtol=0, atol=tolerance)
