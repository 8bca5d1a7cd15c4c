# SPDX-License-Identifier: BSD-3-Clause
"""Sentences and tables on an agreement of simulators."""

from typing import Optional, Sequence

from pusht_task.json_file import Json

from sim2sim_report.agreement import (
    THOUSAND,
    AgreementFigure,
    Component,
    of_replay,
    text_of,
)
from sim2sim_report.figures import Drawing
from sim2sim_report.words import FEWEST_PAIRS


def headline(figures: Sequence[AgreementFigure]) -> str:
    """The nearest pair in position, and which simulator is at the edge."""
    usual = of_replay(figures, None)
    position, titles = usual.components[0], usual.titles
    pairs = [(j, i) for i in range(len(titles)) for j in range(i)]
    first, second = min(pairs, key=lambda pair: position.distances[pair])
    near = f"{text_of(position.distances[first, second])} {position.unit}"
    if usual.content["reference"]:  # the mean of there and back has no interval
        near += _ends(position.content["distances"][first][second])
    if len(titles) == 2:
        return f"{titles[first]} and {titles[second]} are {near} apart in position."
    others = [each["value"] for each in position.content["others"]]
    far = others.index(max(others))
    edge = position.content["least_central"]
    share = f" in {100 * edge[far]:.0f} % of resamples" if edge else ""
    nearest = f"In position, {titles[first]} and {titles[second]} are nearest, {near}"
    return f"{nearest}; {titles[far]} is farthest from the others{share}."


def section(figures: Sequence[AgreementFigure], drawings: Sequence[Drawing]) -> Json:
    """The sentences, figures and tables of the page."""
    content = figures[0].content
    run, reference = content["run"], content["reference"]
    along = f"{reference['title']}'s actions" if reference else "the actions of each in turn"
    usual = of_replay(figures, None)
    return {
        "sentences": [
            f"Each simulator replays {along}, of the policy {run['policy']}, over {run['episodes']}"
            " episodes. A distance is the mean divergence of two replays, over steps, then over"
            f" episodes. Above: {usual.how[0].lower()}{usual.how[1:]}.",
        ],
        "few": run["episodes"] < FEWEST_PAIRS,
        "confidence": f"{100 * content['confidence']:g} %",
        "replays": [
            {
                "title": figure.how,
                "drawing": drawing,
                "tables": [_table(figure, component) for component in figure.components],
            }
            for figure, drawing in zip(figures, drawings)
        ],
        "caution": [
            "The most central simulator, and the one at the edge, are those of this list: two of a"
            " family make each other central.",
        ],
    }


def _table(figure: AgreementFigure, component: Component) -> Json:
    content = component.content
    variants = [
        max(found, key=lambda v: v["value"]) if found else None for found in content["variants"]
    ]
    rows = [
        {
            "name": title,
            "cells": ["" if i == j else _cell(cell) for j, cell in enumerate(row)],
        }
        for i, (title, row) in enumerate(zip(figure.titles, content["distances"]))
    ]
    rows.append({"name": "to all others", "cells": [_cell(found) for found in content["others"]]})
    rows.append({"name": "to own variant", "cells": [_cell(found) for found in variants]})
    for key, name in (("most_central", "most central"), ("least_central", "at the edge")):
        if content[key] is not None:
            cells = [f"{100 * share:.0f} %" for share in content[key]]
            rows.append({"name": f"{name}, of resamples", "cells": cells})
    title = f"{component.name} [{component.unit}]"
    return {"title": title, "columns": figure.titles, "rows": rows}


def _cell(found: Optional[Json]) -> str:
    if found is None:
        return "none"  # the word of the commands
    return text_of(THOUSAND * found["value"]) + _ends(found)


def _ends(found: Json) -> str:
    if not found["interval"]:
        return ""
    low, high = (text_of(THOUSAND * end) for end in found["interval"])
    return f" [{low}, {high}]".replace(" ", "\u00a0")
