# SPDX-License-Identifier: BSD-3-Clause
"""The contract of served simulators and policies: test suites to run over yours.

In a .test file, beside the node under test:

    <test test-name="mine" pkg="pusht_task" type="simulator_contract">
      <param name="simulator" value="/mine"/>
    </test>

By hand: rosrun pusht_task simulator_contract --text _simulator:=/mine
"""

import contextlib
import io
import itertools
import math
import queue
import random
import re
import subprocess
import sys
import threading
import time
import unittest
import xmlrpc.client
from dataclasses import replace
from typing import Any, Callable, Dict, List, Mapping, NoReturn, Type
from xml.etree import ElementTree

import numpy as np
import rosgraph  # type: ignore[import]
import rospy  # type: ignore[import]
import rostest  # type: ignore[import]
import tf2_ros  # type: ignore[import]
import yaml  # type: ignore[import]
from diagnostic_msgs.msg import (  # type: ignore[import]
    DiagnosticArray,
    DiagnosticStatus,
)
from pusht_msgs.msg import Parameter, Query, WorldStateStamped  # type: ignore[import]
from pusht_msgs.msg import WorldState as WorldStateMessage
from pusht_msgs.srv import Act, Configure, Describe, Reset, Step  # type: ignore[import]
from visualization_msgs.msg import MarkerArray  # type: ignore[import]

from pusht_task.exit_codes import ExitCode
from pusht_task.ros import master_answers
from pusht_task.task import (
    HORIZON,
    PLAUSIBLE_SPEED,
    PUSHER_FRAME_HEIGHT,
    START_TOLERANCE,
    TEE_FRAME_HEIGHT,
    WorldState,
    spawn,
    wrap_angle,
)

DEADLINE = 30.0  # [s] for what must happen at once, whatever else keeps the machine busy
CONTROL_STEP = rospy.Duration(0, 100_000_000)
BAD_REQUEST = ExitCode.INVALID_INPUT
HELD = ExitCode.RUNTIME_FAULT  # by another caller
# [m, rad, m/s, rad/s] How near a start must be to what was asked for, if the node does not say.
REPRESENTED = 1e-12


def run(suite: Type[unittest.TestCase]) -> None:
    """The main of a test node."""
    name = re.sub(r"(?<!^)([A-Z])", r"_\1", suite.__name__).lower()
    # The private parameter that names the node under test.
    subject = getattr(suite, "subject", None)
    usage = f"usage: rosrun pusht_task {name} --text _{subject}:=/NAME"
    if {"-h", "--help"} & set(sys.argv[1:]):
        print(f"{suite.__doc__}\n\n{usage}")
        sys.exit()
    if not master_answers():
        uri = rosgraph.get_master_uri()
        print(f"{name}: no ROS master at {uri}: start roscore, or use roslaunch", file=sys.stderr)
        sys.exit(ExitCode.RUNTIME_FAULT)
    rospy.init_node(name)
    if subject is not None and not rospy.has_param(f"~{subject}"):
        print(f"{name}: parameter ~{subject} is not set; {usage}", file=sys.stderr)
        sys.exit(ExitCode.INVALID_INPUT)
    try:
        rostest.rosrun("pusht_task", suite.__name__, suite)
    finally:
        for argument in sys.argv:
            if argument.startswith(rostest.XML_OUTPUT_FLAG):
                mark_skipped(argument[len(rostest.XML_OUTPUT_FLAG) :], ServedCase.skipped)


def mark_skipped(results: str, skipped: Mapping[str, str]) -> None:
    """Says in a file of results which tests were skipped, and why: rosunit says passed."""
    tree = ElementTree.parse(results)
    for case in tree.iter("testcase"):
        name = f"{case.get('classname')}.{case.get('name')}"
        if name in skipped:
            ElementTree.SubElement(case, "skipped", message=skipped[name])
    tree.write(results, encoding="utf-8", xml_declaration=True)


def until(holds: Callable[[], bool], what: str, deadline: float = DEADLINE) -> None:
    """Waits for what nothing tells of: asks again and again."""
    expiry = time.monotonic() + deadline
    pause = threading.Event()
    while not holds():
        if time.monotonic() > expiry:
            raise TimeoutError(f"{what}: not within {deadline} s")
        pause.wait(0.01)


