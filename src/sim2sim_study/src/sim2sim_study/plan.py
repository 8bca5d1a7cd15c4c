# SPDX-License-Identifier: BSD-3-Clause
"""Plans of the studies: which policies they train and test. They lie in docs/study."""

from pathlib import Path
from typing import Any, Dict, Iterator, List, Tuple

import yaml  # type: ignore[import]
from pusht_task.error import Error
from pusht_task.files import read_text, write_file

ROOT = Path(__file__).resolve().parents[4]  # of the source tree: plans and tables are documents
STUDY = ROOT / "docs" / "study"
Plan = Dict[str, Any]


def read_plan(path: Path) -> Plan:
    """What a file in YAML says. Raises Error if there is none."""
    try:
        plan: Plan = yaml.safe_load(read_text(path))
    except FileNotFoundError:
        raise Error(f"{path}: no such file; a study runs in the source tree") from None
    return plan


def plan_bytes(plan: Plan) -> bytes:
    """A plan as a file in YAML."""
    return yaml.safe_dump(plan, sort_keys=False).encode()


def keep_plan(plan: Plan, work: Path) -> None:
    """Writes the plan beside what is made by it. Raises Error if the folder is of another plan."""
    path = work / "plan.yaml"
    if not path.exists():
        write_file(path, plan_bytes(plan))
    kept = read_plan(path)
    for key in {**kept, **plan}:
        if kept.get(key) != plan.get(key):
            raise Error(
                f"{path}: {key} differs from the plan's; a folder is of one plan: "
                "name another by --work, or delete this one"
            )


def policies(plan: Plan) -> Iterator[Dict[str, str]]:
    """The policies of the sweep, by group: those of one training at several epochs are several."""
    for name, group in plan["groups"].items():
        for prefix in ["", *(f"after-{epochs}-" for epochs in group.get("also_after", []))]:
            yield {
                "files": f"{prefix}{name}-*.ts.pt",
                "group": prefix + name,
                "reference": group["reference"],
            }


def seeds_of(plan: Plan, training: str) -> range:
    """Seeds of the trainings of a group."""
    group = plan["groups"][training]
    first = group.get("first_seed", plan["first_seed"])
    return range(first, first + group["seeds"])


def first_policies(plan: Plan, part: Plan) -> Iterator[Tuple[str, str]]:
    """The groups of a part of the plan, each with its first policies."""
    for group in part["groups"]:
        for seed in range(plan["first_seed"], plan["first_seed"] + part["policies"]):
            yield group, f"{group}-{seed}"


def first_entries(plan: Plan, part: Plan) -> List[Plan]:
    """The first policies of a part of the plan, as a sweep lists them."""
    return [
        {"files": f"{name}.ts.pt", "group": group, "reference": plan["groups"][group]["reference"]}
        for group, name in first_policies(plan, part)
    ]


def with_groups(plan: Plan, groups: Plan) -> Plan:
    """The plan with these groups alone, and the demonstrations that they need."""
    used = {group["demonstrations"] for group in groups.values()}
    kept = {name: plan["demonstrations"][name] for name in sorted(used)}
    return {**plan, "groups": groups, "demonstrations": kept}


def training_of(plan: Plan, group: str) -> str:
    """The trainings that a group of policies comes from: "small" for "after-60-small"."""
    return next(name for name in plan["groups"] if f"-{group}".endswith(f"-{name}"))
