# SPDX-License-Identifier: BSD-3-Clause
"""Policies of the suite as callables of Python."""

import json
import os
from typing import Any, Dict, List, Union

import numpy as np
from numpy.typing import NDArray

from sim2sim._sim2sim import LoadedPolicy, PolicyMemory
from sim2sim.checks import (
    OBSERVATION,
    checked_integer,
    checked_list,
    checked_numbers,
    checked_path,
    checked_seed,
    checked_text,
)
from sim2sim.errors import InvalidInput

MOST_ACTIONS = 1000  # of an answer


class Policy:
    """A policy of the suite, run by the suite's own code: the same bits as in `compare`.

    A policy without a memory is called with observations float32 [n, 10] and gives actions
    float32 [n, 2]. One with a memory is asked by begin() and act(), which work for both.
    """

    # A row's action has the same bits whatever rows are beside it: compare() may use all cores.
    row_independent = True

    def __init__(self, loaded: LoadedPolicy, execute: int) -> None:
        self._loaded = loaded
        self._execute = execute

    @property
    def name(self) -> str:
        """The name as given, or "fresh-untrained"."""
        return self._loaded.name

    @property
    def provenance(self) -> Dict[str, Any]:
        """Where it comes from and what it runs on, as in provenance.json."""
        provenance: Dict[str, Any] = json.loads(self._loaded.provenance)
        return provenance

    def begin(self, seed: int) -> PolicyMemory:
        """The memory of a rollout; all its random numbers come from `seed`."""
        return self._loaded.begin(checked_seed(seed), self._execute)

    def act(
        self, observations: NDArray[np.float32], memories: List[PolicyMemory]
    ) -> NDArray[np.float32]:
        """Actions [n, 2] for observations [n, 10] of rollouts with these memories."""
        for row, memory in enumerate(checked_list("memories", memories)):
            if not isinstance(memory, PolicyMemory):
                raise InvalidInput(f"memories: the one of row {row} must be from begin()")
        return self._loaded.act(_rows(observations), list(memories))

    def __call__(self, observations: NDArray[np.float32]) -> NDArray[np.float32]:
        return self._loaded(_rows(observations))


def load_policy(
    name: Union[str, "os.PathLike[str]"] = "bc",
    *,
    execute: int = 0,
    require_policy: bool = False,
    untrained_seed: int = 0,
    task: str = "full_circle",
) -> Policy:
    """The policy of that name, or in that file, as `compare --policy` takes it.

    `execute`: actions of each answer that are executed; 0: as many as the policy says. `task`: in
    which it acts, as for `compare`; its observations have ten numbers, whatever the policy sees.
    """
    executed = checked_integer("execute", execute, 0, MOST_ACTIONS)
    seed = checked_seed(untrained_seed)
    path = checked_path("policy", name)
    known = checked_text("task", task)
    return Policy(LoadedPolicy(path, bool(require_policy), seed, known), executed)


def _rows(observations: object) -> NDArray[np.float32]:
    rows = checked_numbers("observations", observations, (None, OBSERVATION))
    return np.asarray(rows, np.float32)
