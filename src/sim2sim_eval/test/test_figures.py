#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Titles and legends of figures stay within them, however long the names of simulators are."""

import tempfile
import unittest
from pathlib import Path
from typing import Any, Iterator, List, cast
from unittest import mock

from pusht_task.error import Error
from pusht_task.json_file import Json, write_json
from sim2sim_protocol.result_files import format_of
from sim2sim_report.attribution import Attribution
from sim2sim_report.convergence import Convergence, Line, Point
from sim2sim_report.costs import Costs
from sim2sim_report.equivalents import FILE, Equivalents, read_equivalents, section
from sim2sim_report.figures import (
    Drawing,
    Figure,
    FigureCanvasAgg,
    entitle_axes,
    matplotlib,
    wrapped,
)
from sim2sim_report.results import REPLAY
from sim2sim_report.suite import Suite
from sim2sim_report.sweep_rows import PANELS, contrasted

LONG = "rigid-body engine, preset faithful, substep 0.0025, table_friction false, loop.hold 2"


def equivalents(parameters: int, engines: int = 3) -> Json:
    """What `equivalent` writes: an error costs an engine's success at 2.5, or beyond all sizes."""
    rates = (0.9, 0.7, 0.5, 0.3)
    levels = [
        {"size": size, "success": {"rate": rate, "interval": [rate - 0.1, rate + 0.05]}}
        for size, rate in enumerate(rates)
    ]
    curve: Json = {"unit": "control steps", "without": 0, "levels": levels}
    found = [
        {
            "parameter": "loop.action_delay",
            **curve,
            "rises_at": None,
            "error": 2.5,
            "error_interval": [1.5, None],
        },
        {
            "parameter": "loop.hold",
            **curve,
            "rises_at": None,
            "error": None,
            "error_interval": [None, None],
        },
    ]
    engine: Json = {
        "success": {"rate": 0.4, "interval": [0.3, 0.5]},
        "lost": 0.5,
        "lost_interval": [0.4, 0.6],
        "equivalents": found[:parameters],
    }
    return {
        "format": format_of("equivalent"),
        "confidence": 0.95,
        "reference": f"MuJoCo, {LONG}",
        "policy": "trained_elsewhere_with_another_seed.ts.pt",
        "episodes": 400,
        "engines": [{"engine": f"{LONG} {number}", **engine} for number in range(engines)],
    }


def attribution() -> Attribution:
    """What `attribute` writes on two switches, as far as the figure of costs takes it."""
    switch = {
        "part": 0.5,
        "share": 0.004,
        "share_interval": [0.003, 0.005],
        "leave_one_out": {"value": 0.006, "interval": [0.005, 0.007]},
    }
    gap: Json = {
        "all_off": 0.008,
        "all_on": 0.0,
        "null_model": {"value": 0.014, "interval": [0.012, 0.016]},
        "switches": {"servo": switch, "table_friction": switch},
    }
    gaps = {
        f"{component} {replay}": {"title": f"{component}, {replay}", "unit": unit, **gap}
        for replay in ("open loop", "re-anchored every 5 steps")
        for component, unit in (("position", "m"), ("angle", "rad"))
    }
    content = {"engine": LONG, "switches": ["servo", "table_friction"], "gaps": gaps}
    return Attribution({**content, "order": list(gaps)})


def words_of(figure: Any) -> Iterator[Any]:
    """What a figure says beside its axes, and in their legends."""
    yield from figure.legends
    yield from filter(None, (axes.get_legend() for axes in figure.axes))
    if figure._suptitle:
        yield figure._suptitle
    for axes in figure.axes:
        yield from (axes.title, axes.xaxis.label, axes.yaxis.label, *axes.texts)


def check_words(case: unittest.TestCase, drawing: Drawing) -> None:
    """They are within the figure, wide or narrow, and apart."""
    for figure in (drawing.wide, drawing.narrow):
        FigureCanvasAgg(figure).draw()
        boxes: List[Any] = []
        for words in words_of(figure):
            if not (hasattr(words, "get_text") and not words.get_text()):
                boxes.append(words.get_window_extent())
        case.assertGreater(len(boxes), 3)
        for number, box in enumerate(boxes):
            within = figure.bbox.contains(*box.min) and figure.bbox.contains(*box.max)
            case.assertTrue(within, (box, figure.bbox))
            for other in boxes[:number]:
                case.assertFalse(box.overlaps(other), (box, other))
        for axes in figure.axes:
            case.assertGreater(axes.bbox.height / figure.dpi, 0.7, "[in] of a panel")


