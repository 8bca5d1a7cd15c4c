#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Makes the shipped policies that look back, remember, answer with chunks or draw noise: one
training of each recipe in docs/study/policies.yaml, with its evaluation. With --table all its
trainings, and how each does in each simulator by the number of actions that are executed.

Every step keeps what is finished, so a run that was interrupted goes on where it was when it is
started again, and ends with the same bytes.
"""

import json
import shutil
import sys
from pathlib import Path
from typing import Any, Dict, Iterator

from pusht_policy.checkpoint import provenance_path
from pusht_task.command import OneLineParser, run_command
from pusht_task.files import write_file
from pusht_task.json_file import read_json, write_json

from sim2sim_study.findings import group_rows
from sim2sim_study.plan import ROOT, STUDY, Plan, keep_plan, policies, read_plan
from sim2sim_study.steps import demonstrate, is_whole, ros, sweep, train
from sim2sim_study.tables import write_table

PLAN = STUDY / "policies.yaml"
SHIPPED = ROOT / "src" / "pusht_policy" / "policies"


def ship(plan: Plan, work: Path, shipped: Path) -> None:
    """The first training of each group that is shipped, with its success rate in MuJoCo."""
    one_each = {name: {**group, "seeds": 1} for name, group in plan["groups"].items()}
    wanted = {name: one_each[name] for name in plan["shipped"]}
    train({**plan, "groups": wanted}, work)
    for name in wanted:
        first = work / f"{name}-{plan['first_seed']}.ts.pt"
        copy = work / "shipped" / f"{name}.ts.pt"
        copy.parent.mkdir(exist_ok=True)
        shutil.copyfile(first, copy)
        provenance = read_json(provenance_path(first))
        provenance["checkpoint"]["file"] = copy.name
        write_json(provenance_path(copy), provenance)
        evaluation = work / "shipped" / name
        if not is_whole(evaluation):
            options = ["--require-policy", "--episodes", plan["evaluation"], "--overwrite"]
            ros(work, "sim2sim_eval", "compare", "--policy", copy, *options, "--out", evaluation)
        ros(work, "sim2sim_eval", "record_evaluation", copy, evaluation)
        for file in (provenance_path(copy), copy):
            write_file(shipped / file.name, file.read_bytes())


def numbers_executed(plan: Plan) -> Dict[int, Plan]:
    """The plan by the number of executed actions: each with the groups that have so many."""
    numbers = sorted({number for group in plan["groups"].values() for number in group["execute"]})
    return {
        number: {
            **plan,
            "groups": {n: g for n, g in plan["groups"].items() if number in g["execute"]},
        }
        for number in numbers
    }


def table(plan: Plan, work: Path, tables: Path) -> None:
    """Trains every policy, runs it in every simulator, and writes policies.csv."""
    train(plan, work)
    rows = []
    for number, part in numbers_executed(plan).items():
        folder = f"execute-{number}"
        wanted = {key: plan[key] for key in ("episodes", "first_episode")}
        options = {"engine": plan["engines"], "floor": False, "execute": number}
        sweep(work, folder, {"policies": list(policies(part)), **options, **wanted})
        ros(work, "sim2sim_eval", "matrix", folder, "--overwrite")
        rows += list(rows_of(number, work / folder))
    write_table(tables / "policies.csv", rows)


def rows_of(number: int, folder: Path) -> Iterator[Dict[str, Any]]:
    """Groups of policies in each simulator, from a sweep with so many executed actions."""
    for row in group_rows(json.loads((folder / "matrix.json").read_text())):
        yield {"group": row.pop("group"), "executed": number, **row}


def smallest(plan: Plan) -> Plan:
    """The least of everything: it tests this program, and says nothing."""
    for what in plan["demonstrations"].values():
        what["episodes"] = 3
    for recipe in plan["recipes"].values():
        recipe.update(hidden=[8, 8], epochs=2)
    for group in plan["groups"].values():
        group["seeds"] = 2
    return {**plan, "episodes": 2, "evaluation": 2}


def make(plan: Plan, options: Any) -> None:
    work: Path = options.work.resolve()
    for folder in (work, options.shipped, options.tables):
        folder.mkdir(parents=True, exist_ok=True)
    keep_plan(plan, work)
    demonstrate(plan, work)
    if options.table:
        table(plan, work, options.tables.resolve())
    else:
        ship(plan, work, options.shipped.resolve())


def main() -> int:
    parser = OneLineParser(prog="policies", description=(__doc__ or "").split(".")[0])
    help_table = "all trainings and their success in every simulator, in place of one of each"
    parser.add_argument("--table", action="store_true", help=help_table)
    folders = {
        "work": (ROOT / "build" / "policies", "bags, policies and sweeps, kept for the next start"),
        "shipped": (SHIPPED, "where the policies come that are shipped"),
        "tables": (PLAN.parent, "where the table comes"),
    }
    for name, (folder, text) in folders.items():
        help_folder = f"{text} (default: {folder.relative_to(ROOT)})"
        parser.add_argument(f"--{name}", metavar="DIR", type=Path, default=folder, help=help_folder)
    help_smoke = "run the least of everything: it tests this program, and says nothing"
    parser.add_argument("--smoke", action="store_true", help=help_smoke)
    options = parser.parse_args()
    if options.smoke and any(getattr(options, name) == at for name, (at, _) in folders.items()):
        parser.error(
            "--smoke says nothing: give it folders of its own by --work, --shipped and --tables"
        )
    plan = read_plan(PLAN)
    if options.smoke:
        plan = smallest(plan)
    return run_command(
        "policies", lambda: make(plan, options), "run the same command again to go on"
    )


if __name__ == "__main__":
    sys.exit(main())
