# SPDX-License-Identifier: BSD-3-Clause
"""Tables and pictures of the study under noise, from what was run here or where the tables that
are there already come from."""

from functools import partial
from pathlib import Path
from typing import Any, Dict, List, Sequence

import numpy as np
from pusht_task.command import say
from pusht_task.files import read_file, write_file

from sim2sim_study.crossed import Numbers
from sim2sim_study.curves import draw_noise, write_curves
from sim2sim_study.divergences import read_divergences, write_divergences
from sim2sim_study.endings import Endings, gather, write_endings
from sim2sim_study.groups import curve_rows, group_rows, rounded
from sim2sim_study.hypotheses import judge, write_hypotheses
from sim2sim_study.parts import Part, name_of_loop, pushing
from sim2sim_study.plan import Plan
from sim2sim_study.predictions import prediction_rows, read_numbers
from sim2sim_study.push_hypotheses import judge as judge_pushes
from sim2sim_study.push_hypotheses import read_sums, sums_of
from sim2sim_study.steps import is_whole
from sim2sim_study.tables import Row, nested, write_figures, write_table

PUSHES = ("pushes.csv", "pushes.csv.xz")  # means; sums by start, which are written last
DIVERGED = "divergences.csv"  # what the runs of the part print
WINDOW = 5  # control steps of the pushes that the hypotheses are about
PRIMARY = "tracker"  # the loop that they are about


def write_tables(parts: Sequence[Part], plan: Plan, work: Path, tables: Path) -> None:
    """Writes endings.csv.xz, groups.csv, curves.csv and .png, hypotheses.csv, the tables of pushes
    and figures.json, which has what docs/claims.yaml reads. Says which parts are missing."""
    table = gather(parts, plan, work, tables / "endings.csv.xz")
    write_endings(tables / "endings.csv.xz", plan, table)
    endings = Endings(table)
    groups, curves = list(group_rows(endings)), list(curve_rows(endings))
    if groups:
        write_table(tables / "groups.csv", groups)
    if curves:
        write_table(tables / "curves.csv", curves)
        draw = partial(draw_noise, curves)
        write_curves(tables / "curves.png", "Transfer over noise on the positions", draw)
    ran = {cell.sweep for cell in table}
    sweeps = [part.folder(loop) for part in parts for loop in part.plan["loops"]]
    missing = [name for name in sweeps if name not in ran]
    figures: Row = {
        "missing": missing,
        "groups": nested(groups, "part", "loop", "group", "simulator"),
        "curves": nested(curves, "group", "noise_mm", "simulator"),
        "hypotheses": {},
    }
    has_intervals = "smoke" not in plan  # which has too few policies for them
    if has_intervals:
        found = judge(endings)
        write_hypotheses(tables / "hypotheses.csv", found)
        figures["hypotheses"].update(_by_number(found))
    (pushes,) = (part for part in parts if part.name == "pushes")
    ran_pushes = not any(name.startswith(f"{pushes.name}-") for name in missing)
    if ran_pushes and _has_pushes(pushes, work, tables):
        figures.update(_write_predictions(pushes, plan, endings, tables))
        if has_intervals:
            found_of_pushes = judge_pushes(_recipes(pushes, plan, endings, tables))
            rows = [one._asdict() for one in found_of_pushes]
            write_table(tables / "hypotheses_pushes.csv", rows)
            figures["hypotheses"].update(_by_number(found_of_pushes))
    write_figures(tables / "figures.json", figures)


def _by_number(found: Sequence[Any]) -> Row:
    """Hypotheses with what was found, by their numbers."""
    rows = []
    for one in found:
        number, _, says = one.name.partition(" ")
        values = {key: value for key, value in one._asdict().items() if key != "name"}
        verdict = values.pop("verdict")
        figures = {key: rounded(value) for key, value in values.items()}
        rows.append({"number": number, "says": says, **figures, "verdict": verdict})
    return nested(rows, "number")


def _has_pushes(pushes: Part, work: Path, tables: Path) -> bool:
    """Brings the tables of pushes and divergences up to date from the work folder; whether all are
    there."""
    if (work / PUSHES[-1]).exists():
        for name in PUSHES:
            write_file(tables / name, read_file(work / name))
    if all(is_whole(work / pushes.folder(loop)) for loop in pushes.plan["loops"]):
        write_divergences(tables / DIVERGED, pushes, work)
    needed = (*PUSHES, DIVERGED)
    has_all = all((tables / name).exists() for name in needed)
    if not has_all:
        say(f"{', '.join(needed)}: not all there; --part pushes makes them")
    return has_all


def _drawn(pushes: Part) -> List[str]:
    """The population of engines, without those that a pilot had."""
    return [engine for engine in pushes.plan["engines"] if engine not in pushes.plan["seen"]]


def _by_recipe(plan: Plan) -> Dict[str, List[str]]:
    """The policies whose pushes are in tests."""
    found: Dict[str, List[str]] = {}
    for group, name in pushing(plan):
        found.setdefault(group, []).append(name)
    return found


def _lost(pushes: Part, endings: Endings, loop: str, group: str, policies: List[str]) -> Numbers:
    """[policy, engine, start]: success in MuJoCo less that in the engine."""

    def won(simulator: str) -> Numbers:
        return (endings.letters("pushes", loop, group, simulator, policies) == "S").astype(float)

    home = won("mujoco")
    return np.stack([home - won(engine) for engine in _drawn(pushes)], axis=1)


def _recipes(pushes: Part, plan: Plan, endings: Endings, tables: Path) -> List[Any]:
    sums = read_sums(tables / PUSHES[1])
    return [
        sums_of(sums, _lost(pushes, endings, PRIMARY, group, names), names, _drawn(pushes))
        for group, names in _by_recipe(plan).items()
    ]


def _write_predictions(pushes: Part, plan: Plan, endings: Endings, tables: Path) -> Row:
    """Writes predictions.csv; returns its leading figures: each number's, and the best ones."""
    rows: List[Row] = []
    for group, names in _by_recipe(plan).items():
        of_pushes = read_numbers(tables / PUSHES[0], names, _drawn(pushes))
        for loop in map(name_of_loop, pushes.plan["loops"]):
            printed = read_divergences(tables / DIVERGED, loop, names, _drawn(pushes))
            numbers = {**of_pushes, **printed}
            lost = _lost(pushes, endings, loop, group, names).mean(axis=(0, 2))
            found = prediction_rows(numbers, lost)
            rows += [{"recipe": group, "loop": loop, **row} for row in found]
    write_table(tables / "predictions.csv", rows)
    best = {(row["recipe"], row["loop"], row["size"]): row for row in reversed(rows)}
    return {
        "numbers": nested(
            [row for row in rows if row["size"] == "number"], "recipe", "loop", "numbers"
        ),
        "predictions": nested(list(best.values()), "recipe", "loop", "size"),
    }
