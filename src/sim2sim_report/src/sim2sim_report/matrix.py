# SPDX-License-Identifier: BSD-3-Clause
"""The matrix of a sweep over policies, as the command `matrix` has written it, and its figures."""

import functools
from pathlib import Path
from typing import Any, Dict, List, NamedTuple, Optional, Sequence

from pusht_task.error import Error
from pusht_task.json_file import Json, read_json, require_format
from sim2sim_protocol.result_files import format_of, name_of

from sim2sim_report.colors import CARD, COLORS, DIM, GRID, INK, SERIES
from sim2sim_report.figures import (
    NARROW,
    Drawing,
    add_legend,
    box,
    draw_interval,
    entitle_axes,
    name_cells,
    name_rows,
    panels,
    wrapped,
)

FILE = name_of("matrix")
MARKERS = "osD^vP"  # with the colors they tell groups apart
STRONGEST = 0.6  # opacity of a success rate of 1: the text on it must be legible


class Line(NamedTuple):
    """A line of the heatmap: a group, or a policy of a sweep without groups."""

    name: str
    reference: Optional[int]  # its simulator; None where a group has several
    cells: List[Optional[Json]]  # success: value and interval


class Matrix:
    def __init__(self, content: Json) -> None:
        self.content = content
        self.titles: List[str] = [simulator["title"] for simulator in content["simulators"]]
        self.policies: List[Json] = content["policies"]

    @property
    def lines(self) -> List[Line]:
        groups = [
            Line(f"{group['group']} ({len(group['policies'])})", self._home(group), cells)
            for group in self.content["groups"]
            for cells in [[cell and cell["success_rate"] for cell in group["cells"]]]
        ]
        alone = [
            Line(policy["policy"], policy["reference"], [_success(c) for c in policy["cells"]])
            for policy in self.policies
            if not policy["group"]
        ]
        return groups + alone

    def _home(self, group: Json) -> Optional[int]:
        homes = {self.policies[policy]["reference"] for policy in group["policies"]}
        return homes.pop() if len(homes) == 1 else None

    @property
    def here(self) -> int:
        """The simulator that most policies have as their reference."""
        references = [policy["reference"] for policy in self.policies]
        return max(sorted(set(references)), key=references.count)

    @property
    def rankings(self) -> List[Json]:
        """Rankings from `here` to each other simulator."""
        return [r for r in self.content["rankings"] if r["reference"] == self.here]


def _success(cell: Optional[Json]) -> Optional[Json]:
    return cell and {"value": cell["success_rate"], "interval": cell["success_interval"]}


def has_matrix(folder: Path) -> bool:
    return (folder / FILE).exists()


def read_matrix(folder: Path) -> Matrix:
    content = read_json(folder / FILE)
    require_format(folder / FILE, content, format_of("matrix"))
    try:
        return Matrix(content)
    except (KeyError, TypeError) as error:
        raise Error(f"{folder / FILE}: is not as this version writes it: {error!r}") from None


def draw(matrix: Matrix) -> List[Drawing]:
    alt = "Success rates: " + "; ".join(
        f"{line.name} {', '.join(_rate(cell) for cell in line.cells)}" for line in matrix.lines
    )
    figures = [("matrix", alt, _heatmap)]
    if matrix.content["spreads"]:
        figures.append(("spread", "What makes the cells differ", _spread))
    if matrix.rankings:
        figures.append(("rankings", "Success there, and here", _rankings))
    return [Drawing(name, alt, functools.partial(build, matrix)) for name, alt, build in figures]


def _rate(cell: Optional[Json]) -> str:
    return f"{cell['value']:.2f}" if cell else "none"


def _heatmap(matrix: Matrix, narrow: bool) -> Any:
    """Success by line and simulator: the darker the higher; the reference has a frame."""
    lines = matrix.lines
    sizes = ((9.8, 1.0 + 0.46 * len(lines)), (NARROW, 1.3 + 0.3 * len(lines)))
    figure, [[axes]] = panels(narrow, (1, 1), *sizes)
    font = 6.5 if narrow else 10
    for row, line in enumerate(lines):
        for column, cell in enumerate(line.cells):
            if cell is None:
                continue
            place = (column - 0.48, row - 0.46)
            color = COLORS["reference"]
            size_of_box = {"width": 0.96, "height": 0.92}
            axes.add_patch(box(place, size_of_box, color, STRONGEST * cell["value"]))
            if column == line.reference:
                axes.add_patch(box(place, size_of_box, INK, None))
            ends = cell["interval"]
            below = f"\n[{ends[0]:.2f}, {ends[1]:.2f}]" if ends and not narrow else ""
            axes.text(column, row, _rate(cell) + below, ha="center", va="center", fontsize=font)
    rows = [wrapped(line.name, 18 if narrow else 30) for line in lines]
    columns = [wrapped(title, 10 if narrow else 14) for title in matrix.titles]
    name_cells(axes, rows, columns, fontsize=5.5 if narrow else 10)
    axes.tick_params(axis="x", labeltop=True, labelbottom=False)
    axes.tick_params(axis="y", labelsize=font)
    return figure


