# SPDX-License-Identifier: BSD-3-Clause
"""Runs the study under noise: the policies of the first study and further ones, in loops with and
without noise, in every simulator. docs/study/noise/plan.md says why.

Every step keeps what is finished, so a study that was interrupted goes on where it was when it is
started again, and ends with the same bytes.
"""

import argparse
import csv
import io
import lzma
import shutil
from pathlib import Path
from typing import Any, Dict, Iterator, List, NamedTuple, Sequence

import numpy as np
from pusht_task.error import Error
from pusht_task.files import write_file
from pusht_task.json_file import read_json
from sim2sim_protocol.result_files import row_folder
from sim2sim_report.results import read_rows

from sim2sim_study.command import StudyParser
from sim2sim_study.hypotheses import Endings, judge, write_hypotheses
from sim2sim_study.plan import (
    ROOT,
    Plan,
    first_entries,
    keep_plan,
    policies,
    read_plan,
    with_groups,
)
from sim2sim_study.plan import STUDY as FIRST_STUDY
from sim2sim_study.pushes import Found, measure, population, sums_of, write_pushes
from sim2sim_study.pushes import judge as judge_pushes
from sim2sim_study.steps import demonstrate, sweep, train
from sim2sim_study.tables import write_table

STUDY = FIRST_STUDY / "noise"
SHIPPED = ROOT / "src" / "pusht_policy" / "policies"
LETTERS = {"success": "S", "stuck": "t", "moving": "m", "lost": "l"}
REFERENCE, ENGINE = "reference_closed", "engine_closed"


class Part(NamedTuple):
    """Sweeps of the study: the same policies and engines in each of its loops."""

    name: str
    policies: List[Plan]  # entries of a plan's list: files, group, reference
    plan: Plan  # loops, engines, episodes

    def folder(self, loop: Any) -> str:
        return f"{self.name}-{name_of_loop(loop)}"


def name_of_loop(loop: Any) -> str:
    """The loop in names of files and tables: "tracker", "observation_noise_position=0.01"."""
    if isinstance(loop, str):
        return loop
    return ",".join(f"{name}={value}" for name, value in loop.items())


def whole_plan() -> Plan:
    """The plan of this study, with demonstrations, recipes and groups of the first one."""
    first = read_plan(FIRST_STUDY / "study.yaml")
    plan = read_plan(STUDY / "study.yaml")
    plan["first_groups"] = list(first["groups"])
    plan["first_seed"] = first["first_seed"]
    for key in ("demonstrations", "recipes", "groups"):
        plan[key] = {**first[key], **plan[key]}
    return plan


def parts_of(plan: Plan) -> List[Part]:
    groups = plan["groups"]
    pushes = {**plan["pushes"], "engines": [*population(plan["pushes"]), *plan["pushes"]["seen"]]}

    def of(names: Sequence[str]) -> List[Plan]:
        return list(policies({**plan, "groups": {name: groups[name] for name in names}}))

    pushing = plan["pushes"]["kinds"]
    kinds = [
        {"files": name if name == "expert" else f"{name}.ts.pt", "group": name}
        for name in plan["kinds"]["policies"]
    ]
    pushed = [*policies_of_pushes(plan), *({"files": f"{k}.ts.pt", "group": k} for k in pushing)]
    new = [name for name in groups if name not in plan["first_groups"]]
    return [
        Part("primary", of(plan["first_groups"]), plan["primary"]),
        Part("draws", of(new), plan["draws"]),
        Part("curves", first_entries(plan, plan["curves"]), plan["curves"]),
        Part("kinds", [{"reference": "mujoco", **kind} for kind in kinds], plan["kinds"]),
        Part("pushes", [{"reference": "mujoco", **entry} for entry in pushed], pushes),
    ]


def policies_of_pushes(plan: Plan) -> Iterator[Plan]:
    """The later trainings of the groups of which pushes are measured."""
    part = plan["pushes"]
    first = plan["first_seed"] + part["first"]
    for group in part["groups"]:
        for seed in range(first, first + part["policies"]):
            yield {"files": f"{group}-{seed}.ts.pt", "group": group}


def measure_pushes(part: Part, plan: Plan, work: Path, tables: Path) -> List[Found]:
    """Writes pushes.csv; returns what came of the hypotheses on pushes."""
    drawn = [engine for engine in part.plan["engines"] if engine not in part.plan["seen"]]
    names = [entry["files"] for entry in part.policies]
    first = 10_000 + plan["first_episode"]
    seeds = range(first, first + part.plan["episodes"])
    found = measure([str(work / name) for name in names], part.plan["engines"], part.plan, seeds)
    write_pushes(tables / "pushes.csv", found)
    recipes = []
    for group in part.plan["groups"]:
        of_group = {str(work / e["files"]): e for e in part.policies if e["group"] == group}
        lost = np.array([lost_by_engine(part, work, e["files"], drawn) for e in of_group.values()])
        recipes.append(sums_of({name: found[5][name] for name in of_group}, drawn, lost))
    return judge_pushes(recipes)


