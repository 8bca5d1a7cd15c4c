# SPDX-License-Identifier: BSD-3-Clause
"""The figure of an agreement: distances of all pairs of simulators as a matrix, as a tree, as means
with intervals, and as a map."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence, Tuple

import numpy as np
from pusht_task.error import Error
from pusht_task.json_file import Json, read_json, require_format
from scipy.cluster import hierarchy  # type: ignore[import]
from scipy.spatial.distance import squareform  # type: ignore[import]
from sim2sim_protocol.result_files import format_of

from sim2sim_report.colors import CARD, DIM, INK, SERIES
from sim2sim_report.figures import (
    COMPONENTS,
    OWN_STYLE,
    Drawing,
    box,
    disc,
    draw_interval,
    entitle,
    name_cells,
    name_rows,
    panels,
)
from sim2sim_report.matrix import MARKERS, STRONGEST

OPEN_LOOP = 0  # stands for a replay without resets
USUAL = 5  # [control steps] between resets
THOUSAND = 1000.0  # figures are in thousandths of the unit
WIDE = (17.0, 9.6)  # [in]
NARROW = (5.2, 3.6)  # [in] of a panel, for a phone: all below each other
WIDTHS = (1.5, 0.9, 1.0, 1.2)  # of the panels beside each other
MOST_WITH_INTERVALS = 6  # simulators of a matrix whose cells have room for intervals
LABELS_APART = 0.06  # half the height of a label, as a share of half the map
LETTER = 0.055  # width of a letter, likewise
STYLE = {**OWN_STYLE, "font.size": 12, "axes.labelsize": 12, "axes.grid.axis": "x"}

Box = Tuple[float, float, float, float]  # left, right, low, high


def principal_coordinates(distances: Any) -> Tuple[Any, float]:
    """Places in a plane whose distances are as near as can be to those given, and the share of the
    squared distances that the plane has. Classical multidimensional scaling.
    Source: W. S. Torgerson, "Multidimensional scaling: I. Theory and method" (1952)."""
    count = len(distances)
    center = np.eye(count) - 1.0 / count
    values, vectors = np.linalg.eigh(-0.5 * center @ distances**2 @ center)
    values, vectors = values[::-1], vectors[:, ::-1]
    places = np.zeros((count, 2))
    axes = min(2, count)
    places[:, :axes] = vectors[:, :axes] * np.sqrt(np.maximum(values[:axes], 0.0))
    farthest = places[np.abs(places).argmax(axis=0), range(2)]
    total = np.abs(values).sum()
    kept = np.maximum(values[:axes], 0.0).sum() / total if total > 0 else 1.0
    return places * np.where(farthest < 0, -1.0, 1.0), float(kept)


def tree(distances: Any) -> Any:
    """Tree in which the two nearest groups are joined, again and again, at the mean distance of
    their members (average linkage, UPGMA)."""
    return hierarchy.linkage(squareform(distances, checks=False), "average", optimal_ordering=True)


def text_of(value: float) -> str:
    """Two digits that count: "0.013", "4.7", "120"."""
    if value == 0:
        return "0"
    rounded = float(f"{value:.2g}")
    return f"{rounded:.{max(0, 1 - math.floor(math.log10(abs(rounded))))}f}"


@dataclass(frozen=True)
class Component:
    """Position or angle of one kind of replay, in thousandths of its unit."""

    name: str
    content: Json

    @property
    def unit(self) -> str:
        return f"m{self.content['unit']}"

    @property
    def distances(self) -> Any:
        """Mean of there and back, for what has no direction."""
        rows = self.content["distances"]
        values = THOUSAND * np.array([[cell["value"] for cell in row] for row in rows])
        return (values + values.T) / 2

    def farthest_variant(self, simulator: int) -> Optional[float]:
        values = [each["value"] for each in self.content["variants"][simulator]]
        return THOUSAND * max(values) if values else None


@dataclass(frozen=True)
class AgreementFigure:
    """Content of an agreement's file, and the kind of replay that is drawn."""

    content: Json
    replay: Json

    @property
    def titles(self) -> List[str]:
        """Titles of the kinds, with what was said of them: not all that a preset sets."""
        return [
            ", ".join([each["simulator"]["title"], *each["name"].split(":")[1:]])
            for each in self.content["simulators"]
        ]

    @property
    def components(self) -> List[Component]:
        return [Component(name, self.replay[name]) for name, _ in COMPONENTS]

    def drawing(self, name: str) -> Drawing:
        alt = f"Distances between {', '.join(self.titles)}: matrix, tree, means and map"
        return Drawing(name, alt, self._figure, STYLE)

    def _figure(self, narrow: bool) -> Any:
        shape = (len(self.components), len(WIDTHS))
        widths = None if narrow else WIDTHS
        figure, grid = panels(narrow, shape, WIDE, NARROW, width_ratios=widths)
        for (matrix, branches, means, plane), component in zip(grid, self.components):
            linked = tree(component.distances)
            order = [int(leaf) for leaf in hierarchy.leaves_list(linked)]
            self._matrix(matrix, component, order)
            self._tree(branches, component, linked, order, narrow)
            self._means(means, component, order, narrow)
            self._map(plane, component)
        entitle(figure, self._title(narrow), 10 if narrow else 15)
        figure.get_layout_engine().set(w_pad=0.08, h_pad=0.12)  # [in]
        return figure

    @property
    def how(self) -> str:
        every = self.replay["reset_every"]
        if every is None:
            return "In open loop"
        steps = "control step" if every == 1 else f"{every} control steps"
        return f"Reset to the reference every {steps}"

    @property
    def is_usual(self) -> bool:
        """Whether this kind of replay is the one to show where one is shown."""
        kinds = [replay["reset_every"] for replay in self.content["replays"]]
        return bool(self.replay["reset_every"] == (USUAL if USUAL in kinds else kinds[0]))

    def _title(self, narrow: bool) -> List[str]:
        run = self.content["run"]
        reference = self.content["reference"]
        along = f"{reference['title']}'s" if reference else "each simulator's"
        lines = [f"How far apart do simulators take the tee? {self.how}"]
        lines.append(
            f"all replay {along} actions; policy {run['policy']}, {run['episodes']:,} episodes,"
            f" {100 * self.content['confidence']:g} % intervals"
        )
        return [part for line in lines for part in (line.split("? ") if narrow else [line])]

    def _color(self, simulator: int) -> str:
        return SERIES[simulator % len(SERIES)]

    def _marker(self, simulator: int) -> str:
        return MARKERS[simulator % len(MARKERS)]

    def _matrix(self, axes: Any, component: Component, order: Sequence[int]) -> None:
        """A cell for each pair: the farther, the darker, by the logarithm."""
        rows = component.content["distances"]
        logs = [math.log(cell["value"]) for row in rows for cell in row if cell["value"] > 0]
        least, most = (min(logs), max(logs)) if logs else (0.0, 0.0)
        for y, i in enumerate(order):
            for x, j in enumerate(order):
                cell = rows[i][j]
                share = 0.0
                if cell["value"] > 0:
                    share = (math.log(cell["value"]) - least) / (most - least or 1.0)
                    size = {"width": 0.94, "height": 0.94}
                    opacity = STRONGEST * (0.08 + 0.92 * share)
                    axes.add_patch(box((x - 0.47, y - 0.47), size, SERIES[0], opacity))
                self._cell(axes, x, y, cell, i == j)
        names = [self.titles[i].replace(", ", ",\n") for i in order]
        name_cells(axes, names, names, rotation=30, ha="right", rotation_mode="anchor")
        whose = "" if self.content["reference"] else "; rows: whose actions"
        title = f"{component.name} [{component.unit}]{whose}"
        axes.set_title(title, loc="left", color=INK, fontsize=14)

    def _cell(self, axes: Any, x: int, y: int, cell: Json, is_itself: bool) -> None:
        if is_itself:
            axes.text(x, y, "·", ha="center", va="center", color=DIM)
            return
        interval = cell["interval"] if len(self.titles) <= MOST_WITH_INTERVALS else None
        style: Dict[str, Any] = {"ha": "center", "color": INK}
        up = 0.1 if interval else 0.0
        text = text_of(THOUSAND * cell["value"])
        axes.text(x, y - up, text, va="center", fontsize=13, **style)
        if interval:
            small = 8 if len(self.titles) < 5 else 6.5
            ends = ", ".join(text_of(THOUSAND * end) for end in interval)
            axes.text(x, y + 0.24, f"[{ends}]", va="center", fontsize=small, **style)

    def _tree(
        self, axes: Any, component: Component, linked: Any, order: Sequence[int], narrow: bool
    ) -> None:
        """Branches from the right, where simulators are one, to the left: rows as in the matrix."""
        drawn = hierarchy.dendrogram(linked, no_plot=True)
        heights = linked[:, 2]
        positive = heights[heights > 0]
        least = positive.min() / 3 if len(positive) else 0.1
        for ys, xs in zip(drawn["icoord"], drawn["dcoord"]):
            rows = [(y - 5) / 10 for y in ys]  # scipy's leaves are 10 apart, the first at 5
            axes.plot(np.maximum(xs, least), rows, color=INK, linewidth=1.8)
        for row, simulator in enumerate(order):
            style = {"color": self._color(simulator), "markersize": 9, "clip_on": False}
            axes.plot(least, row, self._marker(simulator), **style)
        axes.set_xscale("log")
        axes.set_xlim(least, heights.max() * 1.6 if len(positive) else 1.0)
        self._name_rows(axes, order, narrow)
        axes.set_xlabel(f"joined at [{component.unit}]")

    def _means(self, axes: Any, component: Component, order: Sequence[int], narrow: bool) -> None:
        """Mean distance to all others with its interval, and to the own variant."""
        central = component.content["most_central"]
        for row, simulator in enumerate(order):
            color = self._color(simulator)
            others = component.content["others"][simulator]
            draw_interval(axes, others["interval"], row, THOUSAND, color=color, linewidth=3)
            value = THOUSAND * others["value"]
            axes.plot(value, row, self._marker(simulator), color=color, markersize=9)
            variant = component.farthest_variant(simulator)
            if variant:
                style = {"color": color, "markerfacecolor": CARD, "markersize": 8}
                axes.plot(variant, row, self._marker(simulator), zorder=4, **style)
            if central is not None and central[simulator] >= 0.005:
                text = f"central in {100 * central[simulator]:.0f} %"
                place = (0, 11)  # [points] above the mark
                axes.annotate(
                    text, (value, row), place, ha="center", fontsize=9, textcoords="offset points"
                )
        axes.set_xscale("log")
        axes.margins(x=0.15)
        self._name_rows(axes, order, narrow)
        axes.set_xlabel(f"to all others, hollow: to own variant [{component.unit}]")

    def _name_rows(self, axes: Any, order: Sequence[int], narrow: bool) -> None:
        """Rows as those of the matrix, which has their names if it is beside."""
        name_rows(axes, [self.titles[i] if narrow else "" for i in order])
        axes.grid(axis="x", visible=True)

    def _map(self, axes: Any, component: Component) -> None:
        """Places by distance; the circle around each reaches as far as its own variant."""
        places, kept = principal_coordinates(component.distances)
        low, high = places.min(axis=0), places.max(axis=0)
        half = 0.68 * max((high - low).max(), 1e-9)
        center = (low + high) / 2
        for simulator, place in enumerate(places):
            color = self._color(simulator)
            radius = component.farthest_variant(simulator)
            if radius:
                axes.add_patch(disc(place, radius, color, 0.25))
            axes.plot(*place, self._marker(simulator), color=color, markersize=10, zorder=3)
        self._labels(axes, places, center, half)
        axes.set_xlim(center[0] - half, center[0] + half)
        axes.set_ylim(center[1] - half, center[1] + half)
        axes.set_aspect("equal")
        axes.grid(visible=True, axis="both")
        axes.locator_params(nbins=4)
        axes.set_xlabel(f"map [{component.unit}], {100 * kept:.0f} % of the variance")

    def _labels(self, axes: Any, places: Any, center: Any, half: float) -> None:
        """Names beside their places, where they cover neither a place nor each other."""
        height = LABELS_APART * half
        taken = [(x - height, x + height, y - height, y + height) for x, y in places]
        for i in sorted(range(len(places)), key=lambda i: (places[i][0], places[i][1])):
            width = LETTER * half * len(self.titles[i])
            free = [
                box_at
                for box_at in label_boxes(places[i], width, height)
                if not any(overlap(box_at, other) for other in taken)
                and all(abs(x - center[0]) < half for x in box_at[:2])
                and all(abs(y - center[1]) < half for y in box_at[2:])
            ]
            left, right, low, high = free[0] if free else label_boxes(places[i], width, height)[0]
            taken.append((left, right, low, high))
            middle = ((left + right) / 2, (low + high) / 2)
            end = (min(max(places[i][0], left), right), middle[1])
            axes.plot(*zip(places[i], end), color=DIM, linewidth=0.8, zorder=2)
            axes.text(*middle, self.titles[i], ha="center", va="center", fontsize=10, color=INK)