def sends(node: str, topic: str, receiver: str = "") -> bool:
    """Whether a topic of a node reaches `receiver` (default: this node), as the sender sees it."""
    name = rospy.get_name()
    with xmlrpc.client.ServerProxy(rosgraph.Master(name).lookupNode(node)) as proxy:
        answer: Any = proxy.getBusInfo(name)
    return any(
        (direction, destination, sent) == ("o", receiver or name, topic)
        for _, destination, direction, _, sent, *_ in answer[2]
    )


class Inbox:
    """What arrives on a topic, in its order."""

    def __init__(self, topic: str, message_type: Any) -> None:
        self._messages: "queue.Queue[Any]" = queue.Queue()
        self._subscriber = rospy.Subscriber(
            topic, message_type, self._messages.put, tcp_nodelay=True
        )

    def until(self, last: Callable[[Any], bool], deadline: float = DEADLINE) -> List[Any]:
        """All messages up to the one that is `last`. Raises queue.Empty if it does not come."""
        messages = [self._messages.get(timeout=deadline)]
        while not last(messages[-1]):
            messages.append(self._messages.get(timeout=deadline))
        return messages


class ServedCase(unittest.TestCase):
    """A served node, its services, and what may be said of all answers."""

    subject: str  # name of the private parameter that names the node
    namespace: str
    instance_id: str
    services: Dict[str, Any]
    skipped: Dict[str, str] = {}  # reasons, of all suites

    def skipTest(self, reason: str) -> NoReturn:
        self.skipped[self.id()] = reason
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
        self.assertFalse(response.success, f"must be refused: {pattern}")
        self.assertRegex(response.message, pattern)
        self.assertNotIn("\n", response.message)
        self.assertEqual(response.exit_code, exit_code)
        self.assertEqual(response.instance_id, self.instance_id)

    def assert_described(self) -> Any:
        description = self.accepted("describe")
        self.assertTrue(description.name)
        self.assertTrue(description.version)
        self.assertIsInstance(yaml.safe_load(description.provenance), dict)
        return description

    def assert_healthy(self, level: int = DiagnosticStatus.OK) -> None:
        """The node tells /diagnostics of itself, at `level`."""
        node = self.namespace.strip("/")

        def is_ours(message: Any) -> bool:
            return any(node in status.name.split(":")[0] for status in message.status)

        message = Inbox("/diagnostics", DiagnosticArray).until(is_ours)[-1]
        self.assertEqual({status.level for status in message.status}, {level})


