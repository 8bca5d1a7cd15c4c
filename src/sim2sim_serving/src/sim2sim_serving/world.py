# SPDX-License-Identifier: BSD-3-Clause
"""A simulator in Python, and the checks of what it returns."""

import math
from typing import Any, Callable, Mapping, Protocol, Type

import numpy as np
from pusht_msgs.msg import WorldState as WorldStateMessage  # type: ignore[import]

from pusht_task.error import Error, clipped
from pusht_task.task import (
    FULL_CIRCLE,
    PLAUSIBLE_DISTANCE,
    PLAUSIBLE_SPEED,
    PLAUSIBLE_YAW,
    PLAUSIBLE_YAW_RATE,
    WorldState,
    spawn,
    wrap_angle,
)
from sim2sim_serving.parameters import Value
from sim2sim_serving.session import FOREIGN, unforeseen

POSITIONS = ("pusher_x", "pusher_y", "tee_x", "tee_y")
SPEEDS = ("pusher_vx", "pusher_vy", "tee_vx", "tee_vy")
VELOCITIES = (*SPEEDS, "tee_yaw_rate")


class Simulator(Protocol):
    """A world. After an exception it is reset before it is stepped again."""

    def reset(self, start: WorldState) -> WorldState:
        """Starts from `start`, clears all hidden state; returns the start as it is represented."""

    def step(self, action: np.ndarray) -> WorldState:
        """Takes a control step with the commanded pusher velocity [m/s], float64 [2] in [-1, 1].

        A simulator that holds other tasks has a parameter `task`, by default that of its own: the
        name of one, or the JSON of its file. Actions are then that task's, such as positions [px].
        """


def made(make: Callable[..., Simulator], parameters: Mapping[str, Value]) -> Simulator:
    """The simulator that `make` gives. Raises Error; a ValueError of `make` is bad input."""
    try:
        return make(**parameters)
    except ValueError as error:
        raise Error(" ".join(str(error).split())) from error
    except FOREIGN as error:
        raise unforeseen(error) from error


def start_of(request: Any, task: str) -> WorldState:
    """The initial state that a reset asks for. Raises Error."""
    if len(request.start) > 1:
        raise Error(f"start: {len(request.start)} states; must be one, or none for the seed")
    if not request.start:
        if task != FULL_CIRCLE:
            name = clipped(task, 40)
            raise Error(f"start: must be given in the task {name}: its seeds are not drawn here")
        return spawn(request.seed)
    message = request.start[0]
    numbers = {name: getattr(message, name) for name in message.__slots__}
    for name, number in numbers.items():
        if not math.isfinite(number):
            raise Error(f"start: {name} {number}: must be finite")
    _require_plausible(numbers, Error)
    if abs(message.tee_yaw) > PLAUSIBLE_YAW:  # beyond it a wrapped yaw says little
        raise Error(f"tee_yaw {message.tee_yaw}: must be within {PLAUSIBLE_YAW}")
    return WorldState(**{**numbers, "tee_yaw": wrap_angle(message.tee_yaw)})


def started(simulator: Simulator, start: WorldState, tolerance: float) -> WorldState:
    """Resets the simulator and checks that it starts at `start`, to `tolerance`."""
    state = simulator.reset(start)
    if isinstance(state, WorldState):  # any other type is refused where states are
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


def stepped(simulator: Simulator, action: np.ndarray) -> WorldState:
    """Steps the simulator and checks that its state is plausible."""
    state = simulator.step(action)
    if isinstance(state, WorldState):
        _require_plausible(vars(state), ValueError)
    return state


def state_message(state: WorldState) -> WorldStateMessage:
    """The message of a state from foreign code, which is checked."""
    if not isinstance(state, WorldState):
        raise TypeError(f"returned {type(state).__name__}: must be WorldState")
    message = WorldStateMessage(**vars(state))
    for name, number in vars(state).items():
        if not math.isfinite(number):
            raise ValueError(f"{name} {number}: must be finite")
    if not -math.pi <= state.tee_yaw < math.pi:
        raise ValueError(f"tee_yaw {state.tee_yaw}: must be in [-pi, pi) rad")
    return message


def _require_plausible(numbers: Mapping[str, float], error: Type[Exception]) -> None:
    """Raises `error` for numbers of a world state, by name, beyond the plausible range."""
    limits = {name: PLAUSIBLE_DISTANCE for name in POSITIONS}
    limits.update({name: PLAUSIBLE_SPEED for name in SPEEDS}, tee_yaw_rate=PLAUSIBLE_YAW_RATE)
    for name, limit in limits.items():
        if abs(numbers[name]) > limit:
            raise error(f"{name} {numbers[name]}: must be within {limit}")
