# SPDX-License-Identifier: BSD-3-Clause
"""Comparison of two simulators under one policy, in process."""

import csv
import json
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional

import numpy as np
from numpy.typing import NDArray

from sim2sim import _sim2sim
from sim2sim.errors import InvalidInput

INTEGERS = {"episode": np.int64, "seed": np.uint64, "steps": np.int64, "repeat": np.int64}
TEXTS = ("mode", "parting_cause", "parting_first", "ending", "pusher_ending")


@dataclass(frozen=True)
class Comparison:
    """Results of a comparison: what its files say."""

    episodes: Dict[str, NDArray[Any]] = field(repr=False)  # columns of episodes.csv
    summary: Dict[str, Any] = field(repr=False)  # metrics.json
    provenance: Dict[str, Any] = field(repr=False)  # provenance.json
    text: str  # the table that the command prints
    folder: Optional[Path]  # the files of the run; None: there are none

    def __str__(self) -> str:
        return self.text


def columns_of(text: str) -> Dict[str, NDArray[Any]]:
    """The columns of episodes.csv, a row for each rollout.

    A number that a rollout has not is NaN. Given starts have no seeds, hence no such column.
    """
    names, *rows = csv.reader(text.splitlines())
    columns = {name: [row[i] for row in rows] for i, name in enumerate(names)}
    if not all(columns["seed"]):
        del columns["seed"]
    return {name: _column(name, cells) for name, cells in columns.items()}


def _column(name: str, cells: List[str]) -> NDArray[Any]:
    if name in TEXTS:
        return np.array(cells)
    if name == "success":
        return np.array([cell == "true" for cell in cells])
    if name in INTEGERS:
        return np.array([int(cell) for cell in cells], INTEGERS[name])
    return np.array([float(cell or "nan") for cell in cells])


def compare(
    policy: object = "bc",
    *,
    reference: Optional[str] = None,
    engine: Optional[str] = None,
    reference_parameters: Optional[Mapping[str, object]] = None,
    engine_parameters: Optional[Mapping[str, object]] = None,
    history: Optional[int] = None,
    version: Optional[str] = None,
    progress: bool = False,
    **options: object,
) -> Comparison:
    """Compares two simulators under one policy, as `rosrun sim2sim_eval compare` does.

    `policy` is a name or file as for the command, or a callable: it gets observations float32
    [n, 10], or with `history=H` [n, H, 10] with the oldest first, and gives actions [n, 2], or a
    chunk [n, K, 2], of which the first `execute` are taken before it is asked again (all without
    `execute`). An object with begin(seed) and act(observations, memories) has a memory for each
    row: begin() makes one at the beginning of a rollout, act() changes it in place. All calls come
    from the thread that called compare().

    `options` are those of the command, with underscores: episodes=200, horizon=100,
    loop={"action_delay": 2} or "tracker", threads=2, out="results/mine". Without `out` nothing is
    written.

    With a callable, `threads` is 1 by default: then the rows of each call are the same ones every
    time. With more threads they are not, which changes no result if a row's action has the same
    bits whatever rows are beside it. A callable with an attribute `row_independent`, which is true,
    says so, and gets all cores. `version` names the policy for runs that continue and for
    reference_cache, which otherwise refuse a callable.

    Raises Error, with the command's words; what the callable raises; KeyboardInterrupt at Ctrl-C.
    """
    options["reference"] = reference
    options["engine"] = engine
    options["set_reference"] = dict(reference_parameters or {})
    options["set"] = dict(engine_parameters or {})
    is_callable = not isinstance(policy, (str, os.PathLike))
    if is_callable:
        _require_callable(policy)
        if not getattr(policy, "row_independent", False) and options.get("threads") is None:
            options["threads"] = 1
    else:
        _require_left_out(history=history, version=version)
        options["policy"] = policy
    results = _sim2sim.compare(
        options,
        policy if is_callable else None,
        _name_of(policy),
        version or "",
        _checked_history(history),
        progress,
    )
    return Comparison(
        columns_of(results["episodes"]),
        json.loads(results["metrics"]),
        json.loads(results["provenance"]),
        results["text"],
        Path(results["folder"]) if results["folder"] else None,
    )


def _require_callable(policy: object) -> None:
    if not callable(policy) and not (hasattr(policy, "begin") and hasattr(policy, "act")):
        raise InvalidInput(
            f"policy {policy!r}: must be a name, a file, a callable, or an object with begin() "
            "and act()"
        )


def _require_left_out(**given: object) -> None:
    for name, value in given.items():
        if value is not None:
            raise InvalidInput(f"{name} {value}: must be left out unless the policy is a callable")


def _checked_history(history: Optional[int]) -> int:
    """The history as the extension takes it: 0 for an observation without one."""
    if history is None:
        return 0
    if isinstance(history, bool) or not isinstance(history, int) or not 1 <= history <= 1000:
        raise InvalidInput(f"history {history}: must be an integer from 1 to 1000")
    return history


def _name_of(policy: object) -> str:
    """Module and qualified name of a callable, or of its class."""
    named = policy if hasattr(policy, "__qualname__") else type(policy)
    return f"{getattr(named, '__module__', None) or '?'}.{getattr(named, '__qualname__')}"
