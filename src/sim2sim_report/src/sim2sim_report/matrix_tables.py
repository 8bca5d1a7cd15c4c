# SPDX-License-Identifier: BSD-3-Clause
"""Sentences and tables on the matrix of a sweep over policies."""

from pathlib import Path
from typing import List, Optional

from pusht_task.json_file import Json

from sim2sim_report.matrix import Matrix, draw
from sim2sim_report.words import interval, signed

DIGITS = 2  # of rates, as the command prints them
DIFFERENCE_DIGITS = 4


def headline(matrix: Matrix) -> str:
    """What two groups keep of their success where groups differ most; both have intervals."""
    kept = []
    for column, title in enumerate(matrix.titles):
        found = [
            (group["cells"][column]["transfer"]["value"], group["group"], group["cells"][column])
            for group in matrix.content["groups"]
            if group["cells"][column] and group["cells"][column]["transfer"]["interval"]
        ]
        if len(found) > 1:
            least, most = (choose(found, key=lambda f: f[:2]) for choose in (min, max))
            kept.append((most[0] - least[0], title, least, most))
    if not kept:
        return f"{len(matrix.policies)} policies in {len(matrix.titles)} simulators."
    _, title, least, most = max(kept, key=lambda k: k[:2])
    least_text, most_text = (_transfer(v, c["transfer"]["interval"]) for v, _, c in (least, most))
    return f"In {title}, {least[1]} keeps {least_text} of its success, {most[1]} {most_text}."


def section(matrix: Matrix, folder: Path) -> Json:
    """The figures and tables of the page."""
    content = matrix.content
    return {
        "drawings": {"spread": None, "rankings": None, **{d.name: d for d in draw(matrix)}},
        "episodes": content["episodes"],
        "titles": matrix.titles,
        "groups": [_group_row(matrix, group) for group in content["groups"]],
        "rankings": [_ranking_row(matrix, ranking) for ranking in matrix.rankings],
        "here": matrix.titles[matrix.here],
        "hypotheses": [_hypothesis_row(found) for found in content["hypotheses"]],
        "policies": [_policy_row(policy) for policy in matrix.policies],
        "episodes_of": {
            "folder": str(folder),
            "first": content["first_episode"],
            "titles": matrix.titles,
            "policies": [
                {
                    "name": policy["policy"],
                    "reference": policy["reference"],
                    "rows": [cell and cell["row"] for cell in policy["cells"]],
                    "won": [cell and cell["success_by_episode"] for cell in policy["cells"]],
                }
                for policy in matrix.policies
            ],
        },
        "caution": [
            "Intervals of a policy are over further starts; those of a group over further "
            "trainings and starts. They say nothing of another recipe or another task.",
        ],
    }


def _rate(value: float, ends: Optional[List[float]]) -> str:
    return f"{value:.{DIGITS}f}{_unbroken(interval(ends, DIGITS))}"


def _unbroken(ends: str) -> str:
    """An interval that stays on one line: " [0.21, 0.34]"."""
    return ends and " " + ends.strip().replace(" ", "\u00a0")


def _transfer(value: Optional[float], ends: Optional[List[float]]) -> str:
    if value is None:
        return ""
    text = f"{100 * value:.0f}\u00a0%"
    return f"{text} [{100 * ends[0]:.0f},\u00a0{100 * ends[1]:.0f}]" if ends else text


def _group_row(matrix: Matrix, group: Json) -> Json:
    return {
        "name": group["group"],
        "count": len(group["policies"]),
        "cells": [
            cell
            and {
                "rate": _rate(cell["success_rate"]["value"], cell["success_rate"]["interval"]),
                "transfer": _transfer(cell["transfer"]["value"], cell["transfer"]["interval"]),
                "deviation": cell["between_policies"],
            }
            for cell in group["cells"]
        ],
    }


def _policy_row(policy: Json) -> Json:
    return {
        "name": policy["policy"],
        "group": policy["group"],
        "cells": [
            cell
            and {
                "value": cell["success_rate"],
                "rate": _rate(cell["success_rate"], cell["success_interval"]),
                "transfer": _transfer(cell["transfer"], cell["transfer_interval"]),
                "is_reference": column == policy["reference"],
            }
            for column, cell in enumerate(policy["cells"])
        ],
    }


def _estimate(found: Json) -> str:
    return "none" if found["value"] is None else _rate(found["value"], found["interval"])


def _ranking_row(matrix: Matrix, ranking: Json) -> Json:
    return {
        "there": matrix.titles[ranking["test"]],
        "policies": ranking["policy_count"],
        "verdict": ranking["verdict"],
        "figures": [
            _estimate(ranking[key])
            for key in ("kendall", "spearman", "pearson", "mean_maximum_rank_violation")
        ],
        "agreement": [_estimate(found) for found in ranking["agreement"]],
    }


def _hypothesis_row(found: Json) -> Json:
    if "ranking" in found:
        what = (
            f"Kendall's tau of {found['here']} and {found['there']}, {len(found['ranking'])} groups"
        )
    else:
        name = found["figure"].replace("_", " ")
        what = f"{name} in {found['simulator']}: {found['more']} less {found['less']}"
    value = signed(found["value"], DIFFERENCE_DIGITS) if found["value"] is not None else "none"
    expected = {"above": "above 0", "below": "below 0", "within": f"within {found['margin']:g}"}
    p = found["adjusted_p"]
    return {
        "name": found["name"],
        "what": what,
        "expected": expected[found["side"]],
        "value": value + _unbroken(interval(found["interval"], DIFFERENCE_DIGITS)),
        "p": "" if p is None else "< 0.0001" if p < 0.0001 else f"{p:.2g}",
        "verdict": found["verdict"],
    }
