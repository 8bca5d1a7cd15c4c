# SPDX-License-Identifier: BSD-3-Clause
"""Which figure of pushes orders engines by the success that they cost: the hypotheses of
docs/study/noise/plan.md, from the tables of pushes and of endings."""

import csv
import io
import lzma
from pathlib import Path
from typing import Dict, Iterator, List, NamedTuple, Sequence, Tuple

import numpy as np
from pusht_task.error import Error
from pusht_task.files import read_file
from scipy import stats  # type: ignore[import]

from sim2sim_study.crossed import Numbers
from sim2sim_study.pushes import COUNT, FIGURES, SEED, SUMS

MOST_SIZE = float(np.log(1.5))
MOST_LOST = 0.05  # what counts as little
HYPOTHESES = (  # each with what its interval may leave out; P1 and P2 are two looks
    ("P1 tau of direction less tau of position error", 0.025),
    ("P2 tau of missed pushes less tau of position error", 0.025),
    ("P3 0.05 less what engines that answer too much cost", 0.05),
    ("P4 what engines that answer too little cost more", 0.05),
)


class Sums(NamedTuple):
    """Figures by policy, engine and start, so that any weights of starts give their means: [policy,
    engine, start]."""

    values: Dict[str, Numbers]  # by figure: sums over the pushes that have it
    counts: Dict[str, Numbers]  # by figure: numbers of these pushes
    lost: Numbers  # success in MuJoCo less that in the engine

    def mean(self, figure: str, policies: Numbers, weights: Numbers) -> Numbers:
        """By engine: mean over policies of the means over their pushes."""
        sums = self.values[figure][policies] @ weights
        counts = self.counts[figure][policies] @ weights
        return np.mean(sums / np.where(counts > 0.0, counts, np.nan), axis=0)

    def lost_mean(self, policies: Numbers, weights: Numbers) -> Numbers:
        return np.mean(self.lost[policies] @ weights / weights.sum(), axis=0)


Table = Dict[Tuple[str, str, str], Numbers]  # sums by start, of a policy, engine and figure


def read_sums(path: Path) -> Table:
    """Sums of figures over pushes. Raises Error for another table."""
    rows = csv.reader(io.StringIO(lzma.decompress(read_file(path)).decode()))
    found = tuple(next(rows))
    if found != SUMS:
        raise Error(f"{path}: has the columns {', '.join(found)}; must have {', '.join(SUMS)}")
    return {(p, e, f): np.array(sums.split(), dtype=float) for p, e, f, sums in rows}


def sums_of(table: Table, lost: Numbers, policies: Sequence[str], engines: Sequence[str]) -> Sums:
    """The figures of a recipe's policies in some engines; `lost` is [policy, engine, start]."""

    def of(figure: str) -> Numbers:
        return np.array([[table[policy, e, figure] for e in engines] for policy in policies])

    values = {figure: of(figure) for figure in FIGURES}
    counts = {figure: of(COUNT) for figure in FIGURES}
    counts["other_way"] -= values["missed"]  # a push that is missed has no way
    return Sums(values, counts, lost)


class Resample(NamedTuple):
    """Which engines, policies of each recipe and starts a resample has."""

    engines: Numbers
    policies: List[Numbers]
    weights: Numbers  # of starts


def whole(recipes: Sequence[Sums]) -> Resample:
    policies, engines, starts = recipes[0].lost.shape
    return Resample(np.arange(engines), [np.arange(policies) for _ in recipes], np.ones(starts))


def resamples(recipes: Sequence[Sums], count: int) -> Iterator[Resample]:
    policies, engines, starts = recipes[0].lost.shape
    generator = np.random.default_rng(SEED)
    for _ in range(count):
        yield Resample(
            generator.integers(0, engines, engines),
            [generator.integers(0, policies, policies) for _ in recipes],
            np.bincount(generator.integers(0, starts, starts), minlength=starts).astype(float),
        )


def tau(recipes: Sequence[Sums], figure: str, drawn: Resample) -> float:
    """Kendall's tau-b of a figure and what is lost, over engines; the mean over recipes."""
    found = []
    for sums, policies in zip(recipes, drawn.policies):
        here = sums.mean(figure, policies, drawn.weights)[drawn.engines]
        lost = sums.lost_mean(policies, drawn.weights)[drawn.engines]
        found.append(stats.kendalltau(here, lost, nan_policy="omit").statistic)
    return float(np.mean(found))


def lost_in(recipes: Sequence[Sums], chosen: Numbers, drawn: Resample) -> float:
    """Mean of what is lost over recipes and over the engines of a class; NaN without any."""
    engines = drawn.engines[chosen[drawn.engines]]
    if not len(engines):
        return np.nan
    parts = [
        sums.lost_mean(policies, drawn.weights)[engines]
        for sums, policies in zip(recipes, drawn.policies)
    ]
    return float(np.mean(parts))


class Found(NamedTuple):
    """A hypothesis on pushes with what was found."""

    name: str
    estimate: float
    low: float
    high: float
    verdict: str  # "holds", "contradicted" or "not shown"


def judge(recipes: Sequence[Sums], count: int = 2000) -> List[Found]:
    """P1 to P4, in windows of five steps."""
    everything = whole(recipes)
    size = np.mean(
        [
            sums.mean("size", policies, everything.weights)
            for sums, policies in zip(recipes, everything.policies)
        ],
        axis=0,
    )
    much, little = (size > 0.0) & (size <= MOST_SIZE), (size < 0.0) & (size >= -MOST_SIZE)

    def figures(drawn: Resample) -> List[float]:
        error = tau(recipes, "position_error", drawn)
        too_much = lost_in(recipes, much, drawn)
        return [
            tau(recipes, "direction", drawn) - error,
            tau(recipes, "missed", drawn) - error,
            MOST_LOST - too_much,
            lost_in(recipes, little, drawn) - too_much,
        ]

    estimates = figures(everything)
    drawn = np.array([figures(one) for one in resamples(recipes, count)])
    found = []
    for place, (name, alpha) in enumerate(HYPOTHESES):
        low, high = np.nanquantile(drawn[:, place], (alpha / 2, 1 - alpha / 2))
        verdict = "holds" if low > 0.0 else "contradicted" if high < 0.0 else "not shown"
        found.append(Found(name, estimates[place], float(low), float(high), verdict))
    return found