def _spread(matrix: Matrix, narrow: bool) -> Any:
    """Shares of the variance of the cells, stacked, a bar for each figure."""
    spreads = matrix.content["spreads"]
    height = 1.2 + 0.5 * len(spreads)
    figure, [[axes]] = panels(narrow, (1, 1), (9.6, height), (NARROW, height))
    for row, spread in enumerate(spreads):
        left = 0.0
        for source, color in zip(spread["sources"], [*SERIES, DIM]):
            share = 100.0 * (source["share"] or 0.0)
            label = source["source"].replace(" x ", " × ")
            axes.barh(row, share, left=left, height=0.7, color=color, label=label)
            if share >= (12 if narrow else 5):
                middle = {"ha": "center", "va": "center", "color": CARD, "weight": "bold"}
                axes.text(left + share / 2, row, f"{share:.0f} %", **middle)
            left += share
    name_rows(axes, [wrapped(s["figure"].replace("_", " "), 16) for s in spreads])
    axes.set_xlim(0, 100)
    axes.set_xlabel("share of the variance of the cells [%]")
    add_legend(figure, "upper", 2 if narrow else 3)
    return figure


def _rankings(matrix: Matrix, narrow: bool) -> Any:
    """Success in each other simulator against that here: a point for each policy."""
    rankings = matrix.rankings
    across = 1 if narrow else min(3, len(rankings))
    down = -(-len(rankings) // across)
    groups = list(dict.fromkeys(policy["group"] for policy in matrix.policies))
    sizes = ((9.8, 3.2 * down), (NARROW, 3.2))
    figure, grid = panels(narrow, (down, across), *sizes, sharex=True, sharey=True)
    for axes in grid.flat[len(rankings) :]:
        axes.remove()
    for axes, ranking in zip(grid.flat, rankings):
        _draw_ranking(axes, matrix, ranking, groups)
    if groups != [""]:
        add_legend(figure, "upper", 1 if narrow else 3)
    return figure


def _draw_ranking(axes: Any, matrix: Matrix, ranking: Json, groups: Sequence[str]) -> None:
    axes.plot([0, 1], [0, 1], color=GRID, linewidth=1, zorder=0)
    for policy in matrix.policies:
        here, there = (_success(policy["cells"][ranking[key]]) for key in ("reference", "test"))
        if not here or not there:
            continue
        number = groups.index(policy["group"])
        color = SERIES[number % len(SERIES)]
        marker = MARKERS[(number // len(SERIES)) % len(MARKERS)]
        x, y = here["value"], there["value"]
        thin: Dict[str, Any] = {"color": color, "linewidth": 1, "alpha": 0.5}
        draw_interval(axes, here["interval"], y, **thin)
        draw_interval(axes, there["interval"], x, upright=True, **thin)
        point = {"color": color, "markersize": 5, "label": policy["group"] or "no group"}
        axes.plot(x, y, marker, markeredgecolor=CARD, markeredgewidth=0.5, **point)
    axes.set(xlim=(-0.04, 1.04), ylim=(-0.04, 1.04), xticks=(0, 0.5, 1), yticks=(0, 0.5, 1))
    axes.set_xlabel(f"success in {matrix.titles[ranking['reference']]}", fontsize=9)
    axes.set_ylabel(f"in {wrapped(matrix.titles[ranking['test']], 24)}", fontsize=9)
    kendall = ranking["kendall"]
    ends = kendall["interval"]
    found = "" if kendall["value"] is None else f", tau {kendall['value']:.2f}"
    found += f" [{ends[0]:.2f}, {ends[1]:.2f}]" if ends else ""
    entitle_axes(axes, f"ranking: {ranking['verdict']}{found}", 9)
