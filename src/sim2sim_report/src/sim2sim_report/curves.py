# SPDX-License-Identifier: BSD-3-Clause
"""The figure of a sweep: success and divergence over every knob that takes more than one value."""

import json
import math
import textwrap
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Set, Tuple

from pusht_task.command import Refusal

from sim2sim_report.colors import CARD, DIM, INK, SERIES
from sim2sim_report.figures import STYLE, Drawing, Figure, styled
from sim2sim_report.results import REPLAY, read_sweep
from sim2sim_report.suite import Suite

Row = Dict[str, Any]  # the metrics.json of one knob setting
Setting = Tuple[str, Tuple[Tuple[str, Any], ...]]  # engine; knobs and their values
Words = Dict[str, List[str]]  # of the knobs that take words, or true and false: these, by place

AGAINST = "against"  # in a row: the number of the row that it is held against
ENGINE = "engine"  # in place of a knob, where the kinds of engine alone vary
MARKERS = ["o", "s", "^", "D", "v", "P"]
MOST_LINES = len(SERIES)  # more in one panel cannot be told apart
LOGARITHMIC_FROM = 10.0  # largest over smallest value of a knob
CHARACTER = 0.1  # [in] that one takes in a tick's label
TITLE_CHARACTER = 0.135  # [in] that one takes in the title
LONGEST_BESIDE = 26  # characters of labels that stand beside each other in a legend
DODGE = 0.01  # of the axis, between lines at one value: their bars must not hide each other
DODGE_OF_WORDS = 0.04
COLUMN_WIDTH, HEIGHT = 7.2, 10.8  # [in]
WIDE = (15.0, 5.8)  # [in] of a figure with one knob: its panels stand side by side
NARROW = (5.2, 4.1)  # [in] of a panel, for a phone: all below each other
OWN_STYLE: Dict[str, Any] = {
    **STYLE,
    "font.size": 14,
    "axes.labelsize": 15,
    "axes.grid.axis": "y",
    "legend.fontsize": 13,
    "lines.linewidth": 2.2,
    "lines.markersize": 8,
}


class Panel(NamedTuple):
    """What one row of panels shows."""

    label: str
    value: str  # keys of the metrics
    interval: str
    beats_null: str = ""
    null: str = ""


SUCCESS = Panel("success rate", "engine_success_rate", "engine_success_interval")
PANELS = [
    SUCCESS,
    Panel(
        "position divergence [m]",
        "mean_pos_divergence_m",
        "mean_pos_divergence_interval_m",
        "mean_pos_divergence_beats_null",
        f"{REPLAY}_null_position_divergence_m",
    ),
    Panel(
        "angle divergence [rad]",
        "mean_ang_divergence_rad",
        "mean_ang_divergence_interval_rad",
        "mean_ang_divergence_beats_null",
        f"{REPLAY}_null_angle_divergence_rad",
    ),
]
DOTTED = "dotted: a tee that never moves"
HOLLOW = "; hollow: not shown to be nearer than it"
OTHER_KEYS = [
    "confidence",
    "engine_simulator",
    "episodes",
    "knobs",
    "policy",
    "reference_success_interval",
    "reference_success_rate",
    "seed",
    "simulators",
]


def read_rows(folder: Path) -> Tuple[List[Row], int]:
    """The rows of a sweep.json, checked, and how many a whole sweep has."""
    path = folder / "sweep.json"
    content = read_sweep(folder)
    rows: List[Row] = content["rows"]
    needed = OTHER_KEYS + [key for panel in PANELS for key in panel[1:] if key]
    for number, row in enumerate(rows):
        missing = [key for key in needed if not isinstance(row, dict) or key not in row]
        if missing:
            raise Refusal(f"{path}: row {number}: no key {missing[0]}; it is needed")
        first = next(r for r in rows if r["engine_simulator"] == row["engine_simulator"])
        if row["knobs"].keys() != first["knobs"].keys():
            raise Refusal(f"{path}: row {number}: must have the knobs of the rows of its engine")
    try:
        return rows, len(content["sweep"]["rows"])
    except (KeyError, TypeError):
        raise Refusal(f"{path}: no list of rows under sweep; it is needed") from None


