# SPDX-License-Identifier: BSD-3-Clause
"""Steps that studies share: demonstrations, trainings, sweeps. Each keeps what is finished."""

import subprocess
from pathlib import Path
from typing import Any, List

from pusht_task.error import Error, ExitCode
from pusht_task.files import write_file
from pusht_task.json_file import read_json
from sim2sim_protocol.result_files import name_of

from sim2sim_study.plan import Plan, plan_bytes, seeds_of


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


def is_whole(folder: Path) -> bool:
    """Whether a run or a sweep has ended well."""
    path = folder / name_of("status")
    return path.exists() and read_json(path)["exit_code"] == 0


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
        seeds = seeds_of(plan, name)
        options += ["--seed", seeds.start, "--seeds", len(seeds)]
        options += ["--epochs", recipe["epochs"], "--hidden", *recipe["hidden"]]
        for key, option in (("model", "--model"), ("batch", "--batch"), ("learning_rate", "--lr")):
            if key in recipe:
                options += [option, recipe[key]]
        for epochs in group.get("also_after", []):
            options += ["--also-after", epochs]
        ros(work, "pusht_policy", "train", *options, "--out", f"{name}.ts.pt", "--keep")


def sweep(work: Path, folder: str, plan: Plan) -> None:
    """Runs a sweep, or what is left of it."""
    write_file(work / f"{folder}.yaml", plan_bytes(plan))
    ros(work, "sim2sim_eval", "sweep", f"{folder}.yaml", "--out", folder)
