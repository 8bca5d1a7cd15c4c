# SPDX-License-Identifier: BSD-3-Clause
"""The rules by which a Python object is served, without a node: requests in, replies out."""

import hashlib
import json
import logging
import math
import platform
import threading
import traceback
import uuid
from dataclasses import dataclass, field
from typing import Any, Callable, Dict, List, Mapping, Optional, Protocol, Sequence, Type, Union

import numpy as np
from genpy import Time  # type: ignore[import]
from pusht_msgs.msg import Parameter, ParameterDescriptor, WorldStateStamped  # type: ignore[import]
from pusht_msgs.msg import WorldState as WorldStateMessage
from pusht_msgs.srv import (  # type: ignore[import]
    ActResponse,
    ConfigureResponse,
    DescribeRequest,
    DescribeResponse,
    ResetResponse,
    StepResponse,
)

from pusht_task.exit_codes import ExitCode
from pusht_task.task import (
    ACTION_LIMIT,
    CONTROL_STEP,
    HORIZON,
    PLAUSIBLE_DISTANCE,
    PLAUSIBLE_SPEED,
    PLAUSIBLE_YAW,
    PLAUSIBLE_YAW_RATE,
    START_TOLERANCE,
    WorldState,
    spawn,
    wrap_angle,
)

LOG = logging.getLogger("rosout")  # of the node

NANOSECONDS = 10**9  # in a second
STAMP_STEP = round(CONTROL_STEP * NANOSECONDS)  # [ns]
# [s] What a caller may ask for. By hand no more than half of what a stamp can be: the runs that
# follow name stamps too, and a slip must not spoil the world for them.
STAMP_LIMIT_BY_HAND = 2**31
STAMP_LIMIT = 2**32 - 10**6
POSITIONS = ("pusher_x", "pusher_y", "tee_x", "tee_y")
SPEEDS = ("pusher_vx", "pusher_vy", "tee_vx", "tee_vy")
VELOCITIES = (*SPEEDS, "tee_yaw_rate")
KINDS = {bool: "true or false", int: "an integer", float: "a finite number", str: "a text"}
TYPES = {bool: "boolean", int: "integer", float: "real", str: "text"}  # in ParameterDescriptor
FOREIGN = (Exception, SystemExit)  # what foreign code may end with; sys.exit() ends no node
LONGEST_MESSAGE = 2000  # characters
NEXT = -1  # as the index of a step: the one that comes next

Value = Union[bool, int, float, str]  # of a parameter
Act = Callable[[np.ndarray], Any]  # float32 [n, 10] to [n, 2], as in Query.msg and Act.srv


class Simulator(Protocol):
    """One world. After an exception it is reset before it is stepped again."""

    def reset(self, start: WorldState) -> WorldState:
        """Starts from `start`, clears all hidden state; returns the start as it is represented."""

    def step(self, action: np.ndarray) -> WorldState:
        """One control step with the commanded pusher velocity [m/s], float64 [2] in [-1, 1]."""


def clipped(text: str, longest: int = LONGEST_MESSAGE) -> str:
    """The begin and end of a long text: a value of 10 MB is named, not copied."""
    if len(text) <= longest:
        return text
    half = longest // 2
    left_out = f" ... ({len(text) - 2 * half} characters left out) ... "
    return text[:half] + left_out + text[-half:]


class Refusal(Exception):
    """Why a request is not served: one line that names the thing, its value and the rule."""

    def __init__(self, message: str, exit_code: ExitCode = ExitCode.INVALID_INPUT) -> None:
        super().__init__(clipped(message))
        self.exit_code = exit_code


@dataclass(frozen=True)
class Identity:
    """What a node says of itself."""

    name: str  # of the kind of simulator or policy
    version: str
    title: str = ""  # of a simulator, for people
    # [m, rad, m/s, rad/s] how near to where it was told to a simulator starts; 0: it does not say
    start_tolerance: float = 0.0
    instance_id: str = field(default_factory=lambda: str(uuid.uuid4()))


