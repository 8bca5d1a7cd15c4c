# SPDX-License-Identifier: BSD-3-Clause
"""Figures over trainings and starts, both of which are samples: tables [policy, start].

The rules are those of sim2sim_statistics/crossed.hpp; docs/statistics.md has their coverage.
"""

import math
from typing import Any, NamedTuple, Optional, Tuple

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, stats  # type: ignore[import]

Numbers = NDArray[Any]
Interval = Optional[Tuple[float, float]]  # of 95 %; None where there is none

FEWEST = 5  # policies for an interval
SAME = 1e-9  # standard error up to which nothing varies


class Mean(NamedTuple):
    """Mean of a table, with its standard error and Satterthwaite's degrees of freedom."""

    value: float
    error: float
    freedom: float

    @property
    def half_width(self) -> float:
        """Half the width of Student's interval."""
        return float(stats.t.ppf(0.975, self.freedom)) * self.error

    @property
    def varies(self) -> bool:
        return self.error > SAME

    @property
    def p(self) -> float:
        """Two-sided p of a mean of 0; NaN where nothing varies."""
        if not self.varies:
            return math.nan
        return 2.0 * float(stats.t.sf(abs(self.value) / self.error, self.freedom))


def mean_of(y: Numbers) -> Mean:
    """Mean of a table with two policies and two starts at least."""
    mean, of_policies, of_starts = y.mean(), y.mean(axis=1), y.mean(axis=0)
    policies, starts = (count - 1.0 for count in y.shape)
    by_policy = y.shape[1] * np.sum((of_policies - mean) ** 2) / policies
    by_start = y.shape[0] * np.sum((of_starts - mean) ** 2) / starts
    rest = np.sum((y - of_policies[:, None] - of_starts + mean) ** 2) / (policies * starts)
    total, spread = by_policy, by_policy**2 / policies
    if by_start > rest:
        total += by_start - rest
        spread += by_start**2 / starts + rest**2 / (policies * starts)
    freedom = max(policies, total**2 / spread) if spread > 0.0 else policies
    return Mean(float(mean), math.sqrt(total / y.size), float(freedom))


def mean_interval(y: Numbers) -> Interval:
    """Interval of the mean; none of fewer policies than FEWEST, and where nothing varies."""
    if len(y) < FEWEST:
        return None
    mean = mean_of(y)
    half = mean.half_width
    return (mean.value - half, mean.value + half) if mean.varies else None


def ratio_interval(numerators: Numbers, denominators: Numbers) -> Interval:
    """Fieller's interval of the ratio of the means of two tables of the same policies and starts,
    neither of which has a value below 0: every ratio r for which the interval of the mean of
    numerators - r denominators holds 0.

    None of fewer policies than FEWEST, where a mean is 0 or the ratio does not vary, and where the
    denominators' own interval holds 0: then no ratio is too large.
    """
    if len(numerators) < FEWEST or 0.0 in (numerators.mean(), denominators.mean()):
        return None
    ratio = float(numerators.mean() / denominators.mean())
    below = mean_of(denominators)
    if below.half_width >= below.value or not mean_of(numerators - ratio * denominators).varies:
        return None

    def beyond(r: float) -> float:
        """Above 0 outside of the interval."""
        mean = mean_of(numerators - r * denominators)
        return abs(mean.value) - mean.half_width

    far = 2.0 * ratio
    while beyond(far) <= 0.0:
        far *= 2.0
    low = 0.0 if beyond(0.0) <= 0.0 else float(optimize.brentq(beyond, 0.0, ratio))
    return low, float(optimize.brentq(beyond, ratio, far))
