# SPDX-License-Identifier: BSD-3-Clause
"""Serves a plain Python object as a simulator node or a policy node.

    class Mine:  # one world; see world.Simulator
        def __init__(self, friction: float) -> None: ...
        def reset(self, start: WorldState) -> WorldState: ...
        def step(self, action: np.ndarray) -> WorldState: ...

    sys.exit(serve_simulator(Mine, name="mine", version="1.0", parameters={"friction": 0.3}))

It then has the services, topics and frames of every other simulator, and keeps the same rules.
"""

import contextlib
import math
import os
import sys
import threading
import xmlrpc.client
from types import MappingProxyType
from typing import Any, Callable, Dict, List, Mapping, Optional, Set

import rosgraph  # type: ignore[import]
import rospy  # type: ignore[import]
import tf2_ros  # type: ignore[import]
from diagnostic_msgs.msg import (  # type: ignore[import]
    DiagnosticArray,
    DiagnosticStatus,
    KeyValue,
)
from geometry_msgs.msg import TransformStamped  # type: ignore[import]
from pusht_msgs.msg import WorldStateStamped  # type: ignore[import]
from pusht_msgs.srv import Act as ActService  # type: ignore[import]
from pusht_msgs.srv import Configure, ConfigureResponse, Describe, Reset, Step
from rosgraph_msgs.msg import Clock  # type: ignore[import]

from pusht_task.error import Error, ExitCode
from pusht_task.task import FULL_CIRCLE, PUSHER_FRAME_HEIGHT, TEE_FRAME_HEIGHT
from sim2sim_serving.parameters import Value, merged
from sim2sim_serving.policy_session import Act, Begin, PolicySession
from sim2sim_serving.session import FOREIGN, FailedStart, Identity
from sim2sim_serving.simulator_session import SimulatorSession
from sim2sim_serving.world import Simulator

QUEUE = 1000  # messages to a slow subscriber
PERIOD = 1.0  # [s] of the diagnostics, of repeated frames and of the checks of master and launch
MASTER_PERIOD = 0.1  # [s] of the looks for one at start
MASTER_DEADLINE = 2.0  # [s] for its answer
CLOCK_PATIENCE = 5.0  # [s]
MASTER_PATIENCE = 3  # checks in a row that fail

OWN_PARAMETERS: Set[str] = set()  # private parameters that this process has set


def serve_simulator(
    make: Callable[..., Simulator],
    *,
    name: str,
    version: str,
    title: str = "",
    start_tolerance: float = 0.0,
    parameters: Mapping[str, Value] = MappingProxyType({}),
) -> int:
    """The main of a simulator node: serves what `make(**parameters)` gives; returns the exit code.

    `name` is a word; `title` is what people call the simulator, if that is not its name.
    `start_tolerance` [m, rad, m/s, rad/s] is how near to where it was told to it starts, at most
    1e-6. One that does not say starts to 1e-6; the contract suite then asks for double precision.
    `parameters` are names with their defaults. They are private parameters of the
    node, and ~configure makes the simulator anew with others. `make` raises ValueError, with name,
    value and rule, for a value that it does not like. A simulator that holds other tasks has a
    parameter `task` (world.Simulator).
    """

    def start(identity: Identity) -> SimulatorSession:
        defaults = {"frame_prefix": rospy.get_name().lstrip("/"), **parameters}
        values = _private_parameters(defaults)
        frame_prefix = str(values.pop("frame_prefix"))
        publisher = _WorldPublisher(frame_prefix)
        return _SimulatorNode(
            make, values, identity, frame_prefix, publisher.publish, defaults=parameters
        )

    services = {"reset": Reset, "step": Step, "configure": Configure}
    return _serve(start, services, Identity(name, version, title, start_tolerance))


def serve_policy(
    act: Act,
    *,
    name: str,
    version: str,
    begin: Optional[Begin] = None,
    answers: int = 1,
    stochastic: bool = False,
    task: str = FULL_CIRCLE,
) -> int:
    """The main of a policy node: serves `act`; returns the exit code.

    `act` maps observations, float32 [n, 10] as in Query.msg, to n commanded pusher velocities
    [m/s]; in another `task` both are in its units, such as positions [px]. It treats every row
    alike, whatever the others are. With `begin` the policy has a memory: `begin(seed, execute)`
    makes that of a rollout, any object, and `act(observations, memories)` changes those of its
    rows. All that is random must come from the seed. A policy that plans ahead says with how many
    actions it `answers`; more than these to be executed are refused. One that draws random numbers
    is `stochastic`: a run that plays each start once says so then.
    """

    def start(identity: Identity) -> PolicySession:
        _private_parameters({})
        return PolicySession(act, identity, begin, answers, stochastic, task)

    return _serve(start, {"act": ActService}, Identity(name, version))


