# SPDX-License-Identifier: BSD-3-Clause
"""Statistics over the trainings of the study."""

import math
from typing import Any, Dict, List, Sequence

import numpy as np
from scipy import stats  # type: ignore[import]

Row = Dict[str, Any]


def mean(values: Sequence[float]) -> Row:
    """Mean over policies with Student's interval, which is about further trainings."""
    mean = float(np.mean(values))
    if len(values) < 2:
        return {"mean": mean, "low": "", "high": ""}
    half = float(stats.sem(values) * stats.t.ppf(0.975, len(values) - 1))
    return {"mean": mean, "low": mean - half, "high": mean + half}


def difference(more: Sequence[float], less: Sequence[float]) -> Row:
    """Difference of two means over policies with Welch's interval, about further trainings."""
    mean = float(np.mean(more) - np.mean(less))
    if min(len(more), len(less)) < 2:
        return {"mean": mean, "low": "", "high": ""}
    parts = [stats.sem(values) ** 2 for values in (more, less)]
    total = sum(parts)
    freedom = [part**2 / (len(values) - 1) for part, values in zip(parts, (more, less))]
    half = 0.0 if total == 0 else np.sqrt(total) * stats.t.ppf(0.975, total**2 / sum(freedom))
    return {"mean": mean, "low": float(mean - half), "high": float(mean + half)}


def difference_p(more: Sequence[float], less: Sequence[float]) -> float:
    """p of no difference, after Welch; NaN where it has no interval, or no spread."""
    if min(len(more), len(less)) < 2 or max(np.ptp(more), np.ptp(less)) == 0.0:
        return math.nan
    return float(stats.ttest_ind(more, less, equal_var=False).pvalue)


def holm(p: Sequence[float]) -> List[float]:
    """Adjusted p-values. One that is NaN, of what cannot be tested, counts as 1."""
    known = [1.0 if math.isnan(value) else value for value in p]
    adjusted = list(known)
    most = 0.0
    for rank, index in enumerate(sorted(range(len(known)), key=lambda i: known[i])):
        most = max(most, min(1.0, (len(known) - rank) * known[index]))
        adjusted[index] = most
    return adjusted
