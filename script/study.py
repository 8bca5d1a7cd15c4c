#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Runs the study over policies: demonstrations, trainings, the sweep of every policy in every
simulator, its matrix, and the ladder and the conduct of some policies. docs/study/plan.md says why.

Every step keeps what is finished, so a study that was interrupted goes on where it was when it is
started again, and ends with the same bytes.
"""

import subprocess
import sys
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Tuple

import yaml  # type: ignore[import]
from pusht_task.command import OneLineParser, run_command
from pusht_task.error import Error, ExitCode
from pusht_task.files import write_file

from study_conduct import SLOWER, conduct_runs, is_whole, write_slower
from study_findings import first_policies, write_findings

ROOT = Path(__file__).resolve().parents[1]
STUDY = ROOT / "docs" / "study"
Plan = Dict[str, Any]


def ros(work: Path, package: str, command: str, *arguments: object) -> None:
    """Runs a command that must succeed."""
    _run(work, package, command, *arguments)


def printed(work: Path, package: str, command: str, *arguments: object) -> bytes:
    """What a command prints that must succeed."""
    return _run(work, package, command, *arguments, stdout=subprocess.PIPE).stdout


def _run(work: Path, *words: object, **options: Any) -> "subprocess.CompletedProcess[bytes]":
    """Runs a command in the folder of the study, so that its tables name no other folder."""
    command = ["rosrun", *map(str, words)]
    process = subprocess.run(command, cwd=work, **options)
    if process.returncode:
        text = " ".join(command)
        raise Error(f"{text}: exit code {process.returncode}", ExitCode.RUNTIME_FAULT)
    return process


def keep_plan(plan: Plan, work: Path) -> None:
    """Writes the plan beside what is made by it. Raises Error if the folder is of another plan."""
    path = work / "plan.yaml"
    if not path.exists():
        write_file(path, yaml.safe_dump(plan, sort_keys=False).encode())
    kept = yaml.safe_load(path.read_text())
    for key in {**kept, **plan}:
        if kept.get(key) != plan.get(key):
            raise Error(
                f"{path}: {key} differs from the plan's; a folder is of one plan: "
                "name another by --work, or delete this one"
            )


def demonstrate(plan: Plan, work: Path) -> None:
    """A bag for each set of demonstrations."""
    for name, what in plan["demonstrations"].items():
        bag = f"{name}.bag"
        if (work / bag).exists():
            continue
        options: List[object] = ["--seed", what.get("seed", 0)]
        options += ["--episodes", what.get("episodes", 500)]
        for simulator in what["simulators"]:
            options += ["--simulator", simulator]
        for draw in what.get("draw", []):
            options += ["--draw", draw]
        if "action_noise" in what:
            options += ["--action-noise", what["action_noise"]]
        ros(work, "sim2sim_eval", "demonstrate", *options, "--out", bag)


def train(plan: Plan, work: Path) -> None:
    """A policy for each group and seed: GROUP-SEED.ts.pt, and after-EPOCHS-GROUP-SEED.ts.pt."""
    for name, group in plan["groups"].items():
        recipe = plan["recipes"][group["recipe"]]
        options: List[object] = ["--bag", f"{group['demonstrations']}.bag"]
        first = group.get("first_seed", plan["first_seed"])
        options += ["--seed", first, "--seeds", group["seeds"]]
        options += ["--epochs", recipe["epochs"], "--hidden", *recipe["hidden"]]
        for key, option in (("model", "--model"), ("batch", "--batch"), ("learning_rate", "--lr")):
            if key in recipe:
                options += [option, recipe[key]]
        for epochs in group.get("also_after", []):
            options += ["--also-after", epochs]
        ros(work, "pusht_policy", "train", *options, "--out", f"{name}.ts.pt", "--keep")


def policies(plan: Plan) -> Iterator[Dict[str, str]]:
    """The policies of the sweep, by group: those of one training at several epochs are several."""
    for name, group in plan["groups"].items():
        for prefix in ["", *(f"after-{epochs}-" for epochs in group.get("also_after", []))]:
            yield {
                "files": f"{prefix}{name}-*.ts.pt",
                "group": prefix + name,
                "reference": group["reference"],
            }


def sweep(work: Path, folder: str, plan: Plan) -> None:
    """Runs a sweep, or what is left of it."""
    write_file(work / f"{folder}.yaml", yaml.safe_dump(plan, sort_keys=False).encode())
    ros(work, "sim2sim_eval", "sweep", f"{folder}.yaml", "--out", folder)


def sweep_policies(plan: Plan, work: Path) -> None:
    """Every policy in every simulator."""
    wanted = {key: plan[key] for key in ("episodes", "first_episode")}
    engines = {"engine": plan["engines"], "floor": False}
    sweep(work, "matrix", {"policies": list(policies(plan)), **engines, **wanted})


def sweep_variants(plan: Plan, work: Path) -> None:
    """The first policies of some groups in other discretizations of the reference's model."""
    variants = plan["variants"]
    wanted = {
        "policies": [
            {
                "files": f"{name}.ts.pt",
                "group": group,
                "reference": plan["groups"][group]["reference"],
            }
            for group, name in first_policies(plan, variants)
        ],
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
        write_file(work / f"{name}.json", (work / folder / "matrix.json").read_bytes())
    write_file(tables / "matrix.csv", (work / "matrix" / "matrix.csv").read_bytes())


def groups_of(names: List[str]) -> List[str]:
    """The options that ask for these groups."""
    return [word for name in names for word in ("--group", name)]


def smallest(plan: Plan) -> Plan:
    """The least study in which every hypothesis can be tested: it tests the program, and says
    nothing."""
    hypotheses = yaml.safe_load((STUDY / "hypotheses.yaml").read_text()).values()
    named = {name for h in hypotheses for name in h.get("ranking", [h.get("more"), h.get("less")])}
    plan["groups"] = {name: plan["groups"][name] for name in plan["groups"] if name in named}
    for group in plan["groups"].values():
        group["seeds"] = 1
    used = {group["demonstrations"] for group in plan["groups"].values()}
    plan["demonstrations"] = {name: plan["demonstrations"][name] for name in sorted(used)}
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


def study(plan: Plan, work: Path, tables: Path) -> None:
    work.mkdir(parents=True, exist_ok=True)
    tables.mkdir(parents=True, exist_ok=True)
    keep_plan(plan, work)
    for step in (demonstrate, train, sweep_policies, sweep_variants, ladder, conduct):
        step(plan, work)
    matrices(plan, work, tables)
    write_findings(plan, work, tables)


def run_study(
    prog: str,
    what: str,
    tables: Path,
    plan: Plan,
    least: Callable[[Plan], Plan],
    carry_out: Callable[[Plan, Path, Path], None],
) -> int:
    """The command of a study: `what` it does, where its tables are, and the least of its plan."""
    parser = OneLineParser(prog=prog, description=what.splitlines()[0])
    default = ROOT / "build" / prog.replace(" ", "_")
    help_work = (
        f"bags, policies and sweeps, kept for the next start (default: build/{default.name})"
    )
    parser.add_argument("--work", metavar="DIR", type=Path, default=default, help=help_work)
    help_tables = f"tables and pictures (default: {tables.relative_to(ROOT)})"
    parser.add_argument("--tables", metavar="DIR", type=Path, default=tables, help=help_tables)
    help_smoke = "run the least of everything: it tests this program, and says nothing"
    parser.add_argument("--smoke", action="store_true", help=help_smoke)
    options = parser.parse_args()
    if options.smoke and (options.work == default or options.tables == tables):
        parser.error("--smoke says nothing: give it folders of its own by --work and --tables")
    chosen = least(plan) if options.smoke else plan
    return run_command(
        prog,
        lambda: carry_out(chosen, options.work.resolve(), options.tables.resolve()),
        "run the same command again to go on",
    )


def main() -> int:
    plan = yaml.safe_load((STUDY / "study.yaml").read_text())
    return run_study("study", __doc__ or "", STUDY, plan, smallest, study)


if __name__ == "__main__":
    sys.exit(main())