class SimulatorSession:
    """One served world: which requests it accepts, in which order, and what it answers."""

    def __init__(
        self,
        make: Callable[..., Simulator],
        parameters: Mapping[str, Value],
        identity: Identity,
        frame_prefix: str,
        observer: Callable[[WorldStateStamped], None],
        defaults: Optional[Mapping[str, Value]] = None,
    ) -> None:
        """`observer` gets the world after every reset and step that was taken.

        `defaults` are those of `parameters`, if they are others.
        """
        said = identity.start_tolerance
        if not 0.0 <= said <= START_TOLERANCE:
            raise Refusal(f"start_tolerance {said}: must be above 0 and at most {START_TOLERANCE}")
        self._start_tolerance = said or START_TOLERANCE
        self._make = make
        self._defaults = dict(defaults or parameters)
        self._descriptors = [_descriptor(name, value) for name, value in self._defaults.items()]
        self._parameters = dict(parameters)
        self._simulator = _made(make, self._parameters)
        self._identity = identity
        self._frame_prefix = frame_prefix
        self._observer = observer
        self._lock = threading.Lock()
        self._stamp = 0  # the last one used [ns]
        self._closed: Optional[str] = "step before reset: call reset first"  # why no step is taken
        self._episode = 0
        self._horizon = 0
        self._steps = 0  # taken in the episode
        self._token = ""  # of who holds the world; empty: nobody
        self._silent = False  # whether the episode is published
        self._last_request: Any = None  # the last one that was taken
        self._last: Any = None  # answer to it

    @property
    def parameters(self) -> Dict[str, Value]:
        """As they are now."""
        with self._lock:
            return dict(self._parameters)

    def reset(self, request: Any) -> ResetResponse:
        return self._answer(self._reset, request, ResetResponse)

    def step(self, request: Any) -> StepResponse:
        return self._answer(self._step, request, StepResponse)

    def configure(self, request: Any) -> ConfigureResponse:
        return self._answer(self._configure, request, ConfigureResponse)

    def describe(self, request: Any = None) -> DescribeResponse:
        return self._answer(self._describe, request or DescribeRequest(), DescribeResponse)

    def _answer(self, serve: Callable[[Any], Any], request: Any, response_type: Any) -> Any:
        with self._lock:
            try:
                return serve(request)
            except Refusal as refusal:
                return _refused(response_type, refusal, self._identity)

    def _describe(self, request: Any) -> DescribeResponse:
        parameters = self._base_for(request.kind)
        as_it_is = not request.kind  # not what it would be
        return DescribeResponse(
            success=True,
            instance_id=self._identity.instance_id,
            name=self._identity.name,
            title=self._identity.title,
            version=self._identity.version,
            parameters=_parameter_messages(parameters),
            parameter_descriptors=self._descriptors,
            start_tolerance=self._identity.start_tolerance,
            parameters_hash=_hash(parameters) if as_it_is else "",
            provenance=_provenance() if as_it_is else "",
            frame_prefix=self._frame_prefix,
            stamp=_time(self._stamp),
        )

    def _base_for(self, kind: str) -> Dict[str, Value]:
        """The parameters on top of which those of a request count."""
        if kind not in ("", self._identity.name):
            only = f"must be {self._identity.name}, the only kind that this node can be"
            raise Refusal(f"simulator '{kind}': {only}")
        return self._defaults if kind else self._parameters

    def _reset(self, request: Any) -> ResetResponse:
        if self._last is not None and request.stamp and request == self._last_request:
            return self._last
        start = _start(request)
        stamp = self._stamp if request.silent else self._next_stamp(request)
        self._token = ""
        state = self._simulate(
            "reset", lambda: _started(self._simulator, start, self._start_tolerance)
        )
        self._token = request.token
        self._silent = request.silent
        self._episode = request.episode
        self._horizon = request.horizon or HORIZON
        self._steps = 0
        self._stamp = stamp
        self._last = ResetResponse(
            success=True,
            instance_id=self._identity.instance_id,
            stamp=_time(stamp),
            state=state,
            parameters_hash=_hash(self._parameters),
        )
        self._last_request = request
        self._observe((0.0, 0.0))
        return self._last

    def _step(self, request: Any) -> StepResponse:
        self._require_hold(request.token)
        if self._closed is not None:
            raise Refusal(self._closed)
        if request.episode != self._episode:
            raise Refusal(f"episode {request.episode}: must be {self._episode}, the one under way")
        if isinstance(self._last, StepResponse) and request.step == self._last.step:
            taken = self._last_request
            if (request.action, request.stamp) != (taken.action, taken.stamp):
                raise Refusal(f"step {request.step}: was taken with another action or stamp")
            return self._last
        if request.step not in (NEXT, self._steps):
            raise Refusal(f"step {request.step}: expected {self._steps}")
        if self._steps >= self._horizon:
            raise Refusal(
                f"step {self._steps}: the horizon of {self._horizon} control steps is reached"
            )
        if not all(map(math.isfinite, request.action)):
            raise Refusal("action ({}, {}): must be finite".format(*request.action))
        stamp = self._stamp if self._silent else self._next_stamp(request)
        action = [min(max(axis, -ACTION_LIMIT), ACTION_LIMIT) for axis in request.action]
        state = self._simulate("step", lambda: _stepped(self._simulator, np.array(action)))
        self._stamp = stamp
        self._last = StepResponse(
            success=True,
            instance_id=self._identity.instance_id,
            stamp=_time(stamp),
            step=self._steps,
            state=state,
        )
        self._steps += 1
        self._last_request = request
        self._observe(action)
        return self._last

    def _configure(self, request: Any) -> ConfigureResponse:
        if self._last is not None and request == self._last_request:
            return self._last
        self._require_hold(request.token)
        mid_episode = self._closed is None and self._steps < self._horizon
        if mid_episode and not request.end_episode:
            raise Refusal(
                f"configure in mid-episode, after {self._steps} of {self._horizon} control steps:"
                " set end_episode to end it"
            )
        base = self._base_for(request.kind)
        _require_once(request.parameters)
        changes = {
            change.name: _from_text(change.value, base.get(change.name))
            for change in request.parameters
        }
        parameters = merged(base, changes)
        self._simulator = _made(self._make, parameters)
        self._parameters = parameters
        self._token = ""
        self._close("step after configure: the world needs a reset")
        self._last = ConfigureResponse(
            success=True,
            instance_id=self._identity.instance_id,
            parameters=_parameter_messages(parameters),
            parameters_hash=_hash(parameters),
        )
        self._last_request = request
        return self._last

    def _require_hold(self, token: str) -> None:
        if token == self._token:
            return
        if token:
            message = (
                "the world was reset by another caller, or its episode has ended: reset it to go on"
            )
        else:
            message = (
                "the world is held by another caller:"
                " wait for its end, or take the world over by a reset"
            )
        raise Refusal(message, ExitCode.RUNTIME_FAULT)

    def _simulate(self, what: str, call: Callable[[], WorldState]) -> WorldStateMessage:
        """The state after `call`. If that fails, the world needs a reset."""
        self._close("step after a failure: the world needs a reset")
        try:
            state = _state_message(call())
        except FOREIGN as error:
            raise Refusal(f"{what}: {_reported(error)}", ExitCode.RUNTIME_FAULT) from error
        self._closed = None
        return state

    def _close(self, reason: str) -> None:
        self._closed, self._last = reason, None

    def _next_stamp(self, request: Any) -> int:
        stamp: int = request.stamp.to_nsec() or self._stamp + STAMP_STEP
        if stamp <= self._stamp:
            raise Refusal(
                f"stamp {_seconds(stamp)}: must be above {_seconds(self._stamp)}, the last one [s]"
            )
        if request.stamp.secs >= (STAMP_LIMIT if request.token else STAMP_LIMIT_BY_HAND):
            limit = "2^32 - 10^6 [s]" if request.token else "2^31 [s] without a token"
            raise Refusal(f"stamp {_seconds(stamp)}: must be below {limit}")
        return stamp

    def _observe(self, action: Sequence[float]) -> None:
        if self._silent:
            return
        update = WorldStateStamped(
            episode=self._episode, step=self._steps, action=action, state=self._last.state
        )
        update.header.stamp = self._last.stamp
        update.header.frame_id = f"{self._frame_prefix}/table"
        self._observer(update)


