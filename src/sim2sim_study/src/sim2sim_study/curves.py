# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of the studies: success over epochs, transfer over noise."""

from pathlib import Path
from typing import Any, Callable, Dict, List, NamedTuple, Sequence, Tuple

from pusht_task.files import write_file
from sim2sim_report.colors import DIM, SERIES
from sim2sim_report.figures import MARKERS, NARROW, Drawing, add_legend, draw_interval, panels

from sim2sim_study.conduct import HOME
from sim2sim_study.tables import Row


class Line(NamedTuple):
    """A simulator's line in a panel."""

    simulator: str
    x: List[float]
    y: List[float]
    ends: List[Tuple[Any, Any]]  # of the interval at each point; none or "" where there is none
    style: str
    marker: str = "o"


def write_curves(path: Path, alt: str, build: Callable[[bool], Any]) -> None:
    """Writes a PNG of the figure that `build` makes."""
    write_file(path, Drawing("curves", alt, build).file("png", "sim2sim study"))


def draw_epochs(rows: Sequence[Row], narrow: bool) -> Any:
    """A panel for each training: success over epochs."""
    titled: Dict[str, List[Line]] = {}
    for (training, simulator), line in _lines(rows, "training", "epochs").items():
        style = "-" if simulator == HOME else "--" if simulator.startswith(HOME) else "-."
        x = [row["epochs"] for row in line]
        ends = [(row["success_low"], row["success_high"]) for row in line]
        y = [row["success"] for row in line]
        titled.setdefault(training, []).append(Line(simulator, x, y, ends, style))
    figure = _figure(titled, narrow, 4)
    for axes, lines in zip(figure.axes, titled.values()):
        axes.set_xscale("log")
        axes.set_xticks(lines[-1].x, [str(x) for x in lines[-1].x])
        axes.minorticks_off()
        axes.set_xlabel("epochs of training")
    figure.axes[0].set_ylabel("success rate")
    return figure


DODGE = 0.07  # between engines at the same noise, in distances of two sizes of noise


def draw_noise(rows: Sequence[Row], narrow: bool) -> Any:
    """A panel for each recipe: transfer over noise on the positions; sizes of noise stand at even
    distances, engines a little beside each other."""
    sizes = sorted({float(row["noise_mm"]) for row in rows})
    engines = [row for row in rows if row["transfer"] is not None]
    simulators = list(dict.fromkeys(row["simulator"] for row in engines))
    titled: Dict[str, List[Line]] = {}
    for (recipe, simulator), line in _lines(engines, "group", "noise_mm").items():
        place = simulators.index(simulator)
        beside = DODGE * (place - (len(simulators) - 1) / 2)
        x = [sizes.index(row["noise_mm"]) + beside for row in line]
        ends = [(row["transfer_low"], row["transfer_high"]) for row in line]
        y = [row["transfer"] for row in line]
        marker = MARKERS[place % len(MARKERS)]
        titled.setdefault(recipe, []).append(Line(simulator, x, y, ends, "-", marker))
    figure = _figure(titled, narrow, 3)
    for axes in figure.axes:
        axes.axhline(1.0, color=DIM, linewidth=1, linestyle="--")
        axes.set_xticks(range(len(sizes)), [f"{size:g}" for size in sizes])
        axes.set_xlabel("noise on the observed positions [mm]")
        axes.set_ylim(bottom=0.0)
    figure.axes[0].set_ylabel("success over that in MuJoCo")
    return figure


def _lines(rows: Sequence[Row], panel: str, x: str) -> Dict[Tuple[str, str], List[Row]]:
    """Rows by panel and simulator, in the order of x."""
    found: Dict[Tuple[str, str], List[Row]] = {}
    for title in dict.fromkeys(row[panel] for row in rows):
        for simulator in dict.fromkeys(row["simulator"] for row in rows):
            line = [row for row in rows if (row[panel], row["simulator"]) == (title, simulator)]
            found[title, simulator] = sorted(line, key=lambda row: float(row[x]))
    return found


def _figure(titled: Dict[str, List[Line]], narrow: bool, across: int) -> Any:
    """Panels beside each other, or below each other, under one legend with so many in a line."""
    sizes = ((9.8, 4.2), (NARROW, 3.4))
    figure, grid = panels(narrow, (1, max(1, len(titled))), *sizes, sharey=True)
    for axes, (title, lines) in zip(grid.flat, titled.items()):
        for line, color in zip(lines, [*SERIES, DIM]):
            style = {"color": color, "marker": line.marker, "label": line.simulator}
            axes.plot(line.x, line.y, line.style, **style)
            for x, ends in zip(line.x, line.ends):
                if ends[0] not in ("", None):
                    draw_interval(axes, ends, x, upright=True, color=color, linewidth=1)
        axes.set_title(title, fontsize=11)
    if titled:
        add_legend(figure, "upper", 2 if narrow else across)
    return figure