class SimulatorContract(ServedCase):
    """Every rule that a served simulator keeps. The node must be driven by nothing else."""

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
        """A reset; what ~state held before is forgotten."""
        response = self.accepted("reset", **fields)
        self.updates_until(response)
        return response

    @classmethod
    def updates_until(cls, response: Any) -> List[Any]:
        return cls.states.until(lambda update: update.header.stamp == response.stamp)

    def trajectory(self, start: WorldState, actions: Any) -> List[bytes]:
        states = [self.accepted("reset", start=[message_of(start)]).state]
        for action in actions:
            states.append(self.accepted("step", step=-1, action=action).state)
        return [data(state) for state in states]

    def number(self) -> Parameter:
        """A parameter that is a real and not zero."""
        for parameter in self.call("describe").parameters:
            if re.fullmatch(r"[+-]?\d+(\.\d*)?(e[+-]?\d+)?", parameter.value):
                if float(parameter.value) != 0.0:
                    return parameter
        raise unittest.SkipTest(f"{self.namespace} has no parameter that is a number")

    # What a reset does.

    def test_seed_is_the_spawn(self) -> None:
        for seed in (0, 3, 10_000, 2**64 - 1):
            self.assert_near(self.accepted("reset", seed=seed).state, spawn(seed))

    def test_start_is_taken_with_its_velocities(self) -> None:
        self.assert_near(self.begin(start=[message_of(MOVING)]).state, MOVING)

    def test_yaw_is_wrapped(self) -> None:
        turned = replace(spawn(3), tee_yaw=3.0 + 10.0 * math.pi)
        state = self.accepted("reset", start=[message_of(turned)]).state
        self.assertAlmostEqual(state.tee_yaw, 3.0, delta=self.start_tolerance)

    def test_reset_to_its_own_state_changes_no_bit(self) -> None:
        for start in (MOVING, *map(spawn, range(20))):
            once = self.accepted("reset", start=[message_of(start)]).state
            again = self.accepted("reset", start=[once]).state
            self.assertEqual(data(again), data(once))

    def test_reset_clears_all_that_was_before(self) -> None:
        alone = self.trajectory(spawn(3), PUSHES)
        self.trajectory(spawn(7), PUSHES)
        self.assertEqual(self.trajectory(spawn(3), PUSHES), alone)

    def test_refused_resets_change_nothing(self) -> None:
        stamp = self.begin(episode=4).stamp
        for number in (math.nan, math.inf, -math.inf):
            bad = message_of(replace(spawn(3), tee_vx=number))
            self.refused("finite", "reset", start=[bad])
        self.refused("start", "reset", start=[message_of(spawn(3)), message_of(spawn(4))])
        for late in (rospy.Time(0, 1), stamp - CONTROL_STEP):
            self.refused("stamp", "reset", stamp=late)
        self.refused("stamp", "reset", stamp=stamp, episode=5)
        for beyond in (rospy.Time(2**31), rospy.Time(2**32 - 1, 999_999_999)):
            self.refused("stamp", "reset", stamp=beyond)
        step = self.accepted("step", episode=4)
        self.assertEqual(step.stamp, stamp + CONTROL_STEP)
        self.assertEqual(len(self.updates_until(step)), 1)

    def test_repeated_reset_is_answered_again(self) -> None:
        stamp = self.begin().stamp + CONTROL_STEP
        request: Dict[str, Any] = {"seed": 5, "episode": 6, "stamp": stamp}
        first = self.accepted("reset", **request)
        self.assertEqual(data(self.accepted("reset", **request)), data(first))
        others: List[Dict[str, Any]] = [{"seed": 6}, {"horizon": 7}, {"token": "other"}]
        for other in others:
            self.refused("stamp", "reset", **{**request, **other})
        step = self.accepted("step", episode=6)
        self.assertEqual([update.step for update in self.updates_until(step)], [0, 1])
        self.refused("stamp", "reset", **request)

    # What a step does.

    def test_step_before_reset(self) -> None:
        if self.before_reset is None:
            self.skipTest("the world had been reset before")
        self.assertFalse(self.before_reset.success)
        self.assertRegex(self.before_reset.message, "step before reset")
        self.assertEqual(self.before_reset.exit_code, BAD_REQUEST)
        self.assertEqual(self.before_reset.instance_id, self.instance_id)

    def test_pushing_moves_the_tee(self) -> None:
        state = self.accepted("reset", seed=3).state
        start = state
        for _ in range(40):
            way = np.array([state.tee_x - state.pusher_x, state.tee_y - state.pusher_y])
            action = way / np.linalg.norm(way)
            state = self.accepted("step", step=-1, action=action).state
        moved = math.hypot(state.tee_x - start.tee_x, state.tee_y - start.tee_y)
        self.assertGreater(moved, 0.02)

    def test_actions_are_clipped(self) -> None:
        inside = self.trajectory(spawn(3), [(1.0, -1.0)] * 5)
        self.assertEqual(self.trajectory(spawn(3), [(17.0, -1.5)] * 5), inside)

    def test_repeated_step_is_answered_again_without_physics(self) -> None:
        undisturbed = self.trajectory(spawn(3), PUSHES[:2])
        self.begin(start=[message_of(spawn(3))])
        first = self.accepted("step", step=0, action=PUSHES[0])
        again = self.accepted("step", step=0, action=PUSHES[0])
        self.assertEqual(data(again), data(first))
        others: List[Dict[str, Any]] = [
            {"action": PUSHES[1]},
            {"action": (math.nan, 0.0)},
            {"action": PUSHES[0], "stamp": first.stamp},
        ]
        for fields in others:
            self.refused("step 0: was taken with another action or stamp", "step", step=0, **fields)
        second = self.accepted("step", step=1, action=PUSHES[1])
        self.assertEqual([data(first.state), data(second.state)], undisturbed[1:])
        self.assertEqual([update.step for update in self.updates_until(second)], [1, 2])

    def test_refused_steps_change_nothing(self) -> None:
        undisturbed = self.trajectory(spawn(3), PUSHES[:2])
        self.begin(start=[message_of(spawn(3))], episode=3)
        first = self.accepted("step", episode=3, action=PUSHES[0])
        self.refused("episode 7: must be 3", "step", episode=7, step=1)
        for step in (-2, 2, 7):
            self.refused(f"step {step}: expected 1", "step", episode=3, step=step)
        for action in ((math.nan, 0.0), (0.0, math.inf), (-math.inf, 0.0)):
            self.refused("action .*finite", "step", episode=3, step=1, action=action)
        for stamp in (rospy.Time(0, 1), first.stamp):
            self.refused("stamp", "step", episode=3, step=1, stamp=stamp)
        second = self.accepted("step", episode=3, step=1, action=PUSHES[1])
        self.assertEqual([data(first.state), data(second.state)], undisturbed[1:])
        self.assertEqual([update.step for update in self.updates_until(second)], [1, 2])
        self.refused("step 0: expected 2", "step", episode=3, step=0)

    def test_order_of_the_checks(self) -> None:
        wrong = {"step": 7, "action": (math.nan, 0.0), "stamp": rospy.Time(0, 1)}
        self.accepted("reset", horizon=1)
        self.refused("episode", "step", **{**wrong, "episode": 9})
        self.refused("expected", "step", **wrong)
        self.refused("action", "step", **{**wrong, "step": 0})
        self.accepted("step")
        self.refused("horizon", "step", **{**wrong, "step": 1})

    def test_horizon(self) -> None:
        for asked, horizon in ((2, 2), (0, HORIZON)):
            self.accepted("reset", horizon=asked)
            for step in range(horizon):
                last = self.accepted("step", step=step)
            message = f"step {horizon}: the horizon of {horizon} control steps is reached"
            for step in (-1, horizon):
                self.refused(message, "step", step=step)
            self.assertEqual(data(self.accepted("step", step=horizon - 1)), data(last))

    def test_success_never_stops_a_world(self) -> None:
        solved = WorldState(pusher_x=0.2, pusher_y=0.2)
        self.trajectory(solved, [(0.0, 0.0)] * 10)

    def test_f21_absurd_start_is_an_error_or_stays_finite(self) -> None:
        fast = replace(spawn(3), tee_vx=PLAUSIBLE_SPEED, pusher_vy=-PLAUSIBLE_SPEED)
        inside = replace(spawn(3), pusher_x=spawn(3).tee_x, pusher_y=spawn(3).tee_y)
        for start in (fast, inside):
            response = self.call("reset", start=[message_of(start)])
            steps = 0
            while response.success and steps < 20:
                self.assertTrue(all(map(math.isfinite, numbers_of(response.state))))
                response = self.call("step", step=-1)
                steps += 1
            if not response.success:
                self.assertTrue(response.message)
                self.refused("needs a reset", "step", step=-1)
            self.assert_near(self.accepted("reset", seed=3).state, spawn(3))

    def test_f21_start_beyond_what_is_plausible_is_refused(self) -> None:
        self.accepted("reset", seed=3)
        for beyond in (
            {"tee_x": 1e11},
            {"tee_yaw": 1e300},
            {"pusher_vy": -1e11},
            {"tee_yaw_rate": 1e308},
        ):
            start = message_of(replace(spawn(3), **beyond))
            self.refused("must be within", "reset", start=[start])
        self.accepted("step", step=0)

    # Who may step and configure a world that is held.

    def refused_without_hold(self, pattern: str, token: str) -> None:
        """Every request but a reset; the world stays as it is."""
        before = data(self.call("describe"))
        for fields in ({"step": -1}, {"step": 0}):
            self.refused(pattern, "step", HELD, token=token, **fields)
        change: Dict[str, Any] = {"token": token, "parameters": [Parameter("no_such_knob", "1.0")]}
        for end_episode in (False, True):
            self.refused(pattern, "configure", HELD, end_episode=end_episode, **change)
        self.assertEqual(data(self.call("describe")), before)

    def test_only_the_holder_is_served(self) -> None:
        undisturbed = self.trajectory(spawn(3), PUSHES[:2])
        self.begin(start=[message_of(spawn(3))], token="mine", horizon=2)
        self.refused_without_hold("held by another caller", "")
        self.refused_without_hold("was reset by another caller", "other")
        first = self.accepted("step", step=0, action=PUSHES[0], token="mine")
        self.refused_without_hold("held by another caller", "")
        self.refused("held", "step", HELD, step=0, action=PUSHES[0])
        second = self.accepted("step", step=1, action=PUSHES[1], token="mine")
        self.assertEqual([data(first.state), data(second.state)], undisturbed[1:])
        self.assertEqual([update.step for update in self.updates_until(second)], [1, 2])
        self.refused_without_hold("held by another caller", "")  # past the horizon, too

    def test_a_reset_takes_the_world_over(self) -> None:
        for token in ("other", ""):
            self.accepted("reset", token="mine")
            self.accepted("step", token="mine")
            self.accepted("reset", token=token)
            self.refused_without_hold("was reset by another caller", "mine")
            self.accepted("step", token=token)

    def test_configuring_ends_the_hold(self) -> None:
        self.accepted("reset", token="mine")
        self.refused("mid-episode", "configure", token="mine")
        response = self.accepted("configure", token="mine", end_episode=True)
        again = self.accepted("configure", token="mine", end_episode=True)
        self.assertEqual(data(again), data(response), "asked again, it answers again")
        self.refused_without_hold("was reset by another caller, or its episode has ended", "mine")
        self.accepted("configure")

    def test_refused_reset_leaves_the_hold(self) -> None:
        self.accepted("reset", token="mine")
        self.refused("stamp", "reset", stamp=rospy.Time(0, 1))
        self.refused("held", "step", HELD)
        self.accepted("step", token="mine")

    def test_answers_name_the_parameters(self) -> None:
        parameters_hash = self.call("describe").parameters_hash
        self.assertEqual(self.accepted("reset").parameters_hash, parameters_hash)
        configured = self.accepted("configure", end_episode=True)
        self.assertEqual(configured.parameters_hash, parameters_hash)

    # What by-hand requests mean.

    def test_defaults_by_hand(self) -> None:
        reset = self.begin()
        self.assert_near(reset.state, spawn(0))
        for index in range(3):
            step = self.accepted("step", step=-1)
            self.assertEqual(step.step, index)
            self.assertEqual(step.stamp, reset.stamp + (index + 1) * CONTROL_STEP)

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

    # What is published.

    def test_stamps_grow_over_episodes(self) -> None:
        last = self.begin().stamp
        stamps = []
        for episode in range(3):
            asked = last + rospy.Duration(7, 1) if episode == 1 else rospy.Time()
            answers = [self.accepted("reset", episode=episode, stamp=asked)]
            answers += [self.accepted("step", episode=episode, step=k) for k in range(5)]
            stamps += [answer.stamp for answer in answers]
            self.assertEqual(answers[0].stamp, asked or last + CONTROL_STEP)
            last = stamps[-1]
        self.assertEqual(self.call("describe").stamp, last)
        self.assertEqual(stamps, sorted(set(stamps)))
        updates = self.updates_until(answers[-1])
        self.assertEqual([update.header.stamp for update in updates], stamps)
        self.assertEqual([update.step for update in updates], [0, 1, 2, 3, 4, 5] * 3)

    def test_silent_episodes_are_simulated_but_not_published(self) -> None:
        loud = [self.begin(episode=1), self.accepted("step", episode=1, step=0, action=(1, 0))]
        silent = [self.accepted("reset", episode=2, silent=True)]
        silent += [self.accepted("step", episode=2, step=0, action=(1, 0))]
        self.assertEqual([data(a.state) for a in silent], [data(a.state) for a in loud])
        self.assertEqual({answer.stamp for answer in silent}, {loud[-1].stamp}, "stamps rest")
        after = [self.accepted("reset", episode=3), self.accepted("step", episode=3, step=0)]
        self.assertEqual(after[0].stamp, loud[-1].stamp + CONTROL_STEP)
        updates = self.updates_until(after[-1])
        self.assertEqual([(u.episode, u.step) for u in updates], [(1, 1), (3, 0), (3, 1)])

    def test_state_messages_are_the_answers(self) -> None:
        asked = [(0.25, -0.5), (3.0, -3.0)]
        answers = [self.begin(episode=9)]
        answers += [self.accepted("step", episode=9, step=-1, action=action) for action in asked]
        updates = self.updates_until(answers[-1])
        self.assertEqual([update.step for update in updates], [1, 2])
        self.assertEqual([update.action for update in updates], [(0.25, -0.5), (1.0, -1.0)])
        for update, answer in zip(updates, answers[1:]):
            self.assertEqual(update.episode, 9)
            self.assertEqual(update.header.frame_id, f"{self.frame_prefix}/table")
            self.assertEqual(update.header.stamp, answer.stamp)
            self.assertEqual(data(update.state), data(answer.state))

    def test_state_message_of_a_reset(self) -> None:
        self.begin()
        reset = self.accepted("reset", seed=4, episode=2)
        (update,) = self.updates_until(reset)
        self.assertEqual((update.episode, update.step, update.action), (2, 0, (0.0, 0.0)))
        self.assertEqual(data(update.state), data(reset.state))

    def test_frames(self) -> None:
        for answer in (self.accepted("reset", seed=3), self.accepted("step", action=(0.5, 0.5))):
            state = answer.state
            for child, x, y, height, yaw in (
                ("pusher", state.pusher_x, state.pusher_y, PUSHER_FRAME_HEIGHT, 0.0),
                ("tee", state.tee_x, state.tee_y, TEE_FRAME_HEIGHT, state.tee_yaw),
                ("target", 0.0, 0.0, 0.0, 0.0),
            ):
                found = self.frame(child, answer.stamp)
                self.assertEqual(found.header.stamp, answer.stamp)
                place, turn = found.transform.translation, found.transform.rotation
                np.testing.assert_allclose([place.x, place.y, place.z], [x, y, height], atol=1e-12)
                wanted = [0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)]
                np.testing.assert_allclose([turn.x, turn.y, turn.z, turn.w], wanted, atol=1e-12)

    def test_frames_come_again_for_whoever_joins_late(self) -> None:
        state = self.begin(seed=3).state
        frames = tf2_ros.Buffer()
        listener = tf2_ros.TransformListener(frames)
        self.addCleanup(listener.unregister)
        for child, x, y in (("tee", state.tee_x, state.tee_y), ("target", 0.0, 0.0)):
            names = (f"{self.frame_prefix}/table", f"{self.frame_prefix}/{child}")
            found = frames.lookup_transform(*names, rospy.Time(), rospy.Duration(DEADLINE))
            place = found.transform.translation
            np.testing.assert_allclose([place.x, place.y], [x, y], atol=1e-12)

    def test_markers_come_again_for_whoever_has_forgotten(self) -> None:
        topic = f"{self.namespace}/markers"
        types = dict(rospy.get_published_topics(self.namespace))
        if topic not in types:  # it need not draw itself, but if it does, there
            self.assertNotIn(MarkerArray._type, types.values())
            return
        self.begin()
        latest = Inbox(topic, MarkerArray)
        for _ in range(2):  # the first is latched
            self.assertTrue(latest.until(lambda message: True)[0].markers)

    def test_diagnostics(self) -> None:
        self.assert_healthy()

    # What it says of itself, and its knobs.

    def test_describe(self) -> None:
        description = self.assert_described()
        names = [parameter.name for parameter in description.parameters]
        self.assertEqual(len(names), len(set(names)))
        self.assertEqual(bool(description.parameters_hash), bool(names))
        self.assertTrue(description.frame_prefix)
        self.assertFalse(description.frame_prefix.startswith("/"))
        self.assertGreaterEqual(description.start_tolerance, 0.0)
        self.assertLessEqual(description.start_tolerance, START_TOLERANCE)

    def test_configure_in_mid_episode(self) -> None:
        before = self.trajectory(spawn(3), PUSHES[:3])
        self.trajectory(spawn(3), PUSHES[:1])
        self.refused("mid-episode", "configure")
        step = self.accepted("step", step=1, action=PUSHES[1])
        self.assertEqual(data(step.state), before[2])
        self.accepted("configure", end_episode=True)
        self.refused("reset", "step", step=-1)
        self.assertEqual(self.trajectory(spawn(3), PUSHES[:3]), before)

    def test_configure_between_episodes(self) -> None:
        stamp = self.accepted("reset", horizon=1).stamp
        self.accepted("step")
        self.accepted("configure")
        self.refused("reset", "step", step=-1)
        self.assertEqual(self.call("describe").stamp, stamp + CONTROL_STEP)
        self.accepted("reset")

    def test_configured_parameters(self) -> None:
        before = self.call("describe")
        number = self.number()
        types = {known.name: known.type for known in before.parameter_descriptors}
        whole = types.get(number.name) == "integer"
        value = int(number.value) + 1 if whole else 1.01 * float(number.value)
        changed = Parameter(number.name, repr(value))
        response = self.accepted("configure", parameters=[changed], end_episode=True)
        after = self.call("describe")
        self.assertEqual(after.parameters, response.parameters)
        wanted = {p.name: p.value for p in [*before.parameters, changed]}
        found = {p.name: p.value for p in after.parameters}
        self.assertEqual(list(found), [parameter.name for parameter in before.parameters])
        self.assertEqual(float(found.pop(number.name)), float(wanted.pop(number.name)))
        self.assertEqual(found, wanted)
        shown = rospy.get_param(f"{self.namespace}/{number.name}")
        self.assertEqual(shown, float(changed.value), "rosparam must show it")
        self.assertNotEqual(after.parameters_hash, before.parameters_hash)
        self.assertEqual(after.parameters_hash, response.parameters_hash)
        self.accepted("configure", parameters=[number])
        self.assertEqual(data(self.call("describe")), data(before))

    def test_configuring_what_is_not_there(self) -> None:
        before = self.call("describe")
        stray = Parameter("no_such_knob", "1.0")
        self.refused("no_such_knob", "configure", parameters=[stray], end_episode=True)
        self.assertEqual(data(self.call("describe")), data(before))

    def test_configuring_bad_values(self) -> None:
        before = self.call("describe")
        name = self.number().name
        for value in ("nan", "inf", "-inf", "much", "", "1e400", "0x10", "1 2"):
            bad = Parameter(name, value)
            self.refused(name, "configure", parameters=[bad], end_episode=True)
        self.assertEqual(data(self.call("describe")), data(before))

    def test_refused_configuration_leaves_the_episode(self) -> None:
        self.accepted("reset")
        stray = Parameter("no_such_knob", "1.0")
        self.refused("no_such_knob", "configure", parameters=[stray], end_episode=True)
        self.accepted("step")

    # What it can become.

    def stay(self) -> Any:
        """Its description; when the test has ended, it is made what it was."""
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
            self.assertEqual(found.parameters_hash, response.parameters_hash)
            would_be.parameters_hash = found.parameters_hash
            would_be.provenance = found.provenance
            would_be.stamp = found.stamp
            self.assertEqual(data(found), data(would_be))
            self.assert_told(found, old)
            reset = self.accepted("reset", seed=3)
            tolerance = found.start_tolerance or REPRESENTED
            self.assert_near(reset.state, spawn(3), tolerance)
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
        number = self.number()
        defaults = self.accepted("describe", kind=before.name).parameters
        whole = re.fullmatch(r"[+-]?\d+", number.value)
        value = int(number.value) + 1 if whole else 1.01 * float(number.value)
        changed = Parameter(number.name, repr(value))
        self.accepted("configure", parameters=[changed], end_episode=True)
        response = self.accepted("configure", kind=before.name)
        self.assertEqual(response.parameters, defaults)
        response = self.accepted("configure", kind=before.name, parameters=[changed])
        found = {p.name: p.value for p in response.parameters}
        self.assertEqual(float(found.pop(number.name)), value)
        wanted = {p.name: p.value for p in defaults if p.name != number.name}
        self.assertEqual(found, wanted)

    def test_f36_refused_kind_changes_nothing(self) -> None:
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
        stray = [Parameter("no_such_knob", "1.0")]
        for kind in before.kinds or [before.name]:
            fields = {"kind": kind, "parameters": stray, "end_episode": True}
            self.refused("no_such_knob", "configure", **fields)
        self.assertEqual(data(self.call("describe")), data(before))
        self.assertEqual(rospy.get_param(self.namespace), told)
        step = self.accepted("step", step=1, action=PUSHES[1])
        self.assertEqual(data(step.state), undisturbed[2])

    def assert_near(self, found: Any, wanted: WorldState, tolerance: float = 0.0) -> None:
        """To `tolerance`; 0: the one of what the node was at first."""
        tolerance = tolerance or self.start_tolerance
        self.assertLess(abs(wrap_angle(found.tee_yaw - wanted.tee_yaw)), tolerance)
        numbers = numbers_of(message_of(replace(wanted, tee_yaw=found.tee_yaw)))
        np.testing.assert_allclose(numbers_of(found), numbers, rtol=0, atol=tolerance)


