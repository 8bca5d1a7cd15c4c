# SPDX-License-Identifier: BSD-3-Clause
"""The recipe of a training: what decides the weights, besides demonstrations and software."""

import math
from dataclasses import dataclass
from typing import Tuple

from pusht_task.error import Error

MODELS = ("mlp", "gru", "chunk", "flow")  # models.py has what they are


@dataclass(frozen=True)
class Recipe:
    """Hyperparameters of a training."""

    epochs: int = 600
    batch: int = 128  # examples: frames; of a recurrent model pieces of demonstrations
    learning_rate: float = 1e-3  # at the start; cosine to 0, one step an epoch
    seed: int = 0  # seed of split, initial weights, shuffles and noise
    threads: int = 1
    hidden: Tuple[int, int] = (512, 512)  # units
    validation_fraction: float = 0.1  # share of the demonstrations
    model: str = MODELS[0]

    def check(self) -> None:
        """Raises Error for the first value that breaks its rule."""
        for name in ("epochs", "batch", "threads"):
            if getattr(self, name) < 1:
                raise Error(f"{name} is {getattr(self, name)}; it must be at least 1")
        if min(self.hidden) < 1:
            raise Error(f"hidden is {list(self.hidden)}; both sizes must be at least 1")
        if not (math.isfinite(self.learning_rate) and self.learning_rate > 0):
            raise Error(f"lr is {self.learning_rate}; it must be finite and greater than 0")
        if not 0 <= self.seed < 2**63:
            raise Error(f"seed is {self.seed}; it must be in [0, 2^63)")
        if self.model not in MODELS:
            raise Error(f"model is {self.model}; it must be one of {', '.join(MODELS)}")
