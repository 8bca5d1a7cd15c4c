# SPDX-License-Identifier: BSD-3-Clause
"""Seeds from which episodes of a world start."""

import secrets
from typing import Optional

import numpy as np


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