def contrasted(folder: Path, rows: Sequence[Row], against: int, suite: Suite) -> List[Row]:
    """The rows with what differs from row `against`, pair by pair, in place of their figures."""
    contrasts = suite.contrast([folder], against)["contrasts"]
    same = {"difference": 0.0, "interval": None}
    figures = [contrast["figures"] for contrast in contrasts]
    figures.insert(against, {panel.value: same for panel in PANELS})
    changed = []
    for row, figure in zip(rows, figures):
        row = {**row, AGAINST: against}
        for panel in PANELS:
            row[panel.value] = figure[panel.value]["difference"]
            row[panel.interval] = figure[panel.value]["interval"]
            if panel.beats_null:
                row[panel.beats_null] = True  # a difference has no null model
        changed.append(row)
    return changed


def engines_of(rows: Sequence[Row]) -> List[str]:
    """The kinds of engines, in the order of the file."""
    return list(dict.fromkeys(row["engine_simulator"] for row in rows))


def varied_knobs(rows: Sequence[Row]) -> List[str]:
    """The knobs that take more than one value with one engine, in the order of the file."""
    values: Dict[Tuple[str, str], Set[Any]] = {}
    for row in rows:
        for knob, value in row["knobs"].items():
            values.setdefault((row["engine_simulator"], knob), set()).add(value)
    return list(dict.fromkeys(knob for (_, knob), taken in values.items() if len(taken) > 1))


def follows(knob: str, leader: str, rows: Sequence[Row]) -> bool:
    """Whether `leader` takes words, and each of them sets `knob`, as a preset does."""
    led = [row["knobs"] for row in rows if leader in row["knobs"]]
    pairs = {(taken[leader], taken.get(knob)) for taken in led}
    words = {word for word, _ in pairs}
    return len(words) == len(pairs) and all(isinstance(word, str) for word in words)


def without_followers(knobs: Sequence[str], rows: Sequence[Row]) -> List[str]:
    """The knobs but for those that follow another one."""

    def takes_words(knob: str) -> bool:
        return any(isinstance(row["knobs"].get(knob), str) for row in rows)

    leaders: List[str] = []
    for knob in sorted(knobs, key=takes_words, reverse=True):
        if not any(follows(knob, leader, rows) for leader in leaders):
            leaders.append(knob)
    return [knob for knob in knobs if knob in leaders]


def with_engine_as_knob(rows: Sequence[Row]) -> List[Row]:
    """The engine is what varies."""
    return [{**row, "knobs": {ENGINE: title_of_role(row, "engine")}} for row in rows]


def with_places(rows: Sequence[Row], knobs: Sequence[str]) -> Tuple[List[Row], Words]:
    """The rows with places in place of words, in the order in which the words come."""
    taken = {
        knob: list(dict.fromkeys(row["knobs"][knob] for row in rows if knob in row["knobs"]))
        for knob in knobs
    }
    words = {
        knob: [value if isinstance(value, str) else json.dumps(value) for value in values]
        for knob, values in taken.items()
        if any(isinstance(value, (str, bool)) for value in values)
    }
    placed = []
    for row in rows:
        knobs_there = words.keys() & row["knobs"]
        places = {knob: taken[knob].index(row["knobs"][knob]) for knob in knobs_there}
        placed.append({**row, "knobs": {**row["knobs"], **places}})
    return placed, words