class PolicySession:
    """A served policy without a memory: asked again, it answers the same."""

    def __init__(self, act: Act, identity: Identity) -> None:
        self._act = act
        self._identity = identity
        self._lock = threading.Lock()

    def act(self, request: Any) -> ActResponse:
        with self._lock:
            try:
                actions = self._actions(request.queries)
            except Refusal as refusal:
                return _refused(ActResponse, refusal, self._identity)
        return ActResponse(
            success=True, instance_id=self._identity.instance_id, actions=actions.ravel().tolist()
        )

    def describe(self, _request: Any = None) -> DescribeResponse:
        return DescribeResponse(
            success=True,
            instance_id=self._identity.instance_id,
            name=self._identity.name,
            version=self._identity.version,
            provenance=_provenance(),
        )

    def _actions(self, queries: Sequence[Any]) -> np.ndarray:
        if not queries:
            return np.empty((0, 2), dtype=np.float32)
        observations = np.array([query.observation for query in queries], dtype=np.float32)
        for query, finite in zip(queries, np.isfinite(observations).all(axis=1)):
            if not finite:
                raise Refusal(f"rollout {query.rollout}: observation must be finite")
        try:
            actions = np.asarray(self._act(observations), dtype=np.float32)
        except FOREIGN as error:
            raise Refusal(f"act: {_reported(error)}", ExitCode.RUNTIME_FAULT) from error
        if actions.shape != (len(queries), 2):
            raise Refusal(
                f"act: shape {list(actions.shape)} of the actions: must be [{len(queries)}, 2]",
                ExitCode.BAD_DEPENDENCY,
            )
        return actions


