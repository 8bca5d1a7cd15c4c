# SPDX-License-Identifier: BSD-3-Clause
"""Simulators that are classes of a program, as the extension takes them."""

import inspect
import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Callable, Dict, List, Mapping, Optional, Union

from sim2sim.checks import checked_mapping, checked_number, checked_text
from sim2sim.errors import InvalidInput

if TYPE_CHECKING:
    from sim2sim_serving.world import Simulator

Value = Union[bool, int, float, str]  # value of a parameter


@dataclass(frozen=True)
class Worlds:
    """A simulator in Python: how a world is made, and what its results are called."""

    make: "Callable[..., Simulator]"
    name: str
    version: str = ""  # empty: it has none
    title: str = ""  # for people; empty: the name
    start_tolerance: float = 0.0  # [m, rad, m/s, rad/s]; 0: it does not say
    parameters: Mapping[str, Value] = field(default_factory=dict)  # with their defaults


def worlds(
    make: "Callable[..., Simulator]",
    *,
    name: Optional[str] = None,
    version: str = "",
    title: str = "",
    start_tolerance: float = 0.0,
    parameters: Optional[Mapping[str, Value]] = None,
) -> Worlds:
    """A simulator of compare(), from what `sim2sim_serving.ros.serve_simulator` serves as a node.

    `make(**parameters)`, called once for each world, gives an object with

    - `reset(start)`: starts the world at `start` and clears all hidden state; returns the start as
      it represents it, poses to `start_tolerance` (0: 1e-6);
    - `step(action)`: takes a control step of 0.1 s with the commanded pusher velocity [m/s],
      float64 [2] in [-1, 1], and returns the state after it. A class that holds other tasks has a
      keyword `task`: the name of one, or its JSON. Actions are then that task's, such as
      positions [px].

    States are `pusht_task.task.WorldState`: poses and velocities in the frame of the table, in m,
    rad and s, with a yaw in [-pi, pi). After an exception a world is reset before it is stepped.

    `name` is a word, by default that of the class. `parameters` are names with their defaults, by
    default those of the keywords of `make`. With a `version` a run can go on.
    """
    if not callable(make):
        raise InvalidInput(f"worlds {make!r}: must be a class, or a function that makes a world")
    known_as = getattr(make, "__name__", type(make).__name__) if name is None else name
    if not re.fullmatch(r"\w+", checked_text("name", known_as)):
        raise InvalidInput(f"name '{known_as}': must be a word; give one with sim2sim.worlds()")
    defaults = _defaults_of(make) if parameters is None else dict(parameters)
    for parameter, value in checked_mapping("parameters", defaults).items():
        if parameter == "task" and not isinstance(value, str):
            raise InvalidInput(f"task {value!r}: must be a text, the task in which a world begins")
        if not isinstance(value, (bool, int, float, str)):
            raise InvalidInput(f"{parameter} {value!r}: must be true or false, a number or a text")
    return Worlds(
        make,
        known_as,
        checked_text("version", version),
        checked_text("title", title),
        checked_number("start_tolerance", start_tolerance),
        defaults,
    )


def in_python(options: Dict[str, object], **roles: object) -> List[Worlds]:
    """Puts the names of simulators into `options`, by role; returns those that are in Python."""
    found: List[Worlds] = []
    for role, simulator in roles.items():
        if simulator is None or isinstance(simulator, str):
            options[role] = simulator
            continue
        asked = _worlds_of(role, simulator)
        options[role] = f"python:{asked.name}"
        if any(asked.name == other.name and asked != other for other in found):
            raise InvalidInput(f"{role} {asked.name}: must not have the name of another simulator")
        if asked not in found:
            found.append(asked)
    return found


def _worlds_of(role: str, simulator: object) -> Worlds:
    if isinstance(simulator, Worlds):
        return simulator
    if not callable(simulator):
        raise InvalidInput(
            f"{role} {simulator!r}: must be a name, a class with reset() and step(), or "
            "sim2sim.worlds(...)"
        )
    return worlds(simulator)


def _defaults_of(make: Callable[..., object]) -> Dict[str, Value]:
    defaults: Dict[str, Value] = {}
    for parameter in inspect.signature(make).parameters.values():
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            continue
        if parameter.default is parameter.empty:
            raise InvalidInput(
                f"parameter {parameter.name}: must have a default; give one with "
                "sim2sim.worlds(..., parameters={...})"
            )
        defaults[parameter.name] = parameter.default
    return defaults
