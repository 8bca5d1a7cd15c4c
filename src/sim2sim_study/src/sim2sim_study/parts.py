# SPDX-License-Identifier: BSD-3-Clause
"""Parts of the study under noise: which policies run in which engines and loops."""

from typing import Any, Dict, List, NamedTuple, Sequence

from sim2sim_study.plan import (
    STUDY,
    Plan,
    first_entries,
    policies,
    read_plan,
    seeds_of,
    training_of,
    with_groups,
)
from sim2sim_study.pushes import population

NAMES = ("primary", "draws", "curves", "kinds", "pushes")


class Part(NamedTuple):
    """Sweeps of the study: the same policies and engines in each of its loops."""

    name: str
    policies: List[Plan]  # entries of a sweep's list: files, group, reference
    members: List[List[str]]  # policies of each entry, in the order of a sweep
    plan: Plan  # loops, engines, episodes

    def folder(self, loop: Any) -> str:
        """The name of the sweep in one of the loops."""
        return f"{self.name}-{name_of_loop(loop)}"


def name_of_loop(loop: Any) -> str:
    """The loop in names of files and tables: "tracker", "observation_noise_position=0.01"."""
    if isinstance(loop, str):
        return loop
    return ",".join(f"{name}={value}" for name, value in loop.items())


def whole_plan() -> Plan:
    """The plan of this study, with demonstrations, recipes and groups of the first one."""
    first = read_plan(STUDY / "study.yaml")
    plan = read_plan(STUDY / "noise" / "study.yaml")
    plan["first_groups"] = list(first["groups"])
    plan["first_seed"] = first["first_seed"]
    for key in ("demonstrations", "recipes", "groups"):
        plan[key] = {**first[key], **plan[key]}
    return plan


def parts_of(plan: Plan) -> List[Part]:
    pushes = {**plan["pushes"], "engines": [*population(plan["pushes"]), *plan["pushes"]["seen"]]}
    new = [name for name in plan["groups"] if name not in plan["first_groups"]]
    kinds = [
        {"files": name if name == "expert" else f"{name}.ts.pt", "group": name}
        for name in plan["kinds"]["policies"]
    ]
    pushed = [
        *({"files": f"{name}.ts.pt", "group": group} for group, name in pushing(plan)),
        *({"files": f"{kind}.ts.pt", "group": kind} for kind in plan["pushes"]["kinds"]),
    ]
    listed: Dict[str, List[Plan]] = {
        "primary": _groups(plan, plan["first_groups"]),
        "draws": _groups(plan, new),
        "curves": first_entries(plan, plan["curves"]),
        "kinds": [{"reference": "mujoco", **entry} for entry in kinds],
        "pushes": [{"reference": "mujoco", **entry} for entry in pushed],
    }
    return [
        Part(
            name,
            listed[name],
            [_members(plan, entry) for entry in listed[name]],
            pushes if name == "pushes" else plan[name],
        )
        for name in NAMES
    ]


def pushing(plan: Plan) -> List[Sequence[str]]:
    """Group and name of the later trainings of the groups of which pushes are measured."""
    part = plan["pushes"]
    first = plan["first_seed"] + part["first"]
    seeds = range(first, first + part["policies"])
    return [(group, f"{group}-{seed}") for group in part["groups"] for seed in seeds]


def _groups(plan: Plan, names: Sequence[str]) -> List[Plan]:
    return list(policies({**plan, "groups": {name: plan["groups"][name] for name in names}}))


def _members(plan: Plan, entry: Plan) -> List[str]:
    files, group = entry["files"], entry["group"]
    if "*" not in files:
        return [files.partition(".")[0]]
    return [f"{group}-{seed}" for seed in seeds_of(plan, training_of(plan, group))]


def with_trainings(plan: Plan, parts: Sequence[Part]) -> Plan:
    """The plan with those trainings alone that the parts need."""
    seeds: Dict[str, List[int]] = {}
    for name in (name for part in parts for names in part.members for name in names):
        group, _, seed = name.rpartition("-")
        if seed.isdigit():
            seeds.setdefault(training_of(plan, group), []).append(int(seed))
    kept = {
        name: {
            **group,
            "first_seed": min(seeds[name]),
            "seeds": max(seeds[name]) + 1 - min(seeds[name]),
        }
        for name, group in plan["groups"].items()
        if name in seeds
    }
    return with_groups(plan, kept)
