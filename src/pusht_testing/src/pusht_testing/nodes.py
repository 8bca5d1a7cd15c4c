# SPDX-License-Identifier: BSD-3-Clause
"""Tests of nodes: how they run, and how they wait for what nodes send."""

import queue
import re
import socket
import sys
import threading
import time
import unittest
import xmlrpc.client
from typing import Any, Callable, Dict, List, Mapping, Type
from xml.etree import ElementTree

import rosgraph  # type: ignore[import]
import rospy  # type: ignore[import]
import rostest  # type: ignore[import]

from pusht_task.error import ExitCode

DEADLINE = 30.0  # [s] for what must happen at once, whatever else keeps the machine busy
MASTER_DEADLINE = 2.0  # [s] for an answer of the master
SKIPPED: Dict[str, str] = {}  # reasons, by the names of the tests that were skipped in this process


def run(suite: Type[unittest.TestCase]) -> None:
    """The main of a test node."""
    name = re.sub(r"(?<!^)([A-Z])", r"_\1", suite.__name__).lower()
    # The private parameter that names the node under test.
    subject = getattr(suite, "subject", None)
    usage = f"usage: rosrun pusht_testing {name} --text _{subject}:=/NAME"
    if {"-h", "--help"} & set(sys.argv[1:]):
        print(f"{suite.__doc__}\n\n{usage}")
        sys.exit()
    if not _master_answers():
        uri = rosgraph.get_master_uri()
        print(f"{name}: no ROS master at {uri}: start roscore, or use roslaunch", file=sys.stderr)
        sys.exit(ExitCode.RUNTIME_FAULT)
    rospy.init_node(name)
    if subject is not None and not rospy.has_param(f"~{subject}"):
        print(f"{name}: parameter ~{subject} is not set; {usage}", file=sys.stderr)
        sys.exit(ExitCode.INVALID_INPUT)
    try:
        rostest.rosrun("pusht_testing", suite.__name__, suite)
    finally:
        for argument in sys.argv:
            if argument.startswith(rostest.XML_OUTPUT_FLAG):
                mark_skipped(argument[len(rostest.XML_OUTPUT_FLAG) :], SKIPPED)


def _master_answers() -> bool:
    """Whether a master answers in time; rosgraph alone would wait for ever."""
    before = socket.getdefaulttimeout()
    socket.setdefaulttimeout(MASTER_DEADLINE)
    try:
        return bool(rosgraph.is_master_online())
    finally:
        socket.setdefaulttimeout(before)


def mark_skipped(results: str, skipped: Mapping[str, str]) -> None:
    """Says in a file of results which tests were skipped, and why: rosunit says passed."""
    tree = ElementTree.parse(results)
    for case in tree.iter("testcase"):
        name = f"{case.get('classname')}.{case.get('name')}"
        if name in skipped:
            ElementTree.SubElement(case, "skipped", message=skipped[name])
    tree.write(results, encoding="utf-8", xml_declaration=True)


def until(holds: Callable[[], bool], what: str, deadline: float = DEADLINE) -> None:
    """Waits until `holds`, of which no event tells: asks again and again."""
    expiry = time.monotonic() + deadline
    pause = threading.Event()
    while not holds():
        if time.monotonic() > expiry:
            raise TimeoutError(f"{what}: not within {deadline} s")
        pause.wait(0.01)


def sends(node: str, topic: str, receiver: str = "") -> bool:
    """True if a topic of a node reaches `receiver` (default: this node), as the sender sees it."""
    name = rospy.get_name()
    with xmlrpc.client.ServerProxy(rosgraph.Master(name).lookupNode(node)) as proxy:
        answer: Any = proxy.getBusInfo(name)
    return any(
        (direction, destination, sent) == ("o", receiver or name, topic)
        for _, destination, direction, _, sent, *_ in answer[2]
    )


class Inbox:
    """Messages that arrive on a topic, in their order."""

    def __init__(self, topic: str, message_type: Any) -> None:
        self._messages: "queue.Queue[Any]" = queue.Queue()
        self._subscriber = rospy.Subscriber(
            topic, message_type, self._messages.put, tcp_nodelay=True
        )

    def close(self) -> None:
        """Ends the subscription, which otherwise lasts as long as the process."""
        self._subscriber.unregister()

    def until(self, last: Callable[[Any], bool], deadline: float = DEADLINE) -> List[Any]:
        """Messages up to the one that is `last`. Raises queue.Empty if it does not come."""
        messages = [self._messages.get(timeout=deadline)]
        while not last(messages[-1]):
            messages.append(self._messages.get(timeout=deadline))
        return messages
