# SPDX-License-Identifier: BSD-3-Clause
"""The hypotheses on success of the study under noise, from its table of endings.
docs/study/noise/plan.md has them, and how they are judged."""

import contextlib
import csv
import io
import math
from pathlib import Path
from typing import Callable, Dict, List, NamedTuple, Sequence, Tuple

import numpy as np
from pusht_task.files import write_file
from scipy import stats  # type: ignore[import]

from sim2sim_study.crossed import Mean, Numbers, mean_of
from sim2sim_study.endings import Endings, NotRun
from sim2sim_study.statistics import holm

PARTS = ("primary", "draws")  # others run the same groups from fewer starts, or in other loops
MARGIN = 0.05  # of success, in points
SIGNIFICANT = 0.05  # after Holm
RESAMPLES = 2000
SEED = 20261127
SMALL, SHIPPED = "small-mujoco", "shipped-mujoco"
BULLET = "bullet:preset=idiomatic"
ORDER = "N13 Chipmunk orders policies of one recipe as MuJoCo does"


class Judged(NamedTuple):
    """A hypothesis with what was found."""

    name: str
    estimate: float
    low: float
    high: float
    p: float  # NaN: it is judged by its interval
    adjusted: float  # after Holm; NaN likewise
    verdict: str  # "holds", "contradicted", "not shown" or "not run"


def success(
    table: Endings, group: str, loop: str, simulator: str, seeds: Sequence[int] = ()
) -> Numbers:
    """[policy, start]: all policies of a group, or those of some training seeds."""
    names = [f"{group}-{seed}" for seed in seeds]
    return (letters_of(table, group, loop, simulator, names) == "S").astype(float)


def letters_of(
    table: Endings, group: str, loop: str, simulator: str, policies: Sequence[str] = ()
) -> Numbers:
    """Letters of a group, from the part that has it."""
    part = next((part for part in PARTS if (part, loop, group) in table.simulators), PARTS[0])
    return table.letters(part, loop, group, simulator, policies)


def lost(table: Endings, group: str, engine: str) -> Numbers:
    """Success in the engine less that in MuJoCo, in the loop `tracker`."""
    return success(table, group, "tracker", engine) - success(table, group, "tracker", "mujoco")


def by_draw(table: Endings, recipe: str) -> Numbers:
    """[draw, start]: success in the two-mass engine, the mean of the trainings of each draw."""
    draws = [success(table, g, "tracker", "two_mass").mean(axis=0) for g in draws_of(recipe)]
    return np.array(draws)


def draws_of(recipe: str) -> List[str]:
    """Groups of one recipe and several draws of demonstrations."""
    return [f"{recipe}-mujoco", *(f"{recipe}-draw_{number}" for number in range(1, 6))]


def stuck_beyond_half(table: Endings, group: str) -> Numbers:
    """Above 0 in the mean if most failures in MuJoCo are stuck, without noise."""
    letters = letters_of(table, group, "none", "mujoco")
    return (letters == "t").astype(float) - 0.5 * (letters != "S")


def raised(table: Endings, group: str) -> Numbers:
    """Success in MuJoCo in the loop `tracker` less that without noise."""
    return success(table, group, "tracker", "mujoco") - success(table, group, "none", "mujoco")


def longer(table: Endings, group: str, other: str) -> Numbers:
    """Success in the two-mass engine, of the same five training seeds."""
    more, less = (success(table, g, "tracker", "two_mass", range(100, 105)) for g in (group, other))
    return more - less


WITHIN: Dict[str, Callable[[Endings], Numbers]] = {  # the whole interval within the margin
    "N1 Chipmunk costs nothing: shipped": lambda t: lost(t, SHIPPED, "chipmunk"),
    "N2 Chipmunk costs nothing: small": lambda t: lost(t, SMALL, "chipmunk"),
    "N3 Box2D costs nothing: shipped": lambda t: lost(t, SHIPPED, "box2d"),
    "N4 Box2D costs nothing: small": lambda t: lost(t, SMALL, "box2d"),
    "N5 Bullet costs nothing: shipped": lambda t: lost(t, SHIPPED, "bullet"),
    "N6 Bullet costs nothing: small": lambda t: lost(t, SMALL, "bullet"),
}
SIDES: Dict[str, Tuple[int, Callable[[Endings], Numbers]]] = {  # -1: below 0, 1: above 0
    "N7 two-mass costs success: shipped": (-1, lambda t: lost(t, SHIPPED, "two_mass")),
    "N8 two-mass costs success: small": (-1, lambda t: lost(t, SMALL, "two_mass")),
    "N9 idiomatic Bullet costs success: shipped": (-1, lambda t: lost(t, SHIPPED, BULLET)),
    "N10 600 less 60 epochs": (-1, lambda t: longer(t, SHIPPED, "epochs_60-width_512")),
    "N11 512 less 256 units": (-1, lambda t: longer(t, SHIPPED, "epochs_600-width_256")),
    "N12 small less shipped, by draw": (1, lambda t: by_draw(t, "small") - by_draw(t, "shipped")),
    "N14 most failures are stuck: shipped": (1, lambda t: stuck_beyond_half(t, SHIPPED)),
    "N15 most failures are stuck: small": (1, lambda t: stuck_beyond_half(t, SMALL)),
    "N16 tracker raises success: shipped": (1, lambda t: raised(t, SHIPPED)),
    "N17 tracker raises success: small": (1, lambda t: raised(t, SMALL)),
}


