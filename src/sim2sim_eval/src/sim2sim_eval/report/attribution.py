# SPDX-License-Identifier: BSD-3-Clause
"""The cause of a gap, as the command `attribute` has written it, and its figures."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, List, Sequence, Tuple

import matplotlib  # type: ignore[import]
from matplotlib.figure import Figure  # type: ignore[import]

from sim2sim_eval.command import Refusal
from sim2sim_eval.report.figures import (
    COLORS,
    DIM,
    INK,
    STYLE,
    Drawing,
    name_rows,
)
from sim2sim_eval.report.results import ENGINE, REPLAY, Json, read_json, require_format

FORMAT = 1
FILE = "attribution.json"
SERIES = (  # of horizons: open loop, then re-anchored
    *((COLORS[REPLAY], "o"), (COLORS[ENGINE], "s"), (COLORS["reference"], "^")),
    *((DIM, "D"), (INK, "v"), (COLORS[REPLAY], "X"), (COLORS[ENGINE], "P")),
)


@dataclass(frozen=True)
class Attribution:
    content: Json

    @property
    def switches(self) -> List[str]:
        names: List[str] = self.content["switches"]
        return names

    def gaps(self, component: str) -> List[Json]:
        """Of "position" or "angle": in open loop, then re-anchored."""
        found = [self.content["gaps"][name] for name in self.content["order"]]
        return [gap for gap in found if gap["title"].startswith(component)]

    @property
    def is_exact(self) -> bool:
        """Of all combinations; else of those along random orders."""
        return int(self.content["orders"]) == 0

    @property
    def success(self) -> Json:
        gap: Json = self.content["gaps"]["lost_success"]
        return gap

    def ranked(self, gap: Json) -> List[Tuple[str, float]]:
        """Switches with their parts of the gap, the largest first."""
        parts = [(name, gap["switches"][name]["part"] or 0.0) for name in self.switches]
        return sorted(parts, key=lambda part: (-part[1], part[0]))


def is_attributed(folder: Path) -> bool:
    return (folder / FILE).exists()


def read_attribution(folder: Path) -> Attribution:
    content = read_json(folder / FILE)
    require_format(folder / FILE, content, FORMAT)
    try:
        attribution = Attribution(content)
        for component in ("position", "angle"):
            for gap in attribution.gaps(component):
                attribution.ranked(gap)
    except (KeyError, TypeError) as error:
        raise Refusal(f"{folder / FILE}: is not as this version writes it: {error!r}") from None
    return attribution


def draw(attribution: Attribution) -> List[Drawing]:
    with matplotlib.rc_context(STYLE):
        drawings = [_shares(attribution)]
        if attribution.is_exact:
            drawings.append(_staircase(attribution))
        return drawings


def _shares(attribution: Attribution) -> Drawing:
    """Each switch's part of each gap, with its interval."""
    names = [name for name, _ in attribution.ranked(attribution.gaps("position")[0])]
    figure = Figure(figsize=(8.6, 1.5 + 0.5 * len(names)), constrained_layout=True)
    both = figure.subplots(1, 2, sharey=True)
    for axes, component in zip(both, ("position", "angle")):
        gaps = attribution.gaps(component)
        for number, gap in enumerate(gaps):
            color, marker = SERIES[number % len(SERIES)]
            for row, name in enumerate(names):
                found = gap["switches"][name]
                if found["part"] is None:
                    continue
                place = row + 0.22 * (number - (len(gaps) - 1) / 2)
                if found["part_interval"]:
                    ends = [100 * end for end in found["part_interval"]]
                    axes.plot(ends, [place, place], color=color, linewidth=2)
                label = gap["title"].split(", ")[1] if row == 0 else None
                axes.plot(
                    100 * found["part"], place, marker, color=color, markersize=6, label=label
                )
        axes.axvline(0, color=INK, linewidth=1)
        axes.set_xlabel(f"{component}: part of the gap [%]")
        name_rows(axes, names)
    handles = max(
        (axes.get_legend_handles_labels() for axes in both), key=lambda pair: len(pair[0])
    )
    lines = -(-len(handles[0]) // 3)
    figure.get_layout_engine().set(
        rect=(0.0, 0.0, 1.0, 1.0 - 0.35 * lines / figure.get_figheight())
    )
    figure.legend(*handles, loc="upper center", ncols=3)
    return Drawing("shares", "What part of the gap each switch explains", figure)


def _staircase(attribution: Attribution) -> Drawing:
    """The gap as switches are turned on in the best order, between its yardsticks."""
    gaps = [attribution.gaps(component)[0] for component in ("position", "angle")]
    steps = [_steps(attribution, gap) for gap in gaps]
    figure = Figure(figsize=(8.6, 1.0 + 0.36 * max(map(len, steps))), constrained_layout=True)
    for axes, gap, rows in zip(figure.subplots(1, 2), gaps, steps):
        for row, (_, value, color) in enumerate(rows):
            axes.barh(row, value, height=0.6, color=color, alpha=0.85)
            axes.text(value, row, f" {value:.4f}", va="center", fontsize=9, color=INK)
        axes.set_xlim(0, 1.2 * (max(value for _, value, _ in rows) or 1.0))
        axes.set_xlabel(f"{gap['title']} [{gap['unit']}]")
        name_rows(axes, [name for name, _, _ in rows])
    words = "; ".join(f"{name} {value:.4f}" for name, value, _ in steps[0])
    return Drawing("staircase", f"The gap in position, step by step: {words}", figure)


def _steps(attribution: Attribution, gap: Json) -> Sequence[Tuple[str, float, Any]]:
    rows = [("tee never moves", gap["null_model"]["value"], DIM)]
    if gap["baseline"]["value"] is not None:
        rows.append((attribution.content["baseline"], gap["baseline"]["value"], COLORS[ENGINE]))
    rows.append(("all off", gap["staircase"][0], COLORS[REPLAY]))
    for name, value in zip(gap["best_order"], gap["staircase"][1:]):
        rows.append((f"+ {name}", value, COLORS[REPLAY]))
    if gap["floor"]["value"] is not None:
        rows.append(
            (
                f"floor of {attribution.content['reference']}",
                gap["floor"]["value"],
                COLORS["reference"],
            )
        )
    return rows
