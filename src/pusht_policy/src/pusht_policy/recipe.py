# SPDX-License-Identifier: BSD-3-Clause
"""The recipe of a training: what decides the weights, besides demonstrations and software."""

from dataclasses import dataclass
from typing import Tuple

from pusht_task.error import Error, clipped

INTERFACES = ("full_circle", "gym_state", "gym_keypoints")
MOST_STEPS = 1000  # observations and actions of a chunk
CHUNKED = ("chunk", "flow", "flow_x")
MODELS = ("mlp", "gru", *CHUNKED)  # models.py has what they are
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
    interface: str = INTERFACES[0]  # what the policy sees (interface.py)
    chunk: Tuple[int, int, int] = (2, 8, 1)  # of the models CHUNKED: observations, actions,
    # and how many of them are executed before the next chunk, unless a run says otherwise

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
        if self.interface not in INTERFACES:
            known = ", ".join(INTERFACES)
            raise Error(f"interface is {self.interface}; it must be one of {known}")
        if self.interface != INTERFACES[0] and self.model == "gru":
            raise Error(f"model is gru; with the interface {self.interface} it must be another")
        if self.chunk != Recipe.chunk and self.model not in CHUNKED:
            raise Error(f"chunk: must be left out with the model {self.model}")
        observations, actions, execute = self.chunk
        if not (1 <= observations <= MOST_STEPS and 1 <= execute <= actions <= MOST_STEPS):
            rule = f"observations, actions and executed ones must be 1 to {MOST_STEPS}, E <= K"
            raise Error(f"chunk is {clipped(str(list(self.chunk)), 80)}; {rule}")