def judged_within(name: str, mean: Mean) -> Judged:
    low, high = mean.value - mean.half_width, mean.value + mean.half_width
    inside = -MARGIN <= low and high <= MARGIN
    outside = high < -MARGIN or low > MARGIN
    verdict = "holds" if inside else "contradicted" if outside else "not shown"
    return Judged(name, mean.value, low, high, math.nan, math.nan, verdict)


def judged_side(name: str, side: int, mean: Mean, adjusted: float) -> Judged:
    low, high = mean.value - mean.half_width, mean.value + mean.half_width
    is_shown = adjusted <= SIGNIFICANT
    as_expected = side * mean.value > 0.0
    verdict = "not shown" if not is_shown else "holds" if as_expected else "contradicted"
    return Judged(name, mean.value, low, high, mean.p, adjusted, verdict)


def tau_within_recipes(table: Endings) -> Judged:
    """N13: the mean of the two recipes' tau-b of success in MuJoCo and in Chipmunk."""
    both = []
    for recipe in ("small", "shipped"):
        pair = [
            np.concatenate(
                [success(table, group, "tracker", simulator) for group in draws_of(recipe)]
            )
            for simulator in ("mujoco", "chipmunk")
        ]
        both.append(np.array(pair))  # [simulator, policy, start]

    def tau(policies: Sequence[Numbers], starts: Numbers) -> float:
        found = []
        for pair, chosen in zip(both, policies):
            here, there = pair[:, chosen][:, :, starts].mean(axis=2)
            found.append(stats.kendalltau(here, there).statistic)
        return float(np.mean(found))

    counts, starts = [pair.shape[1] for pair in both], both[0].shape[2]
    generator = np.random.default_rng(SEED)
    resampled = [
        tau([generator.integers(0, n, n) for n in counts], generator.integers(0, starts, starts))
        for _ in range(RESAMPLES)
    ]
    low, high = np.nanquantile(resampled, (0.025, 0.975))
    estimate = tau([np.arange(n) for n in counts], np.arange(starts))
    verdict = "holds" if low > 0.0 else "contradicted" if high < 0.0 else "not shown"
    return Judged(ORDER, estimate, float(low), float(high), math.nan, math.nan, verdict)


def judge(table: Endings) -> List[Judged]:
    """All hypotheses on success, in the order of the plan. One whose part is missing was not run;
    in Holm's family it counts as a p of 1."""
    means: Dict[str, Mean] = {}
    for name, y in {**WITHIN, **{name: y for name, (_, y) in SIDES.items()}}.items():
        with contextlib.suppress(NotRun):
            means[name] = mean_of(y(table))
    found = {name: judged_within(name, means[name]) for name in WITHIN if name in means}
    adjusted = holm([means[name].p if name in means else math.nan for name in SIDES])
    for (name, (side, _)), p in zip(SIDES.items(), adjusted):
        if name in means:
            found[name] = judged_side(name, side, means[name], p)
    with contextlib.suppress(NotRun):
        found[ORDER] = tau_within_recipes(table)
    names = sorted([*WITHIN, *SIDES, ORDER], key=lambda name: int(name.split()[0][1:]))
    none = Judged("", math.nan, math.nan, math.nan, math.nan, math.nan, "not run")
    return [found.get(name, none._replace(name=name)) for name in names]


def write_hypotheses(path: Path, found: Sequence[Judged]) -> None:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(Judged._fields)
    for one in found:
        figures = [f"{value:.6g}" for value in one[1:6]]
        writer.writerow([one.name, *figures, one.verdict])
    write_file(path, text.getvalue().encode())
