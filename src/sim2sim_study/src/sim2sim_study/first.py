# SPDX-License-Identifier: BSD-3-Clause
"""Runs the study over policies: demonstrations, trainings, the sweep of every policy in every
simulator, its matrix, and the ladder and the conduct of some policies. docs/study/plan.md says why.

Every step keeps what is finished, so a study that was interrupted goes on where it was when it is
started again, and ends with the same bytes.
"""

import argparse
from pathlib import Path
from typing import List, Sequence, Tuple

from pusht_task.files import read_file, write_file

from sim2sim_study.command import StudyParser
from sim2sim_study.conduct import SLOWER, conduct_runs, write_slower
from sim2sim_study.findings import write_findings
from sim2sim_study.plan import (
    STUDY,
    Plan,
    first_entries,
    first_policies,
    keep_plan,
    policies,
    read_plan,
    with_groups,
)
from sim2sim_study.steps import demonstrate, is_whole, printed, ros, sweep, train


def sweep_policies(plan: Plan, work: Path) -> None:
    """Every policy in every simulator."""
    wanted = {key: plan[key] for key in ("episodes", "first_episode")}
    engines = {"engine": plan["engines"], "floor": False}
    sweep(work, "matrix", {"policies": list(policies(plan)), **engines, **wanted})


def sweep_variants(plan: Plan, work: Path) -> None:
    """The first policies of some groups in other discretizations of the reference's model."""
    variants = plan["variants"]
    wanted = {
        "policies": first_entries(plan, variants),
        "engine": variants["engines"],
        "floor": False,
        "episodes": variants["episodes"],
        "first_episode": plan["first_episode"],
    }
    sweep(work, "variants", wanted)


def ladder(plan: Plan, work: Path) -> None:
    """The cause of the gap for the first policies of some groups."""
    for _, name in first_policies(plan, plan["ladder"]):
        wanted = {
            "policy": f"{name}.ts.pt",
            "episodes": plan["ladder"]["episodes"],
            "first_episode": plan["first_episode"],
            "engine": "rigid_body",
            "floor": False,
            "grid": {switch: [False, True] for switch in plan["ladder"]["switches"]},
        }
        sweep(work, f"ladder-{name}", wanted)
        ros(work, "sim2sim_eval", "attribute", f"ladder-{name}", "--overwrite")


def conduct(plan: Plan, work: Path) -> None:
    """Traces of policies at home and in an engine; of some of them slowed down, too."""
    part = plan["conduct"]
    (work / "conduct").mkdir(exist_ok=True)
    wanted = ["--engine", part["engine"], "--no-floor", "--traces"]
    wanted += ["--episodes", part["episodes"], "--first-episode", plan["first_episode"]]
    for group, seed, name in conduct_runs(plan):
        if is_whole(work / "conduct" / name):
            continue
        policy = f"{name}.ts.pt"
        if group.startswith(SLOWER):
            policy = f"conduct/{name}.ts.pt"
            original = work / f"{part['slower']['group']}-{seed}.ts.pt"
            write_slower(original, work / policy, part["slower"]["factor"])
        out = ["--overwrite", "--out", f"conduct/{name}"]
        ros(work, "sim2sim_eval", "compare", "--policy", policy, *wanted, *out)


def matrices(plan: Plan, work: Path, tables: Path) -> None:
    """The matrix as text: of all groups, of those that differ in one thing, of those that are
    ranked, and of the variants. Its JSON stays in the work folder, for the findings."""
    hypotheses = ["--hypotheses", str(STUDY / "hypotheses.yaml")]
    questions: List[Tuple[str, str, List[str]]] = [
        *((name, "matrix", groups_of(groups)) for name, groups in plan["matrices"].items()),
        ("rankings", "matrix", groups_of(plan["rankings"])),
        ("matrix", "matrix", hypotheses),
        ("variants", "variants", []),
    ]
    for name, folder, options in questions:
        text = printed(work, "sim2sim_eval", "matrix", folder, *options, "--overwrite")
        write_file(tables / f"{name}.txt", text)
        write_file(work / f"{name}.json", read_file(work / folder / "matrix.json"))
    write_file(tables / "matrix.csv", read_file(work / "matrix" / "matrix.csv"))


def groups_of(names: List[str]) -> List[str]:
    """The options that ask for these groups."""
    return [word for name in names for word in ("--group", name)]


def smallest(plan: Plan) -> Plan:
    """The least study in which every hypothesis can be tested: it tests the program, and says
    nothing."""
    hypotheses = read_plan(STUDY / "hypotheses.yaml").values()
    named = {name for h in hypotheses for name in h.get("ranking", [h.get("more"), h.get("less")])}
    kept = {name: {**g, "seeds": 1} for name, g in plan["groups"].items() if name in named}
    plan = with_groups(plan, kept)
    for what in plan["demonstrations"].values():
        what["episodes"] = 3
    for recipe in plan["recipes"].values():
        recipe.update(hidden=[8, 8])
    plan["engines"] = plan["engines"][:3]
    plan["episodes"] = 2
    plan["matrices"] = {"recipes": ["small-mujoco", "shipped-mujoco"]}
    plan["variants"].update(policies=1, episodes=1, engines=plan["variants"]["engines"][:1])
    plan["ladder"].update(policies=1, episodes=1, switches=plan["ladder"]["switches"][:3])
    plan["conduct"].update(episodes=1, explored=0)
    return plan


def study(options: argparse.Namespace) -> None:
    plan = read_plan(STUDY / "study.yaml")
    if options.smoke:
        plan = smallest(plan)
    work, tables = options.work, options.tables
    for folder in (work, tables):
        folder.mkdir(parents=True, exist_ok=True)
    keep_plan(plan, work)
    for step in (demonstrate, train, sweep_policies, sweep_variants, ladder, conduct):
        step(plan, work)
    matrices(plan, work, tables)
    write_findings(plan, work, tables)


def main(arguments: Sequence[str]) -> int:
    return StudyParser("study", __doc__ or "", STUDY).run(arguments, study)