class Words(unittest.TestCase):
    def test_equivalents(self) -> None:
        for parameters, engines in ((1, 1), (1, 5), (2, 3)):
            with self.subTest(parameters=parameters, engines=engines):
                check_words(
                    self, Equivalents(equivalents(parameters, engines)).drawing("equivalents")
                )

    def test_costs(self) -> None:
        for sweeps in (1, 3):
            with self.subTest(sweeps=sweeps):
                check_words(self, Costs([attribution()] * sweeps).drawing("costs"))

    def test_convergence(self) -> None:
        row: Json = {"policy": LONG, "seed": 0, "episodes": 300, "confidence": 0.95}
        for name in ("mean_pos_divergence", "mean_ang_divergence"):
            row.update({f"{name}_m": 0.01, f"{name}_rad": 0.1, f"{name}_median_m": 0.005})
        points = [Point(value, row, REPLAY) for value in (0.001, 0.01)]
        lines = [Line("substep", "s", f"{LONG} {number}", points) for number in range(2)]
        with mock.patch.object(Convergence, "_title", lambda _: [LONG]):
            drawing = Convergence([row], 1, lines).drawing("convergence")
            figures = (drawing.wide, drawing.narrow)
        for figure in figures:
            FigureCanvasAgg(figure).draw()
            legend = figure.axes[0].get_legend()
            self.assertTrue(all("\n" in text.get_text() for text in legend.get_texts()))
            box, room = legend.get_window_extent(), figure.axes[0].bbox
            self.assertTrue(room.x0 <= box.x0 and box.x1 <= room.x1, (box, room))

    def test_axes(self) -> None:
        with matplotlib.rc_context():
            figure = Figure(figsize=(8.0, 3.0), constrained_layout=True)
            axes = figure.subplots(1, 2)[0]
            entitle_axes(axes, LONG, 11)
            FigureCanvasAgg(figure).draw()
            box = axes.title.get_window_extent()
            self.assertTrue(figure.bbox.x0 <= box.x0 and box.x1 <= figure.bbox.x1 / 2, box)

    def test_a_word_that_is_too_long_breaks_behind_its_signs(self) -> None:
        self.assertEqual(wrapped("rigid_body:preset=shaped", 14), "rigid_body:\npreset=shaped")
        self.assertEqual(wrapped("two words here", 9), "two words\nhere")
        self.assertEqual(wrapped("abcdefgh", 5), "abcde\nfgh")

    def test_a_name_is_no_mathematics(self) -> None:
        content = equivalents(1)
        content["policy"] = content["engines"][0]["engine"] = "a$b$c_d"
        with matplotlib.rc_context():
            (legend,) = Equivalents(content).drawing("equivalents").wide.legends
        self.assertEqual(legend.get_texts()[1].get_text(), r"a\$b\$c_d")


class Differences(unittest.TestCase):
    def test_each_row_has_its_own_and_the_one_it_is_held_against_none(self) -> None:
        keys = [panel.value for panel in PANELS]

        class Contrasts:
            def contrast(self, folders: Any, against: int) -> Json:
                figures = [
                    {key: {"difference": row + 1.0, "interval": None} for key in keys}
                    for row in range(3)
                    if row != against
                ]
                return {"contrasts": [{"figures": one} for one in figures]}

        for against in range(3):
            rows = contrasted(Path("any"), [{}, {}, {}], against, cast(Suite, Contrasts()))
            wanted = [0.0 if row == against else row + 1.0 for row in range(3)]
            self.assertEqual([row[keys[0]] for row in rows], wanted)


class PageOfEquivalents(unittest.TestCase):
    def test_answer_and_table(self) -> None:
        content = equivalents(2, 2)
        content["engines"][0]["engine"] = "two-mass engine"
        content["engines"][1].update(engine="Chipmunk", lost_interval=[-0.1, 0.3])
        found = section(Equivalents(content))
        self.assertEqual(
            found["headline"],
            "As much as the two-mass engine costs loop.action_delay + 2.5 [1.5, > 3] control "
            "steps; that Chipmunk costs success is not shown.",
        )
        one, other = content["engines"]
        one["equivalents"].reverse()
        other["lost_interval"] = [-0.3, -0.1]
        self.assertEqual(
            section(Equivalents(content))["headline"],
            "As much as the two-mass engine costs loop.action_delay + 2.5 [1.5, > 3] control "
            "steps; Chipmunk gains success.",
        )
        one["equivalents"].pop()
        self.assertIn(
            "No error that was tried costs as much as the two-mass engine;",
            section(Equivalents(content))["headline"],
        )
        self.assertEqual(
            [row["error"] for row in found["rows"][:2]],
            ["+ 2.5 [1.5, > 3] control steps", "+ > 3 [> 3, > 3] control steps"],
        )

    def test_damaged(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            for damage in ([[1]], [1], "text", 5):
                content = equivalents(1)
                content["engines"][0]["equivalents"][0]["error_interval"] = damage
                write_json(Path(folder, FILE), content)
                with self.assertRaisesRegex(Error, f"{FILE}: is not as this version writes it"):
                    read_equivalents(Path(folder))


if __name__ == "__main__":
    unittest.main()
