# SPDX-License-Identifier: BSD-3-Clause
"""Success of groups of policies under noise, and what engines cost: the leading tables of the study
under noise, from its table of endings."""

import math
from typing import Dict, Iterator, List, Optional

import numpy as np

from sim2sim_study.crossed import Interval, Numbers, mean_interval, ratio_interval
from sim2sim_study.endings import Endings, NotRun
from sim2sim_study.tables import Row

NOISE = "observation_noise_position="  # of loops with noise on the positions [m] alone


def group_rows(endings: Endings) -> Iterator[Row]:
    """Each group of policies in each loop and simulator, held against its reference."""
    for (part, loop, group), simulators in endings.simulators.items():
        reference = endings.letters(part, loop, group, simulators[0])
        for simulator in simulators:
            letters = endings.letters(part, loop, group, simulator)
            named = {"part": part, "loop": loop, "group": group, "simulator": simulator}
            is_reference = simulator == simulators[0]
            yield {**named, **figures(letters, None if is_reference else reference)}


def figures(letters: Numbers, reference: Optional[Numbers]) -> Row:
    """Figures of letters [policy, start], and what they are beside the same policies and starts in
    the reference. None where there is nothing to tell."""
    won, failed = letters == "S", int(np.sum(letters != "S"))
    row: Row = {"policies": len(letters)}
    row.update(_with_ends("success", float(won.mean()), mean_interval(won.astype(float))))
    row.update(dict.fromkeys(COMPARED))
    if reference is not None:
        home = (reference == "S").astype(float)
        cost = won - home
        row.update(_with_ends("difference", float(cost.mean()), mean_interval(cost)))
        ratio = float(won.mean() / home.mean()) if home.any() else math.nan
        row.update(_with_ends("transfer", ratio, ratio_interval(won.astype(float), home)))
        by_training = cost.mean(axis=1)
        row["lowest_training"] = rounded(float(by_training.min()))
        row["highest_training"] = rounded(float(by_training.max()))
        row["hangs_on_one"] = hangs_on_one(by_training)
    row["failures"] = failed
    row["stuck"] = rounded(float(np.sum(letters == "t") / failed)) if failed else None
    return row


COMPARED = (
    *("difference", "difference_low", "difference_high"),
    *("transfer", "transfer_low", "transfer_high"),
    *("lowest_training", "highest_training"),  # difference of one training
    "hangs_on_one",
)


def hangs_on_one(values: Numbers) -> bool:
    """Whether the sign of a mean turns, or goes, without one of the values."""
    if len(values) < 2:
        return False
    total = values.sum()
    return bool(np.any(np.sign(total - values) != np.sign(total)))


def _with_ends(name: str, value: float, interval: Interval) -> Row:
    low, high = map(rounded, interval) if interval else (None, None)
    return {name: rounded(value), f"{name}_low": low, f"{name}_high": high}


def rounded(value: float) -> Optional[float]:
    """A figure to six digits; none for NaN."""
    return None if math.isnan(value) else float(f"{value:.6g}")


def curve_rows(endings: Endings) -> Iterator[Row]:
    """The curves' policies over noise on the positions, each beside MuJoCo in the same loop. Those
    without noise are the same policies of the part `primary`, if it was run."""
    curves: Dict[str, List[str]] = {}
    for part, loop, group in endings.simulators:
        if part == "curves" and loop.startswith(NOISE):
            curves.setdefault(group, []).append(loop)
    for group, loops in curves.items():
        simulators = endings.simulators["curves", loops[0], group]
        policies = endings.policies("curves", loops[0], group)
        places = [("primary", "none", 0.0)]
        places += [("curves", loop, float(loop[len(NOISE) :])) for loop in loops]
        for part, loop, noise in sorted(places, key=lambda place: place[2]):
            for simulator in simulators:
                try:
                    home, letters = (
                        endings.letters(part, loop, group, name, policies)
                        for name in (simulators[0], simulator)
                    )
                except NotRun:
                    continue
                named = {
                    "group": group,
                    "noise_mm": rounded(1000.0 * noise),
                    "simulator": simulator,
                }
                yield {**named, **figures(letters, None if simulator == simulators[0] else home)}
