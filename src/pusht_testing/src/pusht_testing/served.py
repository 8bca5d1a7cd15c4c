# SPDX-License-Identifier: BSD-3-Clause
"""A served node under test, and what holds for all answers of all nodes."""

import io
import math
import unittest
from typing import Any, Dict, List, NoReturn, Tuple

import rospy  # type: ignore[import]
import yaml  # type: ignore[import]
from diagnostic_msgs.msg import (  # type: ignore[import]
    DiagnosticArray,
    DiagnosticStatus,
)
from pusht_msgs.msg import WorldState as WorldStateMessage  # type: ignore[import]
from pusht_msgs.srv import Describe  # type: ignore[import]

from pusht_task.error import ExitCode
from pusht_task.task import WorldState
from pusht_testing.nodes import DEADLINE, SKIPPED, Inbox

BAD_REQUEST = ExitCode.INVALID_INPUT
HELD = ExitCode.RUNTIME_FAULT  # held by another caller


class ServedCase(unittest.TestCase):
    """A served node, its services, and what holds for all of its answers."""

    subject: str  # name of the private parameter that names the node
    namespace: str
    instance_id: str
    services: Dict[str, Any]
    # True if refusals must have the words of this suite; else one line with a reason is enough.
    words_are_ours = False

    def skipTest(self, reason: str) -> NoReturn:
        SKIPPED[self.id()] = reason
        raise unittest.SkipTest(reason)

    @classmethod
    def find(cls, **services: Any) -> None:
        """Connects to the `services` of the node that the private parameter names."""
        cls.namespace = rospy.resolve_name(rospy.get_param(f"~{cls.subject}"))
        cls.services = {}
        for name, service in {**services, "describe": Describe}.items():
            full_name = f"{cls.namespace}/{name}"
            rospy.wait_for_service(full_name, DEADLINE)
            cls.services[name] = rospy.ServiceProxy(full_name, service, persistent=True)
        cls.instance_id = cls.call("describe").instance_id

    @classmethod
    def call(cls, service: str, **fields: Any) -> Any:
        return cls.services[service](**fields)

    def accepted(self, service: str, **fields: Any) -> Any:
        response = self.call(service, **fields)
        self.assertTrue(response.success, response.message)
        self.assertEqual((response.message, response.exit_code), ("", 0))
        self.assertEqual(response.instance_id, self.instance_id)
        return response

    def refused(
        self, pattern: str, service: str, exit_code: int = BAD_REQUEST, **fields: Any
    ) -> None:
        response = self.call(service, **fields)
        self.assert_refusal(response, pattern, exit_code)

    def assert_refusal(self, response: Any, pattern: str, exit_code: int = BAD_REQUEST) -> None:
        """Checks an answer that says no; `pattern` is what our own nodes say."""
        self.assertFalse(response.success, f"must be refused: {pattern}")
        self.assertRegex(response.message, pattern if self.words_are_ours else ".")
        self.assertNotIn("\n", response.message)
        self.assertEqual(response.exit_code, exit_code)
        self.assertEqual(response.instance_id, self.instance_id)

    def assert_described(self) -> Any:
        description = self.accepted("describe")
        self.assertTrue(description.name)
        self.assertIsInstance(yaml.safe_load(description.provenance), dict)
        return description

    def assert_healthy(self, level: int = DiagnosticStatus.OK) -> None:
        """Checks that the node tells /diagnostics of itself, at `level`."""
        node = self.namespace.strip("/")

        def is_ours(message: Any) -> bool:
            return any(node in status.name.split(":")[0] for status in message.status)

        message = Inbox("/diagnostics", DiagnosticArray).until(is_ours)[-1]
        self.assertEqual({status.level for status in message.status}, {level})

    def counts_with(self, refusal: str) -> Tuple[int, int]:
        """The answered and the refused requests that /diagnostics tells of when a message is the
        last refusal."""

        def values_of(message: Any) -> Dict[str, str]:
            return {value.key: value.value for status in message.status for value in status.values}

        inbox = Inbox("/diagnostics", DiagnosticArray)
        message = inbox.until(lambda told: values_of(told).get("last refusal") == refusal)[-1]
        inbox.close()
        values = values_of(message)
        return int(values["answered"]), int(values["refused"])


def data(message: Any) -> bytes:
    """The bytes of a message as they travel."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def message_of(state: WorldState) -> WorldStateMessage:
    return WorldStateMessage(**vars(state))


def numbers_of(message: WorldStateMessage) -> List[float]:
    return [getattr(message, name) for name in message.__slots__]


def observe(state: WorldState) -> List[float]:
    """Observation of a state, as in Query.msg."""
    pose = [state.pusher_x, state.pusher_y, state.tee_x, state.tee_y]
    return [*pose, math.sin(state.tee_yaw), math.cos(state.tee_yaw), 0.0, 0.0, 0.0, 1.0]
