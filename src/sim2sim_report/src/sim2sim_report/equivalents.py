# SPDX-License-Identifier: BSD-3-Clause
"""The figure of equivalents: success in the reference over the size of an error, a panel for each
parameter, with the success in each engine as a level."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List

from pusht_task.error import Error
from pusht_task.json_file import Json, read_json, require_format
from sim2sim_protocol.result_files import format_of, name_of

from sim2sim_report.colors import COLORS, SERIES
from sim2sim_report.figures import OWN_STYLE, Drawing, add_legend, entitle, panels
from sim2sim_report.words import RATE_DIGITS, in_sentence, interval

FILE = name_of("equivalent")
DRAWING = "equivalents"  # name of the figure
PANEL = (5.2, 4.2)  # [in]
ENGINE_COLORS = SERIES[1:]  # the first is like the reference's


@dataclass(frozen=True)
class Equivalents:
    """Content of equivalent.json, ready to be drawn."""

    content: Json
    missing = ""  # only whole sweeps have the file

    @property
    def engines(self) -> List[Json]:
        engines: List[Json] = self.content["engines"]
        return engines

    def drawing(self, name: str) -> Drawing:
        names = ", ".join(each["parameter"] for each in self.engines[0]["equivalents"])
        alt = f"Success in {self.content['reference']} over {names}, with levels of engines"
        return Drawing(name, alt, self._figure, OWN_STYLE)

    def _figure(self, narrow: bool) -> Any:
        count = len(self.engines[0]["equivalents"])
        across = 1 if narrow else min(count, 2)
        down = math.ceil(count / across)
        size = (PANEL[0] * across, PANEL[1] * down)
        figure, grid = panels(narrow, (down, across), size, PANEL, sharey=True)
        for axes in grid.flat[count:]:
            axes.remove()
        for number, axes in enumerate(grid.flat[:count]):
            self._panel(axes, number)
        add_legend(figure, "lower", across)
        entitle(figure, self._title(), 10 if across == 1 else 13)
        return figure

    def _panel(self, axes: Any, number: int) -> None:
        curve = self.engines[0]["equivalents"][number]
        levels = sorted(curve["levels"], key=lambda level: level["size"])
        sizes = [level["size"] for level in levels]
        rates = [level["success"]["rate"] for level in levels]
        ends = [level["success"]["interval"] for level in levels]
        color = COLORS["reference"]
        axes.plot(sizes, rates, color=color, marker="o", label=self.content["reference"])
        axes.fill_between(sizes, *zip(*ends), color=color, alpha=0.2, linewidth=0)
        for place, engine in enumerate(self.engines):
            self._level(axes, engine, number, ENGINE_COLORS[place % len(ENGINE_COLORS)])
        unit = f" [{curve['unit']}]" if curve["unit"] else ""
        axes.set_xlabel(f"{curve['parameter']}{unit}")
        axes.set_ylabel("success")
        axes.set_ylim(0.0, 1.0)

    @staticmethod
    def _level(axes: Any, engine: Json, number: int, color: str) -> None:
        """An engine's success, and the interval of the error that costs as much."""
        curve = engine["equivalents"][number]
        rate = engine["success"]["rate"]
        axes.axhline(rate, color=color, linewidth=1.4, linestyle="--", label=engine["engine"])
        if curve["error_interval"] is None:  # it gains success, or a size of the error does
            return
        direction = -1.0 if curve["levels"][-1]["size"] < curve["without"] else 1.0
        largest = abs(curve["levels"][-1]["size"] - curve["without"])
        low, high = (largest if end is None else end for end in curve["error_interval"])
        ends = [curve["without"] + direction * end for end in (low, high)]
        beyond = curve["error_interval"][1] is None
        mark: Dict[str, Any] = {"marker": ">" if direction > 0 else "<", "markevery": [1]}
        axes.plot(ends, [rate, rate], color=color, linewidth=6, alpha=0.6, **mark if beyond else {})
        if curve["error"] is not None:
            at = curve["without"] + direction * curve["error"]
            axes.plot([at], [rate], color=color, marker="D", markersize=8)

    def _title(self) -> List[str]:
        return [
            f"errors of {self.content['reference']} that cost as much success as an engine"
            f" (policy {self.content['policy']})",
            f"{self.content['episodes']:,} episodes, {100 * self.content['confidence']:g} %"
            " intervals; thick: sizes that are not excluded",
        ]


def has_equivalents(folder: Path) -> bool:
    return (folder / FILE).exists()


def section(equivalents: Equivalents) -> Json:
    """The sentences, the figure and the table of the page."""
    content = equivalents.content
    sentence = "; ".join(map(_answer, equivalents.engines)) + "."
    return {
        "reference": content["reference"],
        "headline": sentence[0].upper() + sentence[1:],
        "sentences": [
            f"Policy {content['policy']}, {content['episodes']} episodes. In brackets "
            f"{100 * content['confidence']:g} % intervals over further starts.",
        ],
        "drawing": equivalents.drawing(DRAWING),
        "rows": [
            {
                "engine": engine["engine"],
                "success": f"{engine['success']['rate']:.{RATE_DIGITS}f}"
                f"{interval(engine['success']['interval'], RATE_DIGITS)}",
                "parameter": curve["parameter"],
                "error": _error_text(curve),
            }
            for engine in equivalents.engines
            for curve in engine["equivalents"]
        ],
    }


def _answer(engine: Json) -> str:
    """ "as much as Chipmunk costs loop.action_delay + 2 [1, 3] control steps": the first error."""
    name = in_sentence(engine["engine"])
    if engine["lost_interval"][1] < 0.0:
        return f"{name} gains success"
    if engine["lost_interval"][0] <= 0.0:
        return f"that {name} costs success is not shown"
    curve = next((c for c in engine["equivalents"] if c["error"] is not None), None)
    if curve is None:
        return f"no error that was tried costs as much as {name}"
    return f"as much as {name} costs {curve['parameter']} {_error_text(curve)}"


def _error_text(curve: Json) -> str:
    """ "+ 3.2 [2.8, > 4] control steps": an open end is beyond the largest that was tried."""
    last = curve["levels"][-1]["size"]
    if curve["rises_at"] is not None:
        sign = "-" if last < curve["without"] else "+"
        return f"none: success rises at {sign} {curve['rises_at']:.3g} {curve['unit']}".rstrip()
    if curve["error_interval"] is None:
        return "none: it gains success"
    largest = f"> {abs(last - curve['without']):.3g}"
    value, low, high = (
        largest if size is None else f"{size:.3g}"
        for size in (curve["error"], *curve["error_interval"])
    )
    sign = "-" if last < curve["without"] else "+"
    return f"{sign} {value} [{low}, {high}] {curve['unit']}".rstrip()


def read_equivalents(folder: Path) -> Equivalents:
    """The equivalents in the folder of a sweep. Raises Error if there are none."""
    path = folder / FILE
    if not path.exists():
        raise Error(f"{path}: is not there; `equivalent {folder}` writes it")
    content = read_json(path)
    require_format(path, content, format_of("equivalent"))
    equivalents = Equivalents(content)
    try:
        equivalents.drawing("check").wide, section(equivalents)
    except (AttributeError, LookupError, TypeError, ValueError) as error:
        raise Error(f"{path}: is not as this version writes it: {error!r}") from None
    return equivalents
