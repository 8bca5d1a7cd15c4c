# SPDX-License-Identifier: BSD-3-Clause
"""Sentences and tables on the cause of a gap."""

from typing import List, Optional

from pusht_task.json_file import Json

from sim2sim_report.attribution import Attribution, draw
from sim2sim_report.words import DIVERGENCE_DIGITS, FEWEST_PAIRS, interval, signed


def cause(attribution: Attribution) -> str:
    """The switches that close most of the gap in position, in open loop."""
    gap = attribution.gaps("position")[0]
    if gap["all_off"] <= gap["all_on"]:
        return "The switches are not shown to close the gap in position"
    most = [name for name, part in attribution.ranked(gap)[:3] if part > 0]
    found = [gap["switches"][name] for name in most]
    parts = [_part(one["part"], one["part_interval"]).replace(" ", "\u00a0") for one in found]
    named = ", ".join(f"{name} {part}" for name, part in zip(most, parts))
    return f"What closes the gap in position: {named}"


def section(attribution: Attribution) -> Json:
    """The sentences, figures and tables of the page."""
    content = attribution.content
    position = attribution.gaps("position")[0]
    angle = attribution.gaps("angle")[0]
    success = attribution.success
    return {
        "headline": cause(attribution),
        "sentences": [
            f"{content['engine']} against {content['reference']}, policy {content['policy']}, "
            f"{content['episodes']} episodes, {_combinations(attribution)}.",
            f"In open loop the tees are {position['all_off']:.4f} m and {angle['all_off']:.4f} rad "
            f"apart with all switches off, and {position['all_on']:.4f} m and "
            f"{angle['all_on']:.4f} rad with all on. In closed loop the engine's success rate is "
            f"{_below(success['all_off'])} that of {content['reference']} with all off, and "
            f"{_below(success['all_on'])} it with all on.",
        ],
        "drawings": draw(attribution),
        "exact": attribution.is_exact,
        "few": content["episodes"] < FEWEST_PAIRS,
        "gaps": [_gap_table(attribution, content["gaps"][name]) for name in content["order"]],
        "pairs": [
            {
                "title": gap["title"],
                "rows": [
                    {
                        "names": " and ".join(pair["switches"]),
                        "value": f"{signed(pair['value'], DIVERGENCE_DIGITS)} {gap['unit']}"
                        f"{interval(pair['interval'], DIVERGENCE_DIGITS)}",
                    }
                    for pair in sorted(gap["interactions"], key=lambda p: -abs(p["value"]))[:5]
                ],
            }
            for gap in (position, angle)
            if gap["interactions"]
        ],
        "caution": [
            "A share depends on the horizon, and on what a switch means while others are off "
            "(docs/ladder.md).",
            "Closed loops are chaotic: simulators that agree in all but the last bit may differ in "
            "success.",
        ],
    }


def _combinations(attribution: Attribution) -> str:
    content = attribution.content
    count = len(attribution.switches)
    switches = f"{count} switch{'' if count == 1 else 'es'}"
    if attribution.is_exact:
        return f"every one of {content['combinations']} combinations of {switches}"
    orders = f"along {content['orders']} random orders of switching on"
    return f"{content['combinations']} combinations of {switches}, {orders}"


def _gap_table(attribution: Attribution, gap: Json) -> Json:
    rows = [
        _baseline_row("tee that never moves", gap["null_model"]),
        _baseline_row(f"baseline: {attribution.content['baseline']}", gap["baseline"]),
        {"name": "all off", "cells": [f"{gap['all_off']:.{DIVERGENCE_DIGITS}f}"]},
    ]
    for name in attribution.switches:
        found = gap["switches"][name]
        closes = signed(found["share"], DIVERGENCE_DIGITS)
        cells = [
            closes + interval(found["share_interval"], DIVERGENCE_DIGITS),
            _part(found["part"], found["part_interval"]),
        ]
        if attribution.is_exact:
            for effect in ("alone", "leave_one_out"):
                value = signed(found[effect]["value"], DIVERGENCE_DIGITS)
                cells.append(value + interval(found[effect]["interval"], DIVERGENCE_DIGITS))
        rows.append({"name": name, "cells": cells})
    rows.append({"name": "all on", "cells": [f"{gap['all_on']:.{DIVERGENCE_DIGITS}f}"]})
    rows.append(_baseline_row(f"floor of {attribution.content['reference']}", gap["floor"]))
    return {"title": gap["title"], "unit": gap["unit"], "rows": [row for row in rows if row]}


def _baseline_row(name: str, found: Json) -> Optional[Json]:
    if found["value"] is None:
        return None
    value = f"{found['value']:.{DIVERGENCE_DIGITS}f}"
    return {"name": name, "cells": [value + interval(found["interval"], DIVERGENCE_DIGITS)]}


def _below(lost: float) -> str:
    return f"{abs(lost):.3f} {'below' if lost >= 0 else 'above'}"


def _part(part: Optional[float], ends: Optional[List[float]]) -> str:
    if part is None:
        return ""
    text = f"{100 * part:.0f} %"
    return f"{text} [{100 * ends[0]:.0f}, {100 * ends[1]:.0f}]" if ends else text
