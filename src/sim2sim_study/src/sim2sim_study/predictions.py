# SPDX-License-Identifier: BSD-3-Clause
"""Exploratory: which numbers of pushes predict the success that an engine costs. Each number is a
figure of pushes in windows of so many control steps: "direction_5"."""

import csv
import io
import itertools
from pathlib import Path
from typing import Dict, Iterator, List, Sequence, Tuple

import numpy as np
from pusht_task.files import read_text
from scipy import stats  # type: ignore[import]

from sim2sim_study.crossed import Numbers
from sim2sim_study.groups import rounded
from sim2sim_study.pushes import FIGURES
from sim2sim_study.tables import Row

SIZES = ("none", "number", "pair")  # how many numbers predict


def read_numbers(path: Path, policies: Sequence[str], engines: Sequence[str]) -> Dict[str, Numbers]:
    """Numbers by engine: means over policies of the means over their pushes, from pushes.csv."""
    found: Dict[str, Dict[str, List[float]]] = {}
    for row in csv.DictReader(io.StringIO(read_text(path))):
        if row["policy"].partition(".")[0] in policies and row["engine"] in engines:
            for figure in FIGURES:
                by_engine = found.setdefault(f"{figure}_{row['window']}", {})
                by_engine.setdefault(row["engine"], []).append(float(row[figure]))
    return {
        name: np.array([np.mean(by_engine[engine]) for engine in engines])
        for name, by_engine in found.items()
    }


def prediction_rows(numbers: Dict[str, Numbers], lost: Numbers) -> Iterator[Row]:
    """How well no number, each number and each pair of numbers predict what engines cost; the best
    of each size first. `lost` is by engine.

    An engine is left out, lost success is regressed on the ranks of the numbers among all engines
    (least squares, with an intercept; ties have their mean rank), and the engine's is predicted; so
    for each engine in turn. With no number the prediction is the mean of the others. A number that
    an engine does not have predicts nothing.
    """
    ranks = {name: stats.rankdata(x) for name, x in numbers.items() if np.isfinite(x).all()}
    errors: Dict[Tuple[str, ...], float] = {
        names: left_out_error([ranks[name] for name in names], lost)
        for size in range(len(SIZES))
        for names in itertools.combinations(ranks, size)
    }
    errors.update({(name,): np.nan for name in numbers if name not in ranks})
    for names in sorted(
        errors, key=lambda names: (len(names), np.nan_to_num(errors[names], nan=np.inf))
    ):
        tau = np.nan
        if len(names) == 1:
            tau = stats.kendalltau(numbers[names[0]], lost, nan_policy="omit").statistic
        yield {
            "size": SIZES[len(names)],
            "numbers": " + ".join(names),
            "mean_absolute_error": rounded(errors[names]),
            "kendall_tau": rounded(float(tau)),
        }


def left_out_error(ranks: Sequence[Numbers], lost: Numbers) -> float:
    """Mean absolute error of the prediction of each engine from the others."""
    design = np.stack([np.ones(len(lost)), *ranks], axis=1)
    errors = []
    for engine in range(len(lost)):
        others = np.arange(len(lost)) != engine
        weights, *_ = np.linalg.lstsq(design[others], lost[others], rcond=None)
        errors.append(abs(float(design[engine] @ weights - lost[engine])))
    return float(np.mean(errors))
