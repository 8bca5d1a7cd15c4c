# SPDX-License-Identifier: BSD-3-Clause
"""Runs the study under noise: the policies of the first study and further ones, in loops with and
without noise, in every simulator. docs/study/noise/plan.md says why.

Every step keeps what is finished, so a study that was interrupted goes on where it was when it is
started again, and ends with the same bytes. Its parts may be run one by one, on several machines.
"""

import argparse
import shutil
from pathlib import Path
from typing import Sequence

from sim2sim_study.command import StudyParser
from sim2sim_study.noise_tables import PUSHES, WINDOW, write_tables
from sim2sim_study.parts import NAMES, Part, parts_of, whole_plan, with_trainings
from sim2sim_study.plan import ROOT, STUDY, Plan, keep_plan, with_groups
from sim2sim_study.pushes import measure, write_pushes, write_sums
from sim2sim_study.steps import demonstrate, sweep, train

SHIPPED = ROOT / "src" / "pusht_policy" / "policies"


def run_parts(parts: Sequence[Part], plan: Plan, work: Path) -> None:
    """Runs parts of the study, with the trainings that they need."""
    needed = with_trainings(plan, parts)
    demonstrate(needed, work)
    train(needed, work)
    for name in {*plan["kinds"]["policies"]} - {"expert"}:
        shutil.copyfile(SHIPPED / f"{name}.ts.pt", work / f"{name}.ts.pt")
    for part in parts:
        sweep_part(part, plan, work)
        if part.name == "pushes" and not (work / PUSHES[-1]).exists():
            measure_pushes(part, plan, work)


def sweep_part(part: Part, plan: Plan, work: Path) -> None:
    for loop in part.plan["loops"]:
        wanted = {
            "policies": part.policies,
            "engine": part.plan["engines"],
            "loop": loop,
            "floor": False,
            "episodes": part.plan["episodes"],
            "first_episode": plan["first_episode"],
        }
        sweep(work, part.folder(loop), wanted)


def measure_pushes(part: Part, plan: Plan, work: Path) -> None:
    """Writes the tables of pushes into the work folder."""
    policies = [str(work / entry["files"]) for entry in part.policies]
    starts, first = part.plan["episodes"], 10_000 + plan["first_episode"]
    found = measure(policies, part.plan["engines"], part.plan, range(first, first + starts))
    write_pushes(work / PUSHES[0], found)
    write_sums(work / PUSHES[1], found[WINDOW], starts)


def smallest(plan: Plan) -> Plan:
    """The least study that has every part: it tests the program, and says nothing."""
    kept = ("small-mujoco", "shipped-mujoco", "small-draw_1", "epochs_60-width_256")
    plan = with_groups(plan, {name: {**plan["groups"][name], "seeds": 1} for name in kept})
    plan["first_groups"] = list(kept[:2])
    for what in plan["demonstrations"].values():
        what["episodes"] = 3
    for units, recipe in enumerate(plan["recipes"].values(), 4):  # no two alike
        recipe.update(hidden=[units, units], epochs=1)
    for group in plan["groups"].values():
        group.pop("also_after", None)
    for name in ("primary", "draws", "curves", "kinds"):
        part = plan[name]
        part.update(episodes=2, engines=part["engines"][:2], loops=part["loops"][-2:])
    plan["curves"]["policies"] = 1
    plan["pushes"].update(first=0, policies=1, kinds=[], episodes=2, switches=1)
    plan["pushes"].update(engines=["two_mass"], seen=["chipmunk"])
    plan["kinds"]["policies"] = ["expert"]
    plan["smoke"] = True
    return plan


def study(options: argparse.Namespace) -> None:
    plan = smallest(whole_plan()) if options.smoke else whole_plan()
    for folder in (options.work, options.tables):
        folder.mkdir(parents=True, exist_ok=True)
    keep_plan(plan, options.work)
    parts = parts_of(plan)
    if not options.tables_only:
        wanted = options.part or NAMES
        run_parts([part for part in parts if part.name in wanted], plan, options.work)
    write_tables(parts, plan, options.work, options.tables)


def main(arguments: Sequence[str]) -> int:
    parser = StudyParser("study noise", __doc__ or "", STUDY / "noise")
    run = parser.add_mutually_exclusive_group()
    help_part = (
        "run this part alone, with the trainings that it needs; may be repeated (default: all). "
        "The tables keep the parts that they have already"
    )
    run.add_argument("--part", action="append", choices=NAMES, help=help_part)
    help_only = "run nothing; write the tables of what is finished"
    run.add_argument("--tables-only", action="store_true", help=help_only)
    return parser.run(arguments, study)
