# SPDX-License-Identifier: BSD-3-Clause
"""The figure of convergence: divergence over the value of a numeric parameter, of model variants
and of the rows of a sweep, on logarithmic axes."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence, Tuple

from pusht_task.error import Error
from sim2sim_protocol.result_files import name_of

from sim2sim_report.again import VARIANT
from sim2sim_report.colors import CARD, DIM, SERIES
from sim2sim_report.curves import MOST_LINES, what_is_missing
from sim2sim_report.figures import (
    COMPONENTS,
    MARKERS,
    OWN_STYLE,
    Drawing,
    draw_interval,
    entitle,
    labeled,
    legend_labels,
    panels,
    width_of,
)
from sim2sim_report.results import REPLAY
from sim2sim_report.sweep_rows import (
    Row,
    lines_over,
    read_rows,
    title_of_role,
    unit_of,
    varied_parameters,
)

COURSE = {"position": "pos", "angle": "ang"}
WHOLE, FIRST_2_S = "whole replay", "first 2 s"
SIZE = (13.0, 9.0)  # [in]
NARROW = (5.2, 4.1)  # [in] of a panel, for a phone: all below each other
Panel = Tuple[str, str, str]  # horizon, component and its unit


@dataclass(frozen=True)
class Point:
    """Figures of a replay at a value of the parameter."""

    value: float
    row: Row
    rollout: str  # REPLAY or a model variant

    def figure(self, horizon: str, component: str, unit: str, suffix: str = "") -> Any:
        if horizon == FIRST_2_S:
            name = f"{self.rollout}_early_{component}_divergence"
        elif self.rollout == REPLAY:
            name = f"mean_{COURSE[component]}_divergence"
        else:
            name = f"{self.rollout}_mean_{component}_divergence"
        return self.row.get(f"{name}{suffix}_{unit}")


@dataclass(frozen=True)
class Line:
    """Replays over a parameter, by growing value."""

    parameter: str
    unit: str
    title: str  # of the simulator
    points: List[Point]
    reference: Optional[float] = None  # value of the parameter in the reference

    @property
    def label(self) -> str:
        return f"{self.title}, {self.parameter}"


def lines_of_variants(row: Row) -> List[Line]:
    """Lines of the model variants with one numeric parameter that takes several values."""
    values: Dict[str, List[Point]] = {}
    for probe in row["probes"]:
        name, _, text = probe[len(VARIANT) :].partition("=")
        if not probe.startswith(VARIANT) or not is_number(text):
            continue
        values.setdefault(name, []).append(Point(float(text), row, probe))
    reference = row["simulators"]["reference"]
    return [
        Line(
            name,
            reference["units"].get(name) or "",
            reference["title"],
            sorted(points, key=lambda point: point.value),
            reference["parameters"][name],
        )
        for name, points in values.items()
        if len(points) > 1
    ]


def lines_of_rows(rows: Sequence[Row]) -> List[Line]:
    """Lines of the rows: one for each engine whose only varied parameter is numeric."""
    parameters = varied_parameters(rows)
    lines = []
    for parameter in parameters:
        numeric = [
            row
            for row in rows
            if is_number(row["knobs"].get(parameter))
            and not any(other in row["knobs"] for other in parameters if other != parameter)
        ]
        for line in lines_over(parameter, [parameter], numeric).values():
            points = [Point(row["knobs"][parameter], row, REPLAY) for row in line]
            unit = unit_of(parameter, line)
            lines.append(Line(parameter, unit, title_of_role(line[0], "engine"), points))
    return [line for line in lines if len(line.points) > 1]


def is_number(value: Any) -> bool:
    """True for a number and for the text of one."""
    if value is None or isinstance(value, bool):
        return False
    try:
        float(value)
    except ValueError:
        return False
    return True


def draw_line(axes: Any, line: Line, number: int, panel: Panel) -> None:
    """Means with their intervals, filled; medians, hollow. What is 0 has no place on the axis."""
    style: Dict[str, Any] = {"color": SERIES[number], "marker": MARKERS[number]}
    first = number == 0  # it is wide, so that lines that coincide are both seen
    style.update(linewidth=4.5 if first else 1.6, markersize=12 if first else 6, zorder=2 + number)
    for suffix, name, more in (
        ("", f"{line.label}: mean", {}),
        ("_median", f"{line.label}: median", {"linestyle": "--", "markerfacecolor": CARD}),
    ):
        points = [point for point in line.points if (point.figure(*panel, suffix) or 0.0) > 0]
        if not points:
            continue
        y = [point.figure(*panel, suffix) for point in points]
        axes.plot([point.value for point in points], y, label=name, **style, **more)
        thin: Dict[str, Any] = {"color": SERIES[number], "linewidth": 1.4}
        for point in points:
            interval = point.figure(*panel, f"{suffix}_interval")
            if interval is not None and interval[0] > 0:
                draw_interval(axes, interval, point.value, upright=True, **thin)


def draw_first_order(axes: Any, line: Line, panel: Panel) -> None:
    """What errors of first order would do: grow with the distance from the reference's value."""
    first, last = line.points[-1], line.points[0]
    if line.reference is None or line.reference >= last.value:
        return
    values = [first.value * (last.value / first.value) ** (i / 50) for i in range(51)]
    for suffix in ("", "_median"):
        start = first.figure(*panel, suffix)
        if start:
            slope = start / (first.value - line.reference)
            y = [slope * (value - line.reference) for value in values]
            axes.plot(values, y, color=DIM, linestyle=":", linewidth=1.8, zorder=5)


