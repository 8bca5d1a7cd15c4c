# SPDX-License-Identifier: BSD-3-Clause
"""What worlds take of Gymnasium, where it can be imported (from 1.1 on), and what stands in for it
where it cannot."""

from typing import TYPE_CHECKING, Any, Dict, Iterable, Mapping, Optional, Tuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sim2sim._sim2sim import HORIZON

NEXT_STEP: Any = "NextStep"  # the value of AutoresetMode.NEXT_STEP


class Env:
    """Stands in for gymnasium.Env, as far as worlds need it."""

    def reset(
        self, *, seed: Optional[int] = None, options: Optional[Mapping[str, Any]] = None
    ) -> Any:
        """Gymnasium's seeds the generator of the base class here; there is none."""

    def close(self) -> None:
        """Does nothing: a world holds memory alone."""

    @property
    def unwrapped(self) -> Any:
        """The world itself."""
        return self


class VectorEnv(Env):
    """Stands in for gymnasium.vector.VectorEnv."""


class Box:
    """Arrays between two bounds, with what Gymnasium's space of that name has for reading it."""

    def __init__(
        self,
        low: ArrayLike,
        high: ArrayLike,
        shape: Optional[Tuple[int, ...]] = None,
        dtype: Any = np.float32,
    ) -> None:
        self.dtype = np.dtype(dtype)
        self.shape = np.shape(low) if shape is None else shape
        self.low = np.full(self.shape, low, self.dtype)
        self.high = np.full(self.shape, high, self.dtype)
        self.seed(None)

    def seed(self, seed: Optional[int] = None) -> Any:
        """Sets the generator of sample()."""
        self._random = np.random.default_rng(seed)

    def sample(self) -> NDArray[Any]:
        """An array drawn uniformly between the bounds; normally distributed without bounds."""
        if not np.isfinite(self.low).all():
            return self._random.normal(size=self.shape).astype(self.dtype)
        if self.dtype.kind == "u":
            return self._random.integers(self.low, self.high, dtype=self.dtype, endpoint=True)
        return self._random.uniform(self.low, self.high).astype(self.dtype)

    def contains(self, array: Any) -> bool:
        """Whether an array has the shape and lies between the bounds."""
        array = np.asarray(array)
        return bool(
            array.shape == self.shape and (self.low <= array).all() and (array <= self.high).all()
        )

    def __repr__(self) -> str:
        return f"Box({self.low.min()}, {self.high.max()}, {self.shape}, {self.dtype})"


class DictSpace(Dict[str, Box]):
    """Stands in for gymnasium.spaces.Dict."""

    def seed(self, seed: Optional[int] = None) -> Any:
        """Sets the generators of sample()."""
        for space in self.values():
            space.seed(seed)

    def sample(self) -> Dict[str, NDArray[Any]]:
        """An array of each space."""
        return {name: space.sample() for name, space in self.items()}

    def contains(self, arrays: Any) -> bool:
        """Whether there is an array of each space."""
        return set(arrays) == set(self) and all(
            space.contains(arrays[name]) for name, space in self.items()
        )


def register(kinds: Iterable[str]) -> None:
    """Names the worlds of each kind for gymnasium.make() and make_vec()."""


def register_gym_pusht(name: str) -> None:
    """Names gym-pusht's environment for gymnasium.make() and make_vec(), unless it has a name."""


if not TYPE_CHECKING:  # the types are those of what stands in
    try:
        from gymnasium.vector import AutoresetMode, VectorEnv  # noqa: F401,F811

        from gymnasium import Env, envs  # noqa: F811
        from gymnasium.spaces import Box  # noqa: F401,F811
        from gymnasium.spaces import Dict as DictSpace  # noqa: F401,F811
    except ImportError:
        pass
    else:
        NEXT_STEP = AutoresetMode.NEXT_STEP

        def register(kinds: Iterable[str]) -> None:  # noqa: F811
            for kind in kinds:
                envs.register(
                    f"sim2sim/PushT-{kind}-v0",
                    entry_point="sim2sim.world:World",
                    vector_entry_point="sim2sim.world:VectorWorld",
                    kwargs={"kind": kind},
                )

        def register_gym_pusht(name: str) -> None:  # noqa: F811
            if name not in envs.registry:
                envs.register(
                    name,
                    entry_point="sim2sim.pixel_world:PushTEnv",
                    vector_entry_point="sim2sim.pixel_world:PushTVectorEnv",
                    max_episode_steps=HORIZON,
                    kwargs={"obs_type": "state"},
                )
