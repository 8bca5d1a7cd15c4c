# SPDX-License-Identifier: BSD-3-Clause
"""The rules of a served simulator, without a node: requests in, replies out."""

import math
import threading
from typing import Any, Callable, Dict, Mapping, Optional, Sequence

import numpy as np
from genpy import Time  # type: ignore[import]
from pusht_msgs.msg import WorldState as WorldStateMessage  # type: ignore[import]
from pusht_msgs.msg import WorldStateStamped
from pusht_msgs.srv import (  # type: ignore[import]
    ConfigureResponse,
    DescribeRequest,
    DescribeResponse,
    ResetResponse,
    StepResponse,
)

from pusht_task.error import Error, ExitCode
from pusht_task.task import (
    CONTROL_STEP,
    FULL_CIRCLE,
    HORIZON,
    START_TOLERANCE,
    WorldState,
    action_limit_of,
)
from sim2sim_serving.parameters import (
    Value,
    descriptor,
    from_text,
    hash_of,
    merged,
    parameter_messages,
    require_once,
)
from sim2sim_serving.session import FOREIGN, TASK, Identity, provenance, refused, reported
from sim2sim_serving.world import Simulator, made, start_of, started, state_message, stepped

NANOSECONDS = 10**9  # in a second
STAMP_STEP = round(CONTROL_STEP * NANOSECONDS)  # [ns]
# [s] What a caller may ask for. By hand no more than half of what a stamp can be: the runs that
# follow name stamps too, and a slip must not spoil the world for them.
STAMP_LIMIT_BY_HAND = 2**31
STAMP_LIMIT = 2**32 - 10**6
NEXT = -1  # index of a step: stands for the next one