def _serve(
    start: Callable[[Identity], Any], services: Mapping[str, Any], identity: Identity
) -> int:
    """Serves the methods of what `start` gives; if it fails, only `describe`, with the error."""
    if not _await_master(identity.name):
        return ExitCode.RUNTIME_FAULT
    OWN_PARAMETERS.update(rospy.client.load_command_line_node_params(sys.argv))
    rospy.init_node(identity.name)
    rospy.on_shutdown(_remove_own_parameters)
    if not _clock_runs():
        hint = "unset it, or start what publishes the clock"
        print(
            f"{identity.name}: /use_sim_time is set, but nothing publishes /clock: {hint}",
            file=sys.stderr,
        )
        return ExitCode.RUNTIME_FAULT
    session: Any
    try:
        session = start(identity)
        health = _Health(identity, DiagnosticStatus.OK, "serving")
        for service, service_type in services.items():
            handler = health.counting(getattr(session, service))
            rospy.Service(f"~{service}", service_type, handler)
        exit_code = ExitCode.OK
    except FOREIGN as failure:
        session = FailedStart(failure, identity)
        health = _Health(identity, DiagnosticStatus.ERROR, session.message)
        exit_code = session.exit_code
        rospy.logfatal(session.message)
    rospy.Service("~describe", Describe, session.describe)
    return health.watch() or exit_code


def _private_parameters(defaults: Mapping[str, Value]) -> Dict[str, Value]:
    """The node's private parameters on top of `defaults`."""
    namespace = f"{rospy.get_name()}/"
    values = dict(defaults)
    for name, value in rospy.get_param(rospy.get_name(), {}).items():
        try:
            values = merged(values, {name: value}, namespace)
        except Error as failure:
            if name in OWN_PARAMETERS:
                raise
            raise Error(
                f"{failure} (set by a launch file or left by an earlier node: "
                f"`rosparam delete {namespace}{name}` removes it)"
            ) from None
    return values


def _remove_own_parameters() -> None:
    """Leaves nothing to the next node of this name, unless roslaunch may start this one again."""
    if _launched():
        return
    with contextlib.suppress(KeyError, OSError, rosgraph.MasterException, rospy.ROSException):
        if rosgraph.Master(rospy.get_name()).lookupNode(rospy.get_name()) != rospy.get_node_uri():
            return  # they are those of the node that has replaced this one
        for name in OWN_PARAMETERS:
            with contextlib.suppress(KeyError):
                rospy.delete_param(f"~{name}")


def _launched() -> bool:
    """Whether roslaunch has started this node: it names a log file to each."""
    return any(argument.startswith("__log:=") for argument in sys.argv)


def _await_master(name: str) -> bool:
    """Waits as every node of ROS does, and says so; False if the user does not want to."""
    said = False
    try:
        while not master_answers():
            if not said:
                uri = rosgraph.get_master_uri()
                hint = "roscore or roslaunch starts one"
                print(f"{name}: waiting for the ROS master at {uri}: {hint}", file=sys.stderr)
                said = True
            rospy.rostime.wallsleep(MASTER_PERIOD)
        return True
    except KeyboardInterrupt:
        return False


def master_answers() -> bool:
    """Unlike rosgraph.is_master_online, which may wait for ever, this has a deadline."""
    try:
        with xmlrpc.client.ServerProxy(rosgraph.get_master_uri(), _Impatient()) as master:
            return bool(master.getPid("/sim2sim_serving"))
    except (OSError, xmlrpc.client.Error, ValueError):
        return False


def _clock_runs() -> bool:
    """True if the node's time passes."""
    if not rospy.get_param("/use_sim_time", False):
        return True
    try:
        rospy.wait_for_message("/clock", Clock, CLOCK_PATIENCE)
        return True
    except rospy.ROSException:
        return False


class _Impatient(xmlrpc.client.Transport):
    def make_connection(self, host: Any) -> Any:
        connection = super().make_connection(host)
        connection.timeout = MASTER_DEADLINE
        return connection


class _SimulatorNode(SimulatorSession):
    """A session whose parameters are those of the node."""

    def configure(self, request: Any) -> ConfigureResponse:
        response = super().configure(request)
        if response.success:
            for name, value in self.parameters.items():
                with contextlib.suppress(OverflowError):  # XML-RPC's integers have 32 bits
                    rospy.set_param(f"~{name}", value)
                    OWN_PARAMETERS.add(name)
        return response


