# SPDX-License-Identifier: BSD-3-Clause
"""The cause of a gap, as the command `attribute` has written it, and its figures."""

import functools
from dataclasses import dataclass
from pathlib import Path
from typing import Any, List, NamedTuple, Optional, Sequence, Tuple

from pusht_task.error import Error
from pusht_task.json_file import Json, read_json, require_format
from sim2sim_protocol.result_files import format_of, name_of

from sim2sim_report.colors import COLORS, DIM, INK
from sim2sim_report.figures import (
    NARROW,
    Drawing,
    add_legend,
    draw_interval,
    entitle_axes,
    name_rows,
    panels,
    wrapped,
)
from sim2sim_report.results import ENGINE, REPLAY

FORMAT = format_of("attribution")
FILE = name_of("attribution")
HORIZONS = (  # colors and marks of replays: open loop, then re-anchored
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
        """The gaps of "position" or "angle": in open loop, then re-anchored."""
        found = [self.content["gaps"][name] for name in self.content["order"]]
        return [gap for gap in found if gap["title"].startswith(component)]

    @property
    def is_exact(self) -> bool:
        """True if all combinations were run, not only those along random orders."""
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
        raise Error(f"{folder / FILE}: is not as this version writes it: {error!r}") from None
    return attribution


def draw(attribution: Attribution) -> List[Drawing]:
    alt = "What part of the gap each switch explains"
    drawings = [Drawing("shares", alt, functools.partial(_shares, attribution))]
    if attribution.is_exact:
        steps = _steps(attribution, attribution.gaps("position")[0])
        words = "; ".join(f"{name} {bar.value:.4f}" for name, bar in steps)
        alt = f"The gap in position, step by step: {words}"
        drawings.append(Drawing("staircase", alt, functools.partial(_staircase, attribution)))
    return drawings


def _shares(attribution: Attribution, narrow: bool) -> Any:
    """Part of each gap that a switch explains, with its interval."""
    names = [name for name, _ in attribution.ranked(attribution.gaps("position")[0])]
    columns = {component: attribution.gaps(component) for component in ("position", "angle")}
    if any(found["part"] is not None for found in attribution.success["switches"].values()):
        columns["success"] = [attribution.success]
    height = 0.8 + 0.5 * len(names)
    sizes = ((9.6, height + 0.3), (NARROW, height + 0.2))
    figure, [row_of_axes] = panels(narrow, (1, len(columns)), *sizes, sharey=not narrow)
    for axes, (component, gaps) in zip(row_of_axes, columns.items()):
        for number, gap in enumerate(gaps):
            color, marker = HORIZONS[number % len(HORIZONS)]
            if component == "success":
                color, marker = INK, "D"
            label = gap["title"].split(", ")[1]
            for row, name in enumerate(names):
                found = gap["switches"][name]
                if found["part"] is None:
                    continue
                place = row + 0.22 * (number - (len(gaps) - 1) / 2)
                draw_interval(axes, found["part_interval"], place, 100, color=color, linewidth=2)
                part = 100 * found["part"]
                axes.plot(part, place, marker, color=color, markersize=6, label=label)
        axes.axvline(0, color=INK, linewidth=1)
        axes.set_xlabel(f"{component}: part of the gap [%]")
        axes.locator_params(axis="x", nbins=5)
        name_rows(axes, names)
    add_legend(figure, "upper", 1 if narrow else 4)
    return figure


class Bar(NamedTuple):
    value: float
    interval: Optional[Sequence[float]]
    color: str


def _staircase(attribution: Attribution, narrow: bool) -> Any:
    """The gap as switches are turned on, between its baselines; each gap in its own best order."""
    gaps = [attribution.gaps(component)[0] for component in ("position", "angle")]
    steps = [_steps(attribution, gap) for gap in gaps]
    height = 1.2 + 0.36 * max(map(len, steps))
    figure, [both] = panels(narrow, (1, 2), (9.6, height), (NARROW, height))
    for axes, gap, rows in zip(both, gaps, steps):
        end = 0.0
        for row, (_, bar) in enumerate(rows):
            axes.barh(row, bar.value, height=0.6, color=bar.color, alpha=0.85)
            right = bar.value
            if bar.interval:
                draw_interval(
                    axes, bar.interval, row, color=INK, linewidth=2, solid_capstyle="butt"
                )
                right = max(right, bar.interval[1])
            axes.text(right, row, f" {bar.value:.4f}", va="center", fontsize=9, color=INK)
            end = max(end, right)
        axes.set_xlim(0, 1.25 * (end or 1.0))
        axes.locator_params(axis="x", nbins=5)
        entitle_axes(axes, f"{gap['title'].split(', ')[0]}, in its own best order", 11)
        axes.set_xlabel(f"{gap['title']} [{gap['unit']}]")
        name_rows(axes, [name for name, _ in rows])
    return figure


def _steps(attribution: Attribution, gap: Json) -> List[Tuple[str, Bar]]:
    def baseline_bar(key: str, color: str) -> Bar:
        return Bar(gap[key]["value"], gap[key]["interval"], color)

    rows = [("tee never moves", baseline_bar("null_model", DIM))]
    if gap["baseline"]["value"] is not None:
        rows.append((attribution.content["baseline"], baseline_bar("baseline", COLORS[ENGINE])))
    rows.append(("all off", Bar(gap["staircase"][0], None, COLORS[REPLAY])))
    for name, value in zip(gap["best_order"], gap["staircase"][1:]):
        rows.append((f"+ {name}", Bar(value, None, COLORS[REPLAY])))
    if gap["floor"]["value"] is not None:
        floor = f"floor of {attribution.content['reference']}"
        rows.append((floor, baseline_bar("floor", COLORS["reference"])))
    return [(wrapped(name, 24), bar) for name, bar in rows]
