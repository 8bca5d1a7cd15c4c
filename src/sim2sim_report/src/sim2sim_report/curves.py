# SPDX-License-Identifier: BSD-3-Clause
"""The figure of a sweep: success and divergence over each parameter with more than one value."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence

from pusht_task.error import Error
from sim2sim_protocol.result_files import name_of

from sim2sim_report.colors import CARD, DIM, INK, SERIES
from sim2sim_report.figures import (
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
from sim2sim_report.suite import Suite
from sim2sim_report.sweep_rows import (
    AGAINST,
    ENGINE,
    PANELS,
    SUCCESS,
    TRANSFER,
    Panel,
    Row,
    Words,
    contrasted,
    engines_of,
    label_of,
    lines_over,
    panels_of,
    read_rows,
    title_of_role,
    unit_of,
    varied_parameters,
    with_engine_as_parameter,
    with_places,
    without_followers,
)

MOST_LINES = len(SERIES)  # more in one panel cannot be told apart
LOGARITHMIC_FROM = 10.0  # largest over smallest value of a parameter
CHARACTER = 0.1  # [in] that one takes in a tick's label
NO_END = 1e9  # stands for an interval's end that is not there: its line leaves the panel
LONGEST_BESIDE = 26  # characters of labels that stand beside each other in a legend
DODGE = 0.01  # share of the axis between lines at one value, whose bars must not hide each other
DODGE_OF_WORDS = 0.04
COLUMN_WIDTH, HEIGHT = 7.2, 10.8  # [in]
WIDE = (15.0, 5.8)  # [in] of a figure with one parameter: its panels stand side by side
NARROW = (5.2, 4.1)  # [in] of a panel, for a phone: all below each other
DOTTED = "dotted: a tee that never moves"
HOLLOW = "; hollow: not shown to be nearer than it"


class ParameterAxis:
    """The x axis of a parameter, logarithmic if its values span much."""

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
        end = -math.inf  # end of the last label that stays
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
    y = [math.nan if row[panel.value] is None else row[panel.value] for row in rows]
    style = {"color": color, "marker": MARKERS[number], **style}
    axes.plot(x, y, **style, zorder=3, clip_on=False)  # a rate of 0 is a whole point, too
    for at, row in zip(x, rows):
        if panel.beats_null and row[panel.beats_null] is not True:
            hollow = {"markerfacecolor": CARD, "linestyle": "none"}
            axes.plot(
                [at], [row[panel.value]], color=color, marker=MARKERS[number], **hollow, zorder=4
            )
        if row[panel.interval] is not None:  # one episode has no interval
            low, high = row[panel.interval]
            high = NO_END if high is None else high
            draw_interval(axes, [low, high], at, upright=True, color=color, zorder=2)


def draw_many(axes: Any, panel: Panel, parameter: str, lines: Sequence[Sequence[Row]]) -> None:
    """Thin lines without intervals, and their mean."""
    values: Dict[float, List[float]] = {}
    for number, rows in enumerate(lines):
        x = [row["knobs"][parameter] for row in rows]
        y = [math.nan if row[panel.value] is None else row[panel.value] for row in rows]
        for at, value in zip(x, y):
            values.setdefault(at, []).append(value)
        name = f"{len(lines)} settings of the other parameters" if number == 0 else None
        axes.plot(x, y, color=DIM, alpha=0.5, linewidth=1.0, label=name)
    x = sorted(values)
    means = [sum(values[at]) / len(values[at]) for at in x]
    axes.plot(x, means, color=SERIES[0], marker="o", label="their mean", zorder=3, clip_on=False)


def draw_reference(axes: Any, row: Row) -> None:
    """The reference does not depend on the engine's parameters: one line and one band."""
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
    parameter: str,
    parameters: Sequence[str],
    rows: List[Row],
    words: Words,
    narrow: bool,
) -> None:
    """The panels of one parameter, with the rows of the engines that have it."""
    rows = [row for row in rows if parameter in row["knobs"]]
    axis = ParameterAxis([row["knobs"][parameter] for row in rows])
    lines = lines_over(parameter, parameters, rows)
    inches = width_of(column[0])
    character = CHARACTER / inches
    for axes, panel in zip(column, panels_of(rows)):
        if AGAINST in rows[0]:
            axes.axhline(0.0, color=INK, linestyle="--", linewidth=1.0)
        elif panel is TRANSFER:
            axes.axhline(1.0, color=INK, linestyle="--", linewidth=1.0, label="as the reference")
        elif panel is SUCCESS:
            draw_reference(axes, rows[0])
        else:
            draw_null_model(axes, panel, rows)
        if len(lines) > MOST_LINES:
            draw_many(axes, panel, parameter, list(lines.values()))
            continue
        for number, (setting, line) in enumerate(lines.items()):
            dodge = DODGE_OF_WORDS if parameter in words else DODGE
            shift = dodge * (number - (len(lines) - 1) / 2)
            x = [axis.shifted(row["knobs"][parameter], shift) for row in line]
            label = label_of(setting, rows, words) or title_of_role(rows[0], "engine")
            style = {"label": "engine" if parameter == ENGINE else label}
            if parameter in words:  # nothing lies between two words
                style["linestyle"] = "none"
            draw_line(axes, panel, x, line, number, **style)
    for axes in column:
        axes.set_xscale("log" if axis.logarithmic else "linear")
        axes.set_xticks(axis.values, words.get(parameter) or axis.labels(character))
        axes.set_xticks([], minor=True)
        axes.margins(x=0.5 if parameter in words else 0.06)
        if axes.get_subplotspec().is_last_row() or narrow:
            unit = unit_of(parameter, rows)
            axes.set_xlabel(f"{parameter} [{unit}]" if unit else parameter)
    handles = labeled(column)
    beside = 1 if narrow or max(map(len, handles)) > LONGEST_BESIDE else 2
    size = OWN_STYLE["legend.fontsize"]  # labels that stand beside each other are short
    labels = list(handles) if beside > 1 else legend_labels(handles, inches, size)
    column[0].legend(
        handles.values(), labels, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncol=beside
    )


