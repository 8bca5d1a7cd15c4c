# SPDX-License-Identifier: BSD-3-Clause
"""Audit of a policy: is it asked as it was trained?"""

import json
import os
from dataclasses import dataclass, field
from typing import Any, Dict, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from sim2sim import _sim2sim
from sim2sim.asked import asked
from sim2sim.policy import Policy

Episodes = Sequence[Tuple[NDArray[Any], NDArray[Any]]]


@dataclass(frozen=True)
class PolicyAudit:
    """What an audit says of a policy."""

    fault: str  # the correction that explains its error; empty: none does
    summary: Dict[str, Any] = field(repr=False)  # what `audit --policy --out` writes
    text: str  # what the command prints

    def __str__(self) -> str:
        return self.text


def audit_policy(
    policy: object,
    demonstrations: Union[str, "os.PathLike[str]", Episodes],
    *,
    history: Optional[int] = None,
) -> PolicyAudit:
    """Asks a policy what was recorded, as `rosrun sim2sim_eval audit --policy` does.

    `policy` is what compare() takes: a name, a file, a callable with its `history`, an object with
    begin() and act(), or a PyTorch module. `demonstrations` are a bag or a CSV, or for each episode
    a pair of observations [n, 10] and actions [n, 2].

    Raises Error, with the command's words, but none for a fault; what the callable raises.
    """
    if isinstance(policy, Policy):
        policy = policy.name
    if isinstance(demonstrations, (str, os.PathLike)):
        label = os.fspath(demonstrations)
        observations, actions = _sim2sim.read_demonstrations(label)
    else:
        label = "arrays"
        observations = [np.asarray(episode[0], np.float32) for episode in demonstrations]
        actions = [np.asarray(episode[1], np.float32) for episode in demonstrations]
    with asked(policy, history=history) as it:
        found = _sim2sim.audit_policy(
            it.callable, it.name, it.history, observations, actions, label
        )
    return PolicyAudit(found["fault"], json.loads(found["json"]), found["text"])