def lost_by_engine(part: Part, work: Path, policy: str, engines: Sequence[str]) -> Any:
    """[engine, start]: success in MuJoCo less that in the engine, in the loop `tracker`."""
    name = policy.partition(".")[0]
    won = {
        row["simulator"]: np.array(list(row["ends"])) == "S"
        for row in rows_of(part, work)
        if row["policy"] == name and row["loop"] == "tracker"
    }
    return np.array([won["mujoco"].astype(float) - won[engine] for engine in engines])


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


def rows_of(part: Part, work: Path) -> Iterator[Dict[str, str]]:
    """How each closed loop ended: a letter for each start, by policy, loop and simulator."""
    for loop in part.plan["loops"]:
        folder = work / part.folder(loop)
        kept = read_json(folder / "sweep.json")["rows"]
        number = 0
        for entry in part.policies:
            for policy in names_of(entry, work):
                for engine in part.plan["engines"]:
                    if engine == entry["reference"]:
                        continue
                    require_row(kept[number], policy, engine, part.plan["episodes"])
                    endings = read_endings(row_folder(folder, number) / "episodes.csv")
                    row = {"part": part.name, "group": entry["group"], "policy": policy}
                    row["loop"] = name_of_loop(loop)
                    if engine == next(e for e in part.plan["engines"] if e != entry["reference"]):
                        yield {**row, "simulator": entry["reference"], "ends": endings[REFERENCE]}
                    yield {**row, "simulator": engine, "ends": endings[ENGINE]}
                    number += 1


def require_row(row: Plan, policy: str, engine: str, episodes: int) -> None:
    """Raises Error unless a row of a sweep is the one that the plan has in this place."""
    found = (row["policy"].partition(".")[0], row["engine_simulator"], row["episodes"])
    wanted = (policy, engine.partition(":")[0], episodes)
    if found != wanted:
        raise Error(f"row of a sweep is {found}; it must be {wanted}")


def names_of(entry: Plan, work: Path) -> List[str]:
    """The policies of an entry, in the order of a sweep."""
    if "." not in entry["files"]:
        return [entry["files"]]
    return sorted(path.name.partition(".")[0] for path in work.glob(entry["files"]))


def read_endings(path: Path) -> Dict[str, str]:
    """The endings of both roles, a letter for each episode."""
    endings = {REFERENCE: "", ENGINE: ""}
    for row in read_rows(path):
        if row["mode"] in endings:
            endings[row["mode"]] += LETTERS[row["ending"]]
    return endings


def write_endings(parts: Sequence[Part], plan: Plan, work: Path, tables: Path) -> None:
    """Writes endings.csv.xz: S success, t stuck, m moving, l lost, from the first start on."""
    text = io.StringIO()
    text.write(f"# start i: spawn seed {10_000 + plan['first_episode']} + i; S success, ")
    text.write("t stuck, m moving, l lost\n")
    writer = csv.DictWriter(
        text, ("part", "group", "policy", "loop", "simulator", "ends"), lineterminator="\n"
    )
    writer.writeheader()
    for part in parts:
        writer.writerows(rows_of(part, work))
    write_file(tables / "endings.csv.xz", lzma.compress(text.getvalue().encode(), preset=9))


def study(options: argparse.Namespace) -> None:
    plan = smallest(whole_plan()) if options.smoke else whole_plan()
    work, tables = options.work, options.tables
    for folder in (work, tables):
        folder.mkdir(parents=True, exist_ok=True)
    keep_plan(plan, work)
    demonstrate(plan, work)
    train(plan, work)
    for name in {*plan["kinds"]["policies"]} - {"expert"}:
        shutil.copyfile(SHIPPED / f"{name}.ts.pt", work / f"{name}.ts.pt")
    parts = parts_of(plan)
    for part in parts:
        sweep_part(part, plan, work)
    write_endings(parts, plan, work, tables)
    if "smoke" not in plan:  # which has too few policies for an interval
        found = judge(Endings(tables / "endings.csv.xz"))
        write_hypotheses(tables / "hypotheses.csv", found)
        found_of_pushes = measure_pushes(parts[-1], plan, work, tables)
        write_table(tables / "hypotheses_pushes.csv", [one._asdict() for one in found_of_pushes])


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


def main(arguments: Sequence[str]) -> int:
    return StudyParser("study noise", __doc__ or "", STUDY).run(arguments, study)