class PolicyContract(ServedCase):
    """Every rule that a served policy keeps. With ~memory: those of one that has a memory."""

    subject = "policy"
    has_memory: bool
    rollouts = itertools.count(random.getrandbits(63))

    @classmethod
    def setUpClass(cls) -> None:
        cls.find(act=Act)
        cls.has_memory = rospy.get_param("~memory", False)

    def queries(self, seeds: Any) -> List[Query]:
        """The first of a rollout for each of the spawns."""
        return [Query(next(self.rollouts), 0, observe(spawn(seed))) for seed in seeds]

    def test_two_numbers_for_each_query(self) -> None:
        for count in (0, 1, 5):
            actions = self.accepted("act", queries=self.queries(range(count))).actions
            self.assertEqual(len(actions), 2 * count)
            self.assertTrue(all(map(math.isfinite, actions)))

    def test_rows_are_independent(self) -> None:
        together = self.accepted("act", queries=self.queries(range(8))).actions
        alone: List[float] = []
        for query in self.queries(range(8)):
            alone += self.accepted("act", queries=[query]).actions
        self.assertEqual(alone, list(together))

    def test_asked_again_it_answers_the_same(self) -> None:
        queries = self.queries(range(3))
        for step in range(3):
            for query in queries:
                query.step = step
            first = self.accepted("act", queries=queries)
            self.assertEqual(data(self.accepted("act", queries=queries)), data(first))

    def test_observations_that_are_not_finite(self) -> None:
        for number in (math.nan, math.inf):
            queries = self.queries(range(3))
            queries[1].observation[4] = number
            self.refused(f"rollout {queries[1].rollout}: .*finite", "act", queries=queries)

    def test_steps_of_a_rollout(self) -> None:
        (query,) = self.queries([3])
        beginning = data(self.accepted("act", queries=[query]))
        if not self.has_memory:  # what came before makes no difference
            query.step = 7
            self.assertEqual(data(self.accepted("act", queries=[query])), beginning)
            return
        query.step = 1
        self.accepted("act", queries=[query])
        other = Query(query.rollout, 1, observe(spawn(4)))
        self.refused("step 1: was answered for another observation", "act", queries=[other])
        query.step = 7
        expected = f"rollout {query.rollout}: step 7: expected 2"
        self.refused(expected, "act", queries=[query])
        query.step = 0
        self.assertEqual(data(self.accepted("act", queries=[query])), beginning)
        (stranger,) = self.queries([3])
        stranger.step = 1
        self.refused(f"rollout {stranger.rollout}: step 1: expected 0", "act", queries=[stranger])

    def test_describe(self) -> None:
        description = self.assert_described()
        self.assertEqual((description.parameters, description.parameters_hash), ([], ""))
        self.assertEqual((description.frame_prefix, description.stamp), ("", rospy.Time()))

    def test_diagnostics(self) -> None:
        self.assert_healthy()