@dataclass(frozen=True)
class Convergence:
    """The lines of a sweep, ready to be drawn."""

    rows: List[Row]
    whole: int  # rows of the whole sweep
    lines: List[Line]

    @property
    def missing(self) -> str:
        """The warning for a sweep that is not whole; else empty."""
        return what_is_missing(len(self.rows), self.whole)

    def drawing(self, name: str) -> Drawing:
        alt = "Divergence over " + ", ".join(line.label for line in self.lines)
        return Drawing(name, alt, self._figure, OWN_STYLE)

    def _figure(self, narrow: bool) -> Any:
        shown = [(horizon, *parts) for horizon in (WHOLE, FIRST_2_S) for parts in COMPONENTS]
        figure, grid = panels(narrow, (2, 2), SIZE, NARROW, sharex=not narrow)
        names = ", ".join(dict.fromkeys(line.parameter for line in self.lines))
        units = {line.unit for line in self.lines}
        unit_of_all = f" [{units.pop()}]" if len(units) == 1 and "" not in units else ""
        for number, (axes, panel) in enumerate(zip(grid.flat, shown)):
            for place, line in enumerate(self.lines):
                draw_line(axes, line, place, panel)
                draw_first_order(axes, line, panel)
            axes.set_xscale("log")
            axes.set_yscale("log")
            values = sorted({point.value for line in self.lines for point in line.points})
            axes.set_xticks(values, [f"{value:g}" for value in values])
            axes.set_xticks([], minor=True)
            axes.set_ylabel(f"{panel[1]} divergence [{panel[2]}]\n{panel[0]}", linespacing=1.5)
            if narrow or number >= 2:
                axes.set_xlabel(names + unit_of_all)
        first = grid[0, 0]
        handles = labeled([first])
        labels = legend_labels(handles, 0.75 * width_of(first), 11)
        first.legend(handles.values(), labels, loc="best", fontsize=11)
        entitle(figure, self._title(), 10 if narrow else 14)
        return figure

    def _title(self) -> List[str]:
        row = self.rows[0]
        reference = row["simulators"]["reference"]
        changed = [f"{name} {reference['parameters'][name]}" for name in reference["changed"]]
        of = " with ".join(filter(None, [reference["title"], ", ".join(changed)]))
        return [
            f"divergence from {of}, in replays of its actions (policy {row['policy']})",
            f"{row['episodes']:,} episodes, {100 * row['confidence']:g} % intervals"
            "; dotted: in proportion to the difference from the reference's value",
            self.missing,
        ]


def read_convergence(folder: Path) -> Convergence:
    """The lines of a sweep. Raises Error if no numeric parameter takes several values."""
    rows, whole = read_rows(folder)
    lines = lines_of_variants(rows[0]) + lines_of_rows(rows)
    if not lines or len(lines) > MOST_LINES:
        raise Error(
            f"{folder / name_of('sweep')}: {len(lines)} numeric parameters of model variants or"
            f" rows take more than one value; from 1 to {MOST_LINES} must"
        )
    return Convergence(rows, whole, lines)