def label_boxes(place: Any, width: float, height: float) -> List[Box]:
    """Boxes for a label of a place, the nearest first: above, below, right and left of it."""
    boxes = []
    for away in range(2, 14):
        for side in (0.0, 1.0, -1.0):
            for up in (1.0, -1.0):
                x = place[0] + side * (width / 2 + 1.5 * height)
                y = place[1] + up * (away if side == 0.0 else away - 2) * 1.2 * height
                boxes.append((x - width / 2, x + width / 2, y - height, y + height))
    return boxes


def overlap(a: Box, b: Box) -> bool:
    return a[0] < b[1] and b[0] < a[1] and a[2] < b[3] and b[2] < a[3]


def read_agreement(path: Path) -> List[AgreementFigure]:
    """The agreement of a file, by its kinds of replay."""
    content = read_json(path)
    require_format(path, content, format_of("agreement"))
    try:
        figures = [AgreementFigure(content, replay) for replay in content["replays"]]
        for figure in figures:
            figure.drawing("check")
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        raise Error(f"{path}: is not as this version writes it: {error!r}") from None
    return figures


def names_of(figures: Sequence[AgreementFigure]) -> List[str]:
    """Names of their pictures: "agreement-5", "agreement-open"."""
    return [f"agreement-{figure.replay['reset_every'] or 'open'}" for figure in figures]


def of_replay(figures: Sequence[AgreementFigure], reset_every: Optional[int]) -> AgreementFigure:
    """That of one kind of replay: by its resets [control steps], or the usual one."""
    if reset_every is None:
        return next(figure for figure in figures if figure.is_usual)
    replays = {figure.replay["reset_every"] or OPEN_LOOP: figure for figure in figures}
    if reset_every not in replays:
        known = ", ".join(map(str, replays))
        raise Error(f"reset_every {reset_every}: must be one of {known} ({OPEN_LOOP}: open loop)")
    return replays[reset_every]