class FailedStart:
    """What is left of a node that failed at start: the error, for whoever asks."""

    def __init__(self, failure: BaseException, identity: Identity) -> None:
        refused = failure if isinstance(failure, Refusal) else unforeseen(failure)
        self.message = str(refused)
        self.exit_code = refused.exit_code
        self._identity = identity

    def describe(self, _request: Any = None) -> DescribeResponse:
        return DescribeResponse(
            success=False,
            message=self.message,
            exit_code=self.exit_code,
            instance_id=self._identity.instance_id,
            name=self._identity.name,
            version=self._identity.version,
        )


def _require_once(parameters: Sequence[Any]) -> None:
    """One of the values of a parameter that is named twice would count without a word."""
    values: Dict[str, str] = {}
    for parameter in parameters:
        if parameter.name in values:
            both = f"{values[parameter.name]}, {parameter.value}"
            raise Refusal(f"parameter {parameter.name} {both}: must be set once")
        values[parameter.name] = parameter.value


def merged(
    parameters: Mapping[str, Value], changes: Mapping[str, object], namespace: str = ""
) -> Dict[str, Value]:
    """`changes` on top of `parameters`, whose types they must have; an integer is a real too."""
    result = dict(parameters)
    for name, value in changes.items():
        if name not in parameters:
            raise Refusal(
                f"parameter {namespace}{name}: unknown; "
                f"known: {', '.join(parameters) or 'none'}"
            )
        kind = type(parameters[name])
        if kind is float and type(value) is int:
            value = float(value)
        if type(value) is not kind or (isinstance(value, float) and not math.isfinite(value)):
            raise Refusal(f"parameter {namespace}{name} {value}: must be {KINDS[kind]}")
        result[name] = value  # type: ignore[assignment]
    return result


def unforeseen(failure: BaseException) -> Refusal:
    return Refusal(_reported(failure), ExitCode.INTERNAL_ERROR)


def _reported(failure: BaseException) -> str:
    """What happened and where, on one line; the whole traceback goes into the node's log."""
    trace = traceback.format_exception(type(failure), failure, failure.__traceback__)
    LOG.error("%s", "".join(trace))
    message = " ".join(str(failure).split())
    place = traceback.extract_tb(failure.__traceback__)[-1]
    return f"{type(failure).__name__}: {message} ({place.name}, line {place.lineno})"


def _made(make: Callable[..., Simulator], parameters: Mapping[str, Value]) -> Simulator:
    try:
        return make(**parameters)
    except ValueError as error:
        raise Refusal(" ".join(str(error).split())) from error
    except FOREIGN as error:
        raise unforeseen(error) from error


def _start(request: Any) -> WorldState:
    if len(request.start) > 1:
        raise Refusal(f"start: {len(request.start)} states; must be one, or none for the seed")
    if not request.start:
        return spawn(request.seed)
    message = request.start[0]
    numbers = {name: getattr(message, name) for name in message.__slots__}
    for name, number in numbers.items():
        if not math.isfinite(number):
            raise Refusal(f"start: {name} {number}: must be finite")
    _require_plausible(numbers, Refusal)
    if abs(message.tee_yaw) > PLAUSIBLE_YAW:  # beyond it a wrapped yaw says little
        raise Refusal(f"tee_yaw {message.tee_yaw}: must be within {PLAUSIBLE_YAW}")
    return WorldState(**{**numbers, "tee_yaw": wrap_angle(message.tee_yaw)})