def lines_over(knob: str, knobs: Sequence[str], rows: Sequence[Row]) -> Dict[Setting, List[Row]]:
    """A line for each engine and setting of the other varied knobs, by growing value of `knob`."""
    several = len(engines_of(rows)) > 1 and knob != ENGINE
    lines: Dict[Setting, List[Row]] = {}
    for row in sorted(rows, key=lambda row: row["knobs"][knob]):
        taken = row["knobs"]
        others = tuple((other, taken[other]) for other in knobs if other != knob and other in taken)
        lines.setdefault((title_of_role(row, "engine") if several else "", others), []).append(row)
    return dict(sorted(lines.items()))


def title_of_role(row: Row, role: str) -> str:
    """What people call the simulator."""
    title: str = row["simulators"][role]["title"]
    return title


def unit_of(knob: str, rows: Sequence[Row]) -> str:
    units = (row["simulators"]["engine"]["units"].get(knob) for row in rows)
    return next(filter(None, units), "")


def label_of(setting: Setting, rows: Sequence[Row], words: Words) -> str:
    engine, knobs = setting
    values = [
        f"{knob} {words[knob][value] if knob in words else format(value, 'g')} "
        f"{unit_of(knob, rows)}".strip()
        for knob, value in knobs
    ]
    return ", ".join(filter(None, [engine, *values]))


class KnobAxis:
    """Where the values of a knob lie on the x axis, logarithmic if they span much."""

    def __init__(self, values: Sequence[float]) -> None:
        self.values = sorted(set(values))
        first, last = self.values[0], self.values[-1]
        self.logarithmic = first > 0 and last / first > LOGARITHMIC_FROM
        self.span = self._scaled(last) - self._scaled(first)

    def shifted(self, value: float, shift: float) -> float:
        """`value` moved to the right by a share of the axis."""
        way = shift * self.span
        return value * math.exp(way) if self.logarithmic else value + way

    def labels(self, character: float) -> List[str]:
        """Labels of the values; one that would touch the label before it is empty.

        `character`: the width of a character, as a share of the axis.
        """
        labels: List[str] = []
        end = -math.inf  # of the last label that stays
        for value in self.values:
            text = f"{value:g}"
            middle = (self._scaled(value) - self._scaled(self.values[0])) / self.span
            half = character * (len(text) + 1) / 2
            labels.append(text if middle - half > end else "")
            end = middle + half if labels[-1] else end
        return labels

    def _scaled(self, value: float) -> float:
        return math.log(value) if self.logarithmic else value


def draw_line(
    axes: Any, panel: Panel, x: Sequence[float], rows: Sequence[Row], number: int, **style: str
) -> None:
    """Points with their intervals, in the style of line `number`."""
    color = SERIES[number]
    y = [row[panel.value] for row in rows]
    style = {"color": color, "marker": MARKERS[number], **style}
    axes.plot(x, y, **style, zorder=3, clip_on=False)  # a rate of 0 is a whole point, too
    for at, row in zip(x, rows):
        if panel.beats_null and row[panel.beats_null] is not True:
            hollow = {"markerfacecolor": CARD, "linestyle": "none"}
            axes.plot(
                [at], [row[panel.value]], color=color, marker=MARKERS[number], **hollow, zorder=4
            )
        if row[panel.interval] is not None:  # of one episode there is none
            axes.plot([at, at], row[panel.interval], color=color, zorder=2)


def draw_many(axes: Any, panel: Panel, knob: str, lines: Sequence[Sequence[Row]]) -> None:
    """Thin lines without intervals, and their mean."""
    values: Dict[float, List[float]] = {}
    for number, rows in enumerate(lines):
        x = [row["knobs"][knob] for row in rows]
        y = [row[panel.value] for row in rows]
        for at, value in zip(x, y):
            values.setdefault(at, []).append(value)
        name = f"{len(lines)} settings of the other knobs" if number == 0 else None
        axes.plot(x, y, color=DIM, alpha=0.5, linewidth=1.0, label=name)
    x = sorted(values)
    means = [sum(values[at]) / len(values[at]) for at in x]
    axes.plot(x, means, color=SERIES[0], marker="o", label="their mean", zorder=3, clip_on=False)


