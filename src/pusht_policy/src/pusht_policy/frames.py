# SPDX-License-Identifier: BSD-3-Clause
"""Frames of demonstrations: which are to train and which to validate, as tensors, and cut into what
a model learns from."""

from dataclasses import dataclass
from typing import Iterator, List, Sequence, Tuple

import numpy as np
import torch
from torch import Tensor

from pusht_policy.demonstrations import Demonstration
from pusht_policy.interface import INTERFACES, Interface
from pusht_policy.recipe import Recipe
from pusht_task.error import Error


def split(
    demonstrations: Sequence[Demonstration], recipe: Recipe, generator: torch.Generator
) -> Tuple[List[Demonstration], List[Demonstration]]:
    """Whole demonstrations for training and for validation, by a seeded permutation."""
    count = len(demonstrations)
    if count < 2:
        raise Error(f"demonstrations: {count}; at least 2 are needed (1 to validate)")
    validation_count = max(1, round(recipe.validation_fraction * count))
    chosen = set(torch.randperm(count, generator=generator)[:validation_count].tolist())
    training = [d for i, d in enumerate(demonstrations) if i not in chosen]
    return training, [demonstrations[i] for i in sorted(chosen)]


@dataclass(frozen=True)
class Frames:
    """Frames of some demonstrations, one after the other, in SI units or normalized."""

    observations: Tensor  # float32 [n, 10]
    actions: Tensor  # float32 [n, 2], m/s
    first: Tensor  # int64 [n], index of the first frame of the same demonstration
    last: Tensor  # int64 [n], index of its last frame

    def __len__(self) -> int:
        return len(self.observations)


@dataclass(frozen=True)
class Examples:
    """What a network learns from, a row for each example, as the network sees it."""

    inputs: Tensor  # float32 [m, ...]
    targets: Tensor  # float32 [m, ...]
    lengths: Tensor  # int64 [m], control steps of an example that count

    def __len__(self) -> int:
        return len(self.inputs)

    def frames(self) -> int:
        """Control steps of all examples that count."""
        return int(self.lengths.sum())

    def split(self, size: int) -> Iterator["Examples"]:
        """Examples in batches of at most so many."""
        parts = (part.split(size) for part in (self.inputs, self.targets, self.lengths))
        return (Examples(*batch) for batch in zip(*parts))

    def rows(self, indices: Tensor) -> "Examples":
        """Examples in another order, or some of them."""
        return Examples(self.inputs[indices], self.targets[indices], self.lengths[indices])


def frames_of(
    demonstrations: Sequence[Demonstration], interface: Interface = INTERFACES["full_circle"]
) -> Frames:
    """Frames of all demonstrations, one after the other, as a policy of the interface sees them."""
    lengths = torch.tensor([len(d.actions) for d in demonstrations])
    last = lengths.cumsum(0) - 1
    return Frames(
        torch.from_numpy(interface.seen(np.concatenate([d.observations for d in demonstrations]))),
        torch.from_numpy(np.concatenate([d.actions for d in demonstrations])),
        (last - lengths + 1).repeat_interleave(lengths),
        last.repeat_interleave(lengths),
    )


def windows(frames: Frames, observations: int, actions: int) -> Examples:
    """An example for each frame: the observations up to it, [n, observations, 10], and the actions
    from it on, [n, actions, 2]. As in Diffusion Policy, the first observation is repeated before a
    demonstration begins, and the last action after its end."""
    now = torch.arange(len(frames)).unsqueeze(1)
    past = torch.maximum(now + torch.arange(1 - observations, 1), frames.first.unsqueeze(1))
    ahead = torch.minimum(now + torch.arange(actions), frames.last.unsqueeze(1))
    lengths = torch.ones(len(frames), dtype=torch.int64)
    return Examples(frames.observations[past], frames.actions[ahead], lengths)


def pieces(frames: Frames, length: int) -> Examples:
    """Demonstrations cut into sequences of so many steps, [n, length, 10] and [n, length, 2]. The
    last one of a demonstration may be shorter; then the steps after its end do not count."""
    now = torch.arange(len(frames))
    first = now[(now - frames.first) % length == 0]
    last = torch.minimum(first + length - 1, frames.last[first])
    steps = torch.minimum(first.unsqueeze(1) + torch.arange(length), last.unsqueeze(1))
    return Examples(frames.observations[steps], frames.actions[steps], last - first + 1)