def title_of(rows: Sequence[Row], whole: int) -> List[str]:
    row = rows[0]
    engines = list(dict.fromkeys(title_of_role(row, "engine") for row in rows))
    starts = "given starts" if "starts" in row else f"seed {row['seed']}"
    lines = [
        f"policy {row['policy']}: {title_of_role(row, 'reference')} to {', '.join(engines)}",
        f"{row['episodes']:,} episodes a point, {starts}",
    ]
    if any(row[panel.interval] is not None for row in rows for panel in PANELS):
        lines[-1] += f", {100 * row['confidence']:g} % intervals"
    if AGAINST in row:
        lines[-1] += f", what differs from row {row[AGAINST]}"
    else:
        divergences = [panel.beats_null for panel in PANELS if panel.beats_null]
        hollow = any(row[key] is not True for row in rows for key in divergences)
        lines.append(DOTTED + (HOLLOW if hollow else ""))
    return [*lines, what_is_missing(len(rows), whole)]


def what_is_missing(rows: int, whole: int) -> str:
    """The warning for a sweep that is not whole; else empty."""
    return f"NOT A WHOLE SWEEP: {rows} of {whole} rows have finished" if rows < whole else ""


@dataclass(frozen=True)
class Curves:
    """The curves of a sweep, ready to be drawn."""

    rows: List[Row]  # words are replaced by their places
    whole: int  # rows of the whole sweep
    parameters: List[str]
    words: Words

    @property
    def missing(self) -> str:
        return what_is_missing(len(self.rows), self.whole)

    def drawing(self, name: str) -> Drawing:
        what = "Success" if panels_of(self.rows)[0] is SUCCESS else "Transfer"
        what = "Paired differences" if AGAINST in self.rows[0] else f"{what} and divergence"
        alt = f"{what} over {', '.join(self.parameters)}"
        return Drawing(name, alt, self._figure, OWN_STYLE)

    def _top(self, panel: Panel) -> Optional[float]:
        """The upper end of a panel's axis; None: where its lines end."""
        if panel is not TRANSFER:
            return 1.0 if panel is SUCCESS else None
        ends = [end for row in self.rows for end in row[panel.interval] or [] if end is not None]
        known = [row[panel.value] for row in self.rows if row[panel.value] is not None]
        return 1.05 * max([1.0, *ends, *known])

    def _figure(self, narrow: bool) -> Any:
        count = len(self.parameters)
        if count == 1:
            figure, axes = panels(narrow, (1, len(PANELS)), WIDE, NARROW)
            axes = axes.T
        else:
            size = (COLUMN_WIDTH * count, HEIGHT)
            shared = {"sharex": "none" if narrow else "col", "sharey": "row"}
            shape = (len(PANELS), count)
            figure, axes = panels(narrow, shape, size, NARROW, by_column=True, **shared)
        for number, parameter in enumerate(self.parameters):
            draw_column(axes[:, number], parameter, self.parameters, self.rows, self.words, narrow)
        against = AGAINST in self.rows[0]
        for panel, row in zip(panels_of(self.rows), axes):
            for number, one in enumerate(row):
                if number == 0 or narrow:
                    label = f"change of\n{panel.label}" if against else panel.label
                    one.set_ylabel(label, linespacing=1.5)
                if not against:
                    one.set_ylim(0, self._top(panel))
        if not narrow:
            figure.align_ylabels()
        entitle(figure, title_of(self.rows, self.whole), 14)
        layout = figure.get_layout_engine()
        layout.set(w_pad=0.1, h_pad=0.1, wspace=0.05)  # [in], but wspace
        return figure


def read_curves(folder: Path, suite: Suite, against: Optional[int] = None) -> Curves:
    """The curves of a sweep. Raises Error for one in which nothing varies, or nothing so far."""
    rows, whole = read_rows(folder)
    if against is not None:
        rows = contrasted(folder, rows, against, suite)
    parameters = without_followers(varied_parameters(rows), rows)
    if not parameters and len(engines_of(rows)) > 1:
        rows, parameters = with_engine_as_parameter(rows), [ENGINE]
    if not parameters and len(rows) < whole:
        raise Error(f"{folder}: is unfinished: {len(rows)} of {whole} rows; finish it with `sweep`")
    if not parameters:
        raise Error(f"{folder / name_of('sweep')}: no parameter takes two values; one must")
    rows, words = with_places(rows, parameters)
    return Curves(rows, whole, parameters, words)


def draw(folder: Path, suite: Suite) -> List[Drawing]:
    """The curves of a sweep, and what differs from its first row."""
    return [
        read_curves(folder, suite, against).drawing(name)
        for name, against in (("curves", None), ("pairs", 0))
    ]
