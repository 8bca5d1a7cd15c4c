# SPDX-License-Identifier: BSD-3-Clause
"""The recipe of a training: what decides the weights, besides demonstrations and software."""

from dataclasses import dataclass
from typing import Tuple

from pusht_task.error import Error, clipped

MODELS = ("mlp", "gru", "chunk", "flow")  # models.py has what they are
MOST = {"epochs": 1_000_000, "batch": 1_000_000, "threads": 1024}  # slips of the hand are more
MOST_HIDDEN = 10_000  # units of a layer: weights of 400 MB between two
LARGEST_RATE = 10.0


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
        for name, most in MOST.items():
            value = getattr(self, name)
            if not 1 <= value <= most:
                shown = clipped(str(value), 40)
                raise Error(f"{name} is {shown}; it must be at least 1 and at most {most}")
        if not 1 <= min(self.hidden) <= max(self.hidden) <= MOST_HIDDEN:
            rule = f"both sizes must be at least 1 and at most {MOST_HIDDEN}"
            raise Error(f"hidden is {clipped(str(list(self.hidden)), 80)}; {rule}")
        if not 0 < self.learning_rate <= LARGEST_RATE:
            rule = f"it must be greater than 0 and at most {LARGEST_RATE}"
            raise Error(f"lr is {self.learning_rate}; {rule}")
        if not 0 <= self.seed < 2**63:
            raise Error(f"seed is {self.seed}; it must be in [0, 2^63)")
        if self.model not in MODELS:
            raise Error(f"model is {self.model}; it must be one of {', '.join(MODELS)}")