def draw_reference(axes: Any, row: Row) -> None:
    """The reference does not depend on the engine's knobs: one line and one band."""
    if row["reference_success_interval"] is not None:
        low, high = row["reference_success_interval"]
        axes.axhspan(low, high, color=INK, alpha=0.12, linewidth=0)
    name = f"{title_of_role(row, 'reference')} (reference)"
    style = {"color": INK, "linestyle": "--", "label": name}
    axes.axhline(row["reference_success_rate"], **style)


def draw_null_model(axes: Any, panel: Panel, rows: Sequence[Row]) -> None:
    """The divergence of a tee that never moves: one line, since it hangs on the reference alone."""
    values = [row[panel.null] for row in rows if row.get(panel.null) is not None]
    if values:
        axes.axhline(max(values), color=DIM, linestyle=":", linewidth=1.8)


def draw_column(
    column: Sequence[Any],
    knob: str,
    knobs: Sequence[str],
    rows: List[Row],
    words: Words,
    narrow: bool,
) -> None:
    """The panels of one knob, with the rows of the engines that have it."""
    rows = [row for row in rows if knob in row["knobs"]]
    knob_axis = KnobAxis([row["knobs"][knob] for row in rows])
    lines = lines_over(knob, knobs, rows)
    inches = column[0].figure.get_figwidth() / column[0].get_subplotspec().get_gridspec().ncols
    character = CHARACTER / inches
    for axes, panel in zip(column, PANELS):
        if AGAINST in rows[0]:
            axes.axhline(0.0, color=INK, linestyle="--", linewidth=1.0)
        elif panel is SUCCESS:
            draw_reference(axes, rows[0])
        else:
            draw_null_model(axes, panel, rows)
        if len(lines) > MOST_LINES:
            draw_many(axes, panel, knob, list(lines.values()))
            continue
        for number, (setting, line) in enumerate(lines.items()):
            shift = (DODGE_OF_WORDS if knob in words else DODGE) * (number - (len(lines) - 1) / 2)
            x = [knob_axis.shifted(row["knobs"][knob], shift) for row in line]
            label = label_of(setting, rows, words) or title_of_role(rows[0], "engine")
            style = {"label": "engine" if knob == ENGINE else label}
            if knob in words:  # nothing lies between two words
                style["linestyle"] = "none"
            draw_line(axes, panel, x, line, number, **style)
    for axes in column:
        axes.set_xscale("log" if knob_axis.logarithmic else "linear")
        axes.set_xticks(knob_axis.values, words.get(knob) or knob_axis.labels(character))
        axes.set_xticks([], minor=True)
        axes.margins(x=0.5 if knob in words else 0.06)
        if axes.get_subplotspec().is_last_row() or narrow:
            unit = unit_of(knob, rows)
            axes.set_xlabel(f"{knob} [{unit}]" if unit else knob)
    handles = {label: h for axes in column for h, label in zip(*axes.get_legend_handles_labels())}
    beside = 1 if narrow or max(map(len, handles)) > LONGEST_BESIDE else 2
    column[0].legend(
        handles.values(), handles, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncol=beside
    )


def title_of(rows: Sequence[Row], whole: int) -> str:
    row = rows[0]
    engines = list(dict.fromkeys(title_of_role(row, "engine") for row in rows))
    starts = "given starts" if "starts" in row else f"seed {row['seed']}"
    panels = [panel for panel in PANELS if panel.beats_null]
    lines = [
        f"policy {row['policy']}: {title_of_role(row, 'reference')} to {', '.join(engines)}",
        f"{row['episodes']:,} episodes a point, {starts}",
    ]
    if any(row[panel.interval] is not None for row in rows for panel in PANELS):
        lines[-1] += f", {100 * row['confidence']:g} % intervals"
    if AGAINST in row:
        lines[-1] += f", what differs from row {row[AGAINST]}"
    hollow = any(row[panel.beats_null] is not True for row in rows for panel in panels)
    if AGAINST not in row:
        lines.append(DOTTED + (HOLLOW if hollow else ""))
    if len(rows) < whole:
        lines.append(what_is_missing(len(rows), whole))
    return "\n".join(lines)