class FailedStartContract(ServedCase):
    """A node that fails at start stays alive to say so.

    ~exit_code is the one it must tell, ~message a regular expression to be found in its message.
    """

    subject = "node"

    @classmethod
    def setUpClass(cls) -> None:
        cls.find()

    def test_describe_tells_the_error(self) -> None:
        description = self.call("describe")
        self.assertFalse(description.success)
        self.assertEqual(description.exit_code, rospy.get_param("~exit_code", BAD_REQUEST))
        self.assertRegex(description.message, rospy.get_param("~message", "."))
        self.assertNotIn("\n", description.message)
        self.assertTrue(description.instance_id)

    def test_nothing_else_is_served(self) -> None:
        _, _, services = rosgraph.Master(rospy.get_name()).getSystemState()
        served = {name for name, _ in services}
        self.assertIn(f"{self.namespace}/describe", served)
        for name in ("reset", "step", "configure", "act"):
            self.assertNotIn(f"{self.namespace}/{name}", served)

    def test_diagnostics(self) -> None:
        self.assert_healthy(DiagnosticStatus.ERROR)


PUSHES = [(0.5 * math.cos(k), 0.5 * math.sin(k)) for k in range(20)]  # [m/s]
MOVING = replace(spawn(3), pusher_vx=0.3, pusher_vy=-0.2, tee_vx=-0.4, tee_vy=0.1, tee_yaw_rate=2.0)


def data(message: Any) -> bytes:
    """What travels."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def _told(value: Any) -> Any:
    """What is compared of a parameter: the parameter server's, or a text that stands for it."""
    with contextlib.suppress(ValueError):
        return float(str(value))
    return str(value).lower()


def message_of(state: WorldState) -> WorldStateMessage:
    return WorldStateMessage(**vars(state))


def numbers_of(message: WorldStateMessage) -> List[float]:
    return [getattr(message, name) for name in message.__slots__]


def observe(state: WorldState) -> List[float]:
    """As in Query.msg."""
    pose = [state.pusher_x, state.pusher_y, state.tee_x, state.tee_y]
    return [*pose, math.sin(state.tee_yaw), math.cos(state.tee_yaw), 0.0, 0.0, 0.0, 1.0]