def _state_message(state: WorldState) -> WorldStateMessage:
    """`state` as a message, checked: it comes from foreign code."""
    if not isinstance(state, WorldState):
        raise TypeError(f"returned {type(state).__name__}: must be WorldState")
    message = WorldStateMessage(**vars(state))
    for name, number in vars(state).items():
        if not math.isfinite(number):
            raise ValueError(f"{name} {number}: must be finite")
    if not -math.pi <= state.tee_yaw < math.pi:
        raise ValueError(f"tee_yaw {state.tee_yaw}: must be in [-pi, pi) rad")
    return message


def _started(simulator: Simulator, start: WorldState, tolerance: float) -> WorldState:
    """Resets the simulator, which must be where it was told to start then, to `tolerance`."""
    state = simulator.reset(start)
    if isinstance(state, WorldState):  # else it is refused as every state is
        for name in (*POSITIONS, "tee_yaw"):
            wanted, found = getattr(start, name), getattr(state, name)
            distance = abs(wrap_angle(found - wanted) if name == "tee_yaw" else found - wanted)
            if not distance <= tolerance:
                raise ValueError(f"{name} {found}: must be within {tolerance} of {wanted}")
        # Velocities may be projected onto what the simulator can represent; rest always can.
        if all(getattr(start, name) == 0.0 for name in VELOCITIES):
            for name in VELOCITIES:
                found = getattr(state, name)
                if not abs(found) <= tolerance:
                    raise ValueError(f"{name} {found}: must be within {tolerance} of 0")
    return state


def _stepped(simulator: Simulator, action: np.ndarray) -> WorldState:
    """Steps the simulator, which must not leave what is plausible."""
    state = simulator.step(action)
    if isinstance(state, WorldState):
        _require_plausible(vars(state), ValueError)
    return state


def _require_plausible(numbers: Mapping[str, float], error: Type[Exception]) -> None:
    """The numbers of a world state, by name."""
    limits = {name: PLAUSIBLE_DISTANCE for name in POSITIONS}
    limits.update({name: PLAUSIBLE_SPEED for name in SPEEDS}, tee_yaw_rate=PLAUSIBLE_YAW_RATE)
    for name, limit in limits.items():
        if abs(numbers[name]) > limit:
            raise error(f"{name} {numbers[name]}: must be within {limit}")


def _from_text(text: str, default: Optional[Value]) -> object:
    """The value that `text` stands for, if only it has the right type."""
    if isinstance(default, str):
        return text
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return text


def _to_text(value: Value) -> str:
    return value if isinstance(value, str) else json.dumps(value)


def _parameter_messages(parameters: Mapping[str, Value]) -> List[Parameter]:
    return [Parameter(name=name, value=_to_text(value)) for name, value in parameters.items()]


def _descriptor(name: str, default: Value) -> ParameterDescriptor:
    """What is known of a parameter by its default."""
    return ParameterDescriptor(
        name=name,
        type=TYPES[type(default)],
        default_value=_to_text(default),
        least=-math.inf,
        greatest=math.inf,
    )


def _hash(parameters: Mapping[str, Value]) -> str:
    if not parameters:
        return ""
    key = "".join(f"{name}={_to_text(value)}|" for name, value in parameters.items())
    return hashlib.sha256(key.encode()).hexdigest()[:12]


def _provenance() -> str:
    return json.dumps({"numpy": np.__version__, "python": platform.python_version()})


def _refused(response_type: Any, refusal: Refusal, identity: Identity) -> Any:
    return response_type(
        success=False,
        message=str(refusal),
        exit_code=refusal.exit_code,
        instance_id=identity.instance_id,
    )


def _time(nanoseconds: int) -> Time:
    return Time(*divmod(nanoseconds, NANOSECONDS))


def _seconds(nanoseconds: int) -> str:
    seconds, rest = divmod(nanoseconds, NANOSECONDS)
    return f"{seconds}.{rest:09}"