def what_is_missing(rows: int, whole: int) -> str:
    return f"NOT A WHOLE SWEEP: {rows} of {whole} rows have finished"


@dataclass(frozen=True)
class Curves:
    """What is drawn of a sweep."""

    rows: List[Row]  # with places in place of words
    whole: int  # rows of the whole sweep
    knobs: List[str]
    words: Words

    @property
    def missing(self) -> str:
        """What to say of a sweep that is not whole."""
        return what_is_missing(len(self.rows), self.whole) if len(self.rows) < self.whole else ""

    def drawing(self, name: str) -> Drawing:
        alt = (
            f"{'Paired differences' if AGAINST in self.rows[0] else 'Success and divergence'} over "
        )
        return styled(name, alt + ", ".join(self.knobs), self._figure, OWN_STYLE)

    def _figure(self, narrow: bool) -> Any:
        count = len(self.knobs)
        style = {"squeeze": False}
        if narrow:
            size = (NARROW[0], NARROW[1] * count * len(PANELS))
            figure = Figure(figsize=size, constrained_layout=True)
            axes = figure.subplots(count * len(PANELS), 1, **style).reshape(count, -1).T
        elif count == 1:
            figure = Figure(figsize=WIDE, constrained_layout=True)
            axes = figure.subplots(1, len(PANELS), **style).T
        else:
            figure = Figure(figsize=(COLUMN_WIDTH * count, HEIGHT), constrained_layout=True)
            axes = figure.subplots(len(PANELS), count, sharex="col", sharey="row", **style)
        for number, knob in enumerate(self.knobs):
            draw_column(axes[:, number], knob, self.knobs, self.rows, self.words, narrow)
        against = AGAINST in self.rows[0]
        for panel, row in zip(PANELS, axes):
            for number, one in enumerate(row):
                if number == 0 or narrow:
                    label = f"change of\n{panel.label}" if against else panel.label
                    one.set_ylabel(label, linespacing=1.5)
                if not against:
                    one.set_ylim(0, 1 if panel is SUCCESS else None)
        if not narrow:
            figure.align_ylabels()
        title = title_of(self.rows, self.whole)
        width = int(figure.get_figwidth() / TITLE_CHARACTER)
        lines = [part for line in title.splitlines() for part in textwrap.wrap(line, width)]
        figure.suptitle("\n".join(lines), fontsize=14)
        layout = figure.get_layout_engine()
        layout.set(w_pad=0.1, h_pad=0.1, wspace=0.05)  # [in], but wspace
        return figure


def read_curves(folder: Path, suite: Suite, against: Optional[int] = None) -> Curves:
    """What a sweep has to draw. Refuses one in which nothing varies, and one that is unfinished so
    far that nothing does."""
    rows, whole = read_rows(folder)
    if against is not None:
        rows = contrasted(folder, rows, against, suite)
    knobs = without_followers(varied_knobs(rows), rows)
    if not knobs and len(engines_of(rows)) > 1:
        rows, knobs = with_engine_as_knob(rows), [ENGINE]
    if not knobs and len(rows) < whole:
        raise Refusal(
            f"{folder}: is unfinished: {len(rows)} of {whole} rows; finish it with `sweep`"
        )
    if not knobs:
        raise Refusal(f"{folder / 'sweep.json'}: no knob takes more than one value; one must")
    rows, words = with_places(rows, knobs)
    return Curves(rows, whole, knobs, words)


def draw(folder: Path, suite: Suite) -> List[Drawing]:
    """The curves of a sweep, and what differs from its first row."""
    return [
        read_curves(folder, suite, against).drawing(name)
        for name, against in (("curves", None), ("pairs", 0))
    ]
