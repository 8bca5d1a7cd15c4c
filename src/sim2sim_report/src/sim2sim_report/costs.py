# SPDX-License-Identifier: BSD-3-Clause
"""The figure of what switches cost when they are off, over several engines: a column for each sweep
that `attribute` has looked at, position above and angle below."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, List, Sequence

from pusht_task.error import Error
from pusht_task.json_file import Json

from sim2sim_report.attribution import Attribution, read_attribution
from sim2sim_report.colors import COLORS, DIM, INK
from sim2sim_report.figures import (
    OWN_STYLE,
    POINTS,
    Drawing,
    add_legend,
    draw_interval,
    fitted,
    name_rows,
    panels,
)
from sim2sim_report.results import ENGINE, REPLAY

COLUMN, ROW = 5.0, 0.46  # [in] width of a panel, height of a row in it
MARGIN = 0.5  # [in] beside a panel's title
TITLE, SUBTITLE = 16, 11  # [pt]
LINE = 1.3  # height of a line, in font sizes
SERIES = (  # key of a figure in attribution.json, what it is, color, marker
    ("share", "share of the whole gap (mean over all orders of switching on)", COLORS[REPLAY], "o"),
    ("leave_one_out", "off alone", COLORS[ENGINE], "s"),
)
THOUSANDTH = {"m": "mm", "rad": "mrad"}


@dataclass(frozen=True)
class Costs:
    attributions: Sequence[Attribution]
    missing = ""  # only whole sweeps have been attributed

    def drawing(self, name: str) -> Drawing:
        engines = ", ".join(found.content["engine"] for found in self.attributions)
        alt = f"What each switch costs in divergence when it is off, for {engines}"
        return Drawing(name, alt, self._figure, OWN_STYLE)

    def _figure(self, narrow: bool) -> Any:
        count = len(self.attributions)
        rows = max(len(found.switches) for found in self.attributions)
        wrapped = max(_title(found).count("\n") for found in self.attributions)
        height = 1.8 + ROW * rows + wrapped * LINE * TITLE / POINTS
        size = (COLUMN * count + 0.6, 2 * height)
        figure, grid = panels(narrow, (2, count), size, (COLUMN, height), by_column=True)
        for line, component in zip(grid, ("position", "angle")):
            for axes, found in zip(line, self.attributions):
                _draw(axes, found, _shortest(found, component))
            if not narrow:
                farthest = max(axes.get_xlim()[1] for axes in line)
                for axes in line:
                    axes.set_xlim(min(axes.get_xlim()[0], -0.02 * farthest), farthest)
        add_legend(figure, "upper", 1 if narrow or count == 1 else 2)
        return figure


def read_costs(folders: List[Path]) -> Costs:
    found = [read_attribution(folder) for folder in folders]
    for folder, attribution in zip(folders, found):
        if not attribution.is_exact:
            raise Error(
                f"results {folder}: runs orders of switching on; only a sweep of all subsets says "
                "what each switch costs when it is off alone"
            )
        if len(attribution.gaps("position")) < 2:
            raise Error(
                f"results {folder}: has no re-anchored replay; run the sweep with `reanchor: [5]`"
            )
    return Costs(found)


def _shortest(attribution: Attribution, component: str) -> Json:
    """The gap of the shortest replay, in which effects do not saturate."""
    return attribution.gaps(component)[1]


def _draw(axes: Any, attribution: Attribution, gap: Json) -> None:
    names = [name for name, _ in attribution.ranked(gap)]
    for number, (key, label, color, marker) in enumerate(SERIES):
        places = [row + 0.2 * (2 * number - 1) for row in range(len(names))]
        values = [_value(gap["switches"][name], key) for name in names]
        for place, name in zip(places, names):
            draw_interval(axes, _interval(gap["switches"][name], key), place, 1e3, color=color)
        axes.plot([1e3 * v for v in values], places, marker, color=color, label=label)
    axes.axvline(0, color=INK, linewidth=1)
    name_rows(axes, names)
    unit = THOUSANDTH[gap["unit"]]
    ends = f"all off {1e3 * gap['all_off']:.1f}, all on {1e3 * gap['all_on']:.1f} {unit}"
    still = f"a tee that stands still {1e3 * gap['null_model']['value']:.1f}"
    below = fitted(f"{ends}; {still}", COLUMN, SUBTITLE)
    axes.set_title(
        _title(attribution), fontsize=TITLE, pad=8 + LINE * SUBTITLE * (1 + below.count("\n"))
    )
    axes.annotate(
        *(below, (0.5, 1.0), (0, 6), "axes fraction", "offset points"),
        **{"ha": "center", "color": DIM, "fontsize": SUBTITLE},
    )
    axes.set_xlabel(f"{gap['title'].replace('re-anchored ', '')} [{unit}]")
    axes.locator_params(axis="x", nbins=6)


def _title(attribution: Attribution) -> str:
    return fitted(attribution.content["engine"], COLUMN - MARGIN, TITLE)


def _value(switch: Json, key: str) -> float:
    found = switch[key]
    return float(found["value"] if isinstance(found, dict) else found)


def _interval(switch: Json, key: str) -> Any:
    found = switch[key]
    return found["interval"] if isinstance(found, dict) else switch["share_interval"]
