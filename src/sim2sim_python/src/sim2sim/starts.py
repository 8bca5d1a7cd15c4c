# SPDX-License-Identifier: BSD-3-Clause
"""Seeds from which episodes of a world start."""

import secrets
from typing import List, Optional, Sequence, Union

import numpy as np

from sim2sim.checks import checked_integer
from sim2sim.errors import InvalidInput

Seeds = Union[None, int, Sequence[Optional[int]]]  # of a reset of many worlds


def seeds_of(seed: Seeds, worlds: int, greatest: int) -> List[Optional[int]]:
    """A seed for each world: `seed` and those that follow it, or a list that has one for each;
    None: it is drawn."""
    if seed is None:
        return [None] * worlds
    if isinstance(seed, (list, tuple, np.ndarray)):
        if len(seed) != worlds:
            raise InvalidInput(f"seed: {len(seed)} seeds; must be {worlds}, or one")
        return [None if one is None else checked_integer("seed", one, 0, greatest) for one in seed]
    first = checked_integer("seed", seed, 0, greatest + 1 - worlds)
    return [first + world for world in range(worlds)]


class Starts:
    """Spawn seeds of one world: the given ones, and those that follow from them.

    A reset without a seed draws one below the task's first, so it is none of those from which
    comparisons start.
    """

    def __init__(self, first_of_comparisons: int) -> None:
        self._first_of_comparisons = first_of_comparisons
        self.random: Optional[np.random.Generator] = None

    def given(self, seed: int) -> None:
        self.random = np.random.default_rng((seed, 1))

    def drawn(self) -> int:
        if self.random is None:
            self.random = np.random.default_rng(secrets.randbits(64))
        return int(self.random.integers(self._first_of_comparisons))