class _WorldPublisher:
    """A world on ~state and in TF, where its frames come again once a second."""

    def __init__(self, frame_prefix: str) -> None:
        self._state = rospy.Publisher("~state", WorldStateStamped, queue_size=QUEUE)
        self._broadcaster = tf2_ros.TransformBroadcaster()
        self._pusher = _transform(frame_prefix, "pusher", PUSHER_FRAME_HEIGHT)
        self._tee = _transform(frame_prefix, "tee", TEE_FRAME_HEIGHT)
        self._fixed_broadcaster = tf2_ros.StaticTransformBroadcaster()
        self._fixed_broadcaster.sendTransform(_transform(frame_prefix, "target", 0.0))
        self._lock = threading.Lock()  # guards the frames
        self._repeating = threading.Event()
        threading.Thread(target=self._repeat, daemon=True).start()

    def publish(self, update: WorldStateStamped) -> None:
        with self._lock:
            self._pusher.transform.translation.x = update.state.pusher_x
            self._pusher.transform.translation.y = update.state.pusher_y
            self._tee.transform.translation.x = update.state.tee_x
            self._tee.transform.translation.y = update.state.tee_y
            self._tee.transform.rotation.z = math.sin(0.5 * update.state.tee_yaw)
            self._tee.transform.rotation.w = math.cos(0.5 * update.state.tee_yaw)
            self._send(update.header.stamp)
        self._repeating.set()
        self._state.publish(update)

    def _send(self, stamp: rospy.Time) -> None:
        frames = [self._pusher, self._tee]
        for frame in frames:
            frame.header.stamp = stamp
        self._broadcaster.sendTransform(frames)

    def _repeat(self) -> None:
        """Sends the frames again for late subscribers, 1 ns on: tf2 warns of a repeated stamp."""
        self._repeating.wait()
        while not rospy.is_shutdown():
            rospy.rostime.wallsleep(PERIOD)
            with self._lock:
                self._send(self._tee.header.stamp + rospy.Duration(0, 1))


def _transform(frame_prefix: str, child: str, height: float) -> TransformStamped:
    transform = TransformStamped()
    transform.header.frame_id = f"{frame_prefix}/table"
    transform.child_frame_id = f"{frame_prefix}/{child}"
    transform.transform.translation.z = height
    transform.transform.rotation.w = 1.0
    return transform


class _Health:
    """Health of a node, published once a second."""

    def __init__(self, identity: Identity, level: int, message: str) -> None:
        self._identity = identity
        self._level = level
        self._message = message
        self._answered = 0
        self._refused = 0
        self._last_refusal = ""
        self._publisher = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=1)

    def counting(self, serve: Callable[[Any], Any]) -> Callable[[Any], Any]:
        def counted(request: Any) -> Any:
            response = serve(request)
            if response.success:
                self._answered += 1
            else:
                self._refused += 1
                self._last_refusal = response.message
                rospy.logwarn("refused: %s", response.message)
            return response

        return counted

    def watch(self) -> ExitCode:
        """Returns when the node is shut down, or when the master or its roslaunch has died.

        Without them the node could not be found, or would not be ended.
        """
        launched = _launched()
        parent = os.getppid()
        misses = 0
        try:
            while not rospy.is_shutdown():
                self._publish()
                rospy.rostime.wallsleep(PERIOD)
                misses = 0 if master_answers() else misses + 1
                lost = ""
                if misses == MASTER_PATIENCE:
                    lost = f"the ROS master at {rosgraph.get_master_uri()}"
                if launched and os.getppid() != parent:
                    lost = "roslaunch, which has started this node,"
                if lost:
                    print(f"{self._identity.name}: {lost} has died", file=sys.stderr)
                    return ExitCode.RUNTIME_FAULT
        except (KeyboardInterrupt, rospy.ROSException):  # shut down, perhaps while it publishes
            pass
        return ExitCode.OK

    def _publish(self) -> None:
        values: List[KeyValue] = [
            KeyValue("answered", str(self._answered)),
            KeyValue("refused", str(self._refused)),
            KeyValue("last refusal", self._last_refusal),
        ]
        message = DiagnosticArray()
        message.header.stamp = rospy.Time.now()
        message.status = [
            DiagnosticStatus(
                level=self._level,
                name=f"{rospy.get_name()[1:]}: requests",
                message=self._message,
                hardware_id=self._identity.name,
                values=values,
            )
        ]
        self._publisher.publish(message)
