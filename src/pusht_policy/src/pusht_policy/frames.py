# SPDX-License-Identifier: BSD-3-Clause
"""Frames of demonstrations: which are to train and which to validate, and as tensors."""

from dataclasses import dataclass
from typing import List, Sequence, Tuple

import numpy as np
import torch
from torch import Tensor

from pusht_policy.demonstrations import Demonstration
from pusht_policy.model import Policy, normalised
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
    """Frames of some demonstrations, in SI units."""

    observations: Tensor  # float32 [n, 10]
    actions: Tensor  # float32 [n, 2], m/s


@dataclass(frozen=True)
class NormalizedFrames:
    """Frames as the network sees them: inputs in [-1, 1], targets mapped likewise."""

    inputs: Tensor  # float32 [n, 10]
    targets: Tensor  # float32 [n, 2]


def frames_of(demonstrations: Sequence[Demonstration]) -> Frames:
    """Frames of all demonstrations, one after the other."""
    return Frames(
        torch.from_numpy(np.concatenate([d.observations for d in demonstrations])),
        torch.from_numpy(np.concatenate([d.actions for d in demonstrations])),
    )


def normalized_frames(frames: Frames, model: Policy) -> NormalizedFrames:
    """Frames mapped by the ranges that the model has."""
    inputs = normalised(frames.observations, model.obs_min, model.obs_range).clamp(-1.0, 1.0)
    return NormalizedFrames(inputs, normalised(frames.actions, model.act_min, model.act_range))
