# SPDX-License-Identifier: BSD-3-Clause
"""What an observation of gym-pusht holds, by its `obs_type`."""

import math
from typing import Any, Callable, Dict, Mapping, Tuple

import numpy as np
from numpy.typing import NDArray

from sim2sim import renderers
from sim2sim._sim2sim import gym_pusht_keypoints
from sim2sim.checks import checked_integer
from sim2sim.errors import InvalidInput
from sim2sim.gym import Box, DictSpace

Observation = Any  # an array, or a dict of them

SIDE = 512.0  # [px] of the window
GOAL = (256.0, 256.0, math.pi / 4)  # [px, px, rad] pose of the tee's origin
CORNERS = 16  # numbers
TURN = 2.0 * math.pi  # [rad]
LARGEST_IMAGE = 4096  # [px] along a side


def checked_side(name: str, value: object) -> int:
    return checked_integer(name, value, 1, LARGEST_IMAGE)


class Sight:
    """Observations of many worlds: spaces, and arrays whose rows are the worlds.

    `obs_type` is one of TYPES, `width` and `height` are the size of its images [px]. Raises
    InvalidInput for another type or size; BadDependency if images are asked for and pygame or
    OpenCV is not there.
    """

    TYPES = ("state", "environment_state_agent_pos", "pixels", "pixels_agent_pos")

    def __init__(self, obs_type: str, width: int = 96, height: int = 96) -> None:
        if obs_type not in self.TYPES:
            raise InvalidInput(f"obs_type {obs_type!r}: must be one of {', '.join(self.TYPES)}")
        self._size = (
            checked_side("observation_width", width),
            checked_side("observation_height", height),
        )
        arrays: Mapping[str, Callable[[NDArray[np.float64]], NDArray[Any]]] = {
            "state": _states,
            "environment_state": gym_pusht_keypoints,
            "agent_pos": _pushers,
            "pixels": self._pixels,
        }
        names = {
            "environment_state_agent_pos": ("environment_state", "agent_pos"),
            "pixels_agent_pos": ("pixels", "agent_pos"),
        }
        self.obs_type = obs_type
        self.is_dict = obs_type in names
        self._arrays = {name: arrays[name] for name in names.get(obs_type, (obs_type,))}
        self.has_pixels = "pixels" in self._arrays
        self._drawn: Dict[bytes, NDArray[np.uint8]] = {}  # images of the latest states
        if self.has_pixels:
            renderers.pictures()

    def space(self, *worlds: int) -> Any:
        """The space of an observation, or of a batch of so many."""
        spaces = {name: self._space(name, worlds) for name in self._arrays}
        return DictSpace(spaces) if self.is_dict else next(iter(spaces.values()))

    def of(self, states: NDArray[np.float64]) -> Observation:
        """Observations of worlds in these states [n, 7], as PixelWorlds.states."""
        arrays: Dict[str, Any] = {name: array(states) for name, array in self._arrays.items()}
        return arrays if self.is_dict else arrays[self.obs_type]

    def with_past(self, states: NDArray[np.float64]) -> Observation:
        """Observations of states [n, 7], or with their past [n, H, 7], by the same axes."""
        axes = states.shape[:-1]
        seen = self.of(states.reshape(-1, states.shape[-1]))
        if isinstance(seen, dict):
            return {name: array.reshape(*axes, *array.shape[1:]) for name, array in seen.items()}
        return seen.reshape(*axes, *seen.shape[1:])

    def __str__(self) -> str:
        """What decides the bytes of an observation, besides the state."""
        if not self.has_pixels:
            return self.obs_type
        width, height = self._size
        return f"{self.obs_type} {width} x {height}, {renderers.pictures().VERSIONS}"

    def first(self, observation: Observation) -> Observation:
        """The observation of the first world."""
        if isinstance(observation, dict):
            return {name: array[0] for name, array in observation.items()}
        return observation[0]

    def _space(self, name: str, worlds: Tuple[int, ...]) -> Any:
        width, height = self._size
        if name == "pixels":
            return Box(0, 255, (*worlds, height, width, 3), np.uint8)
        high = {
            "state": [SIDE, SIDE, SIDE, SIDE, TURN],
            "environment_state": [SIDE] * CORNERS,
            "agent_pos": [SIDE, SIDE],
        }[name]
        bound = np.broadcast_to(np.array(high), (*worlds, len(high)))
        return Box(np.zeros_like(bound), bound.copy(), dtype=np.float64)

    def _pixels(self, states: NDArray[np.float64]) -> NDArray[np.uint8]:
        """Images of the states. One that the last call had, as in a past, is not drawn again."""
        keys = [state.tobytes() for state in states]
        known = self._drawn
        if new := {key: row for row, key in enumerate(keys) if key not in known}:
            rows = states[list(new.values())]
            numbers = np.concatenate([_pushers(rows), gym_pusht_keypoints(rows)], axis=1)
            images = renderers.images(numbers, *self._size)
            known = {**known, **dict(zip(new, map(np.copy, images)))}  # a view keeps its batch
        self._drawn = {key: known[key] for key in keys}
        return np.stack([known[key] for key in keys])


def _pushers(states: NDArray[np.float64]) -> NDArray[np.float64]:
    return states[:, :2].copy()


def _states(states: NDArray[np.float64]) -> NDArray[np.float64]:
    """Pusher x, y, tee x, y [px], its angle in [0, 2 pi) [rad]."""
    return np.concatenate([states[:, :2], states[:, 4:6], states[:, 6:] % TURN], axis=1)