class SimulatorSession:
    """A served world: which requests it accepts, in which order, and what it answers."""

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
            raise Error(f"start_tolerance {said}: must be above 0 and at most {START_TOLERANCE}")
        self._start_tolerance = said or START_TOLERANCE
        self._make = make
        self._defaults = dict(defaults or parameters)
        self._descriptors = [descriptor(name, value) for name, value in self._defaults.items()]
        self._parameters = dict(parameters)
        self._action_limit = action_limit_of(_task_of(self._parameters))
        self._simulator = made(make, self._parameters)
        self._identity = identity
        self._frame_prefix = frame_prefix
        self._observer = observer
        self._lock = threading.Lock()
        self._stamp = 0  # the last one used [ns]
        self._closed: Optional[str] = "step before reset: call reset first"  # why no step is taken
        self._episode = 0
        self._horizon = 0
        self._steps = 0  # taken in the episode
        self._token = ""  # token of the caller that holds the world; empty: there is none
        self._silent = False  # whether the episode is published
        self._last_request: Any = None  # the last one that was taken
        self._last: Any = None  # answer to it

    @property
    def parameters(self) -> Dict[str, Value]:
        """Values in force."""
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
            except Error as refusal:
                return refused(response_type, refusal, self._identity)

    def _describe(self, request: Any) -> DescribeResponse:
        parameters = self._base_for(request.kind)
        as_it_is = not request.kind  # not what it would be
        return DescribeResponse(
            success=True,
            instance_id=self._identity.instance_id,
            name=self._identity.name,
            title=self._identity.title,
            version=self._identity.version,
            parameters=parameter_messages(parameters),
            parameter_descriptors=self._descriptors,
            start_tolerance=self._identity.start_tolerance,
            parameters_hash=hash_of(parameters) if as_it_is else "",
            provenance=provenance({}) if as_it_is else "",
            frame_prefix=self._frame_prefix,
            stamp=_time(self._stamp),
        )

    def _base_for(self, kind: str) -> Dict[str, Value]:
        """The parameters on top of which those of a request count."""
        if kind not in ("", self._identity.name):
            only = f"must be {self._identity.name}, the only kind that this node can be"
            raise Error(f"simulator '{kind}': {only}")
        return self._defaults if kind else self._parameters

    def _reset(self, request: Any) -> ResetResponse:
        if self._last is not None and request.stamp and request == self._last_request:
            return self._last
        start = start_of(request, _task_of(self._parameters))
        stamp = self._stamp if request.silent else self._next_stamp(request)
        self._token = ""
        state = self._simulate(
            "reset", lambda: started(self._simulator, start, self._start_tolerance)
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
            parameters_hash=hash_of(self._parameters),
        )
        self._last_request = request
        self._observe((0.0, 0.0))
        return self._last

    def _step(self, request: Any) -> StepResponse:
        self._require_hold(request.token)
        if self._closed is not None:
            raise Error(self._closed)
        if request.episode != self._episode:
            raise Error(f"episode {request.episode}: must be {self._episode}, the one under way")
        if isinstance(self._last, StepResponse) and request.step == self._last.step:
            taken = self._last_request
            if (request.action, request.stamp) != (taken.action, taken.stamp):
                raise Error(f"step {request.step}: was taken with another action or stamp")
            return self._last
        if request.step not in (NEXT, self._steps):
            raise Error(f"step {request.step}: expected {self._steps}")
        if self._steps >= self._horizon:
            raise Error(
                f"step {self._steps}: the horizon of {self._horizon} control steps is reached"
            )
        if not all(map(math.isfinite, request.action)):
            raise Error("action ({}, {}): must be finite".format(*request.action))
        stamp = self._stamp if self._silent else self._next_stamp(request)
        action = list(request.action)
        if self._action_limit is not None:
            action = list(np.clip(action, -self._action_limit, self._action_limit))
        state = self._simulate("step", lambda: stepped(self._simulator, np.array(action)))
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
            raise Error(
                f"configure in mid-episode, after {self._steps} of {self._horizon} control steps:"
                " set end_episode to end it"
            )
        base = self._base_for(request.kind)
        require_once(request.parameters)
        changes = {
            change.name: from_text(change.value, base.get(change.name))
            for change in request.parameters
        }
        parameters = merged(base, changes)
        limit = action_limit_of(_task_of(parameters))
        self._simulator = made(self._make, parameters)
        self._parameters, self._action_limit = parameters, limit
        self._token = ""
        self._close("step after configure: the world needs a reset")
        self._last = ConfigureResponse(
            success=True,
            instance_id=self._identity.instance_id,
            parameters=parameter_messages(parameters),
            parameters_hash=hash_of(parameters),
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
        raise Error(message, ExitCode.RUNTIME_FAULT)

    def _simulate(self, what: str, call: Callable[[], WorldState]) -> WorldStateMessage:
        """The state after `call`. If that fails, the world needs a reset."""
        self._close("step after a failure: the world needs a reset")
        try:
            state = state_message(call())
        except FOREIGN as error:
            raise Error(f"{what}: {reported(error)}", ExitCode.RUNTIME_FAULT) from error
        self._closed = None
        return state

    def _close(self, reason: str) -> None:
        self._closed, self._last = reason, None

    def _next_stamp(self, request: Any) -> int:
        stamp: int = request.stamp.to_nsec() or self._stamp + STAMP_STEP
        if stamp <= self._stamp:
            raise Error(
                f"stamp {_seconds(stamp)}: must be above {_seconds(self._stamp)}, the last one [s]"
            )
        if request.stamp.secs >= (STAMP_LIMIT if request.token else STAMP_LIMIT_BY_HAND):
            limit = "2^32 - 10^6 [s]" if request.token else "2^31 [s] without a token"
            raise Error(f"stamp {_seconds(stamp)}: must be below {limit}")
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


def _task_of(parameters: Mapping[str, Value]) -> str:
    """The task that a simulator with these parameters is of."""
    return str(parameters.get(TASK, FULL_CIRCLE))


def _time(nanoseconds: int) -> Time:
    return Time(*divmod(nanoseconds, NANOSECONDS))


def _seconds(nanoseconds: int) -> str:
    seconds, rest = divmod(nanoseconds, NANOSECONDS)
    return f"{seconds}.{rest:09}"
