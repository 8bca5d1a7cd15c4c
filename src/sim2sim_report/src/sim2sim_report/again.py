# SPDX-License-Identifier: BSD-3-Clause
"""The commands that a page suggests: the one that makes a run again, the one that finds a cause."""

import json
import shlex
from pathlib import Path
from typing import Any, List, Sequence, Union

from pusht_task.json_file import Json
from pusht_task.task import HORIZON
from sim2sim_protocol.configuration import changed_options

from sim2sim_report.results import Partial, Run

REANCHORED = "engine_reanchored_"  # before the steps between two anchors, in a probe's name
VARIANT = "variant_"  # before a model variant of the reference, in the name of its replay
CLOSED_VARIANT = "closed_variant_"  # and of its closed loop
AnyRun = Union[Run, Partial]


def command_of(run: AnyRun) -> str:
    """The command that makes the run again; one over nodes is made by its launch file."""
    c = run.provenance["configuration"]
    live = "nodes" in run.provenance
    program = ("roslaunch", "compare.launch") if live else ("rosrun", "compare")
    words = [program[0], "sim2sim_eval", program[1]]

    def add(name: str, value: Any) -> None:
        text = value if isinstance(value, str) else json.dumps(value)
        if live:
            words.append(f"{name}:={text}")
        else:
            words.extend([f"--{name.replace('_', '-')}", text])

    for name in ("policy", "episodes", "first_episode"):
        add(name, c[name])
    add(*(("starts", "STARTS.csv") if "starts" in c else ("seed", c["seed"])))
    for role, option in (("reference", "--set-reference"), ("engine", "--set")):
        simulator = c["simulators"][role]
        add(role, simulator["name"])
        values = {name: _given(run, role, name) for name in simulator["changed"]}
        settings = [f"{k}={v if isinstance(v, str) else json.dumps(v)}" for k, v in values.items()]
        if live and settings:
            add(f"{role}_parameters", " ".join(settings))
        for setting in [] if live else settings:
            words.extend([option, setting])
    anchors = [p[len(REANCHORED) :] for p in c["probes"] if p.startswith(REANCHORED)]
    if anchors:
        add("reanchor", ",".join(anchors))
    for option, beginning in (("model_variants", VARIANT), ("closed_variants", CLOSED_VARIANT)):
        variants = [p[len(beginning) :] for p in c["probes"] if p.startswith(beginning)]
        if variants:
            add(option, ",".join(variants))
    if not any(p.startswith("floor_") for p in c["probes"]):
        words.append("floor:=false" if live else "--no-floor")
    add("bound_position", c["bound"]["position_m"])
    add("bound_angle", c["bound"]["angle_rad"])
    for option, value in changed_options(c).items():
        if value is True and not live:
            words.append(f"--{option.replace('_', '-')}")
        elif option != "starts":
            add(option, value)
    if live or c["horizon"] != HORIZON:
        add("horizon", c["horizon"])
    if c["smoke"]:
        words = words[:3] + ["smoke:=true" if live else "--smoke"]
    return " ".join(shlex.quote(word) for word in words)


def _given(run: AnyRun, role: str, parameter: str) -> Any:
    """Value that a parameter was set to; the name of a file whose checksum the results have."""
    value = run.provenance["configuration"]["simulators"][role]["parameters"][parameter]
    if not str(value).startswith("sha256:"):
        return value
    return run.provenance[role][parameter].get("file", value)


def notes_on_command(run: AnyRun) -> List[str]:
    """Notes on what the command alone does not bring."""
    c = run.provenance["configuration"]
    notes = []
    if "starts" in c:
        notes.append("STARTS.csv is the text under starts in the provenance.")
    if "callable" in run.provenance.get("policy", {}):
        notes.append(
            "The policy was a Python object: give it to sim2sim.compare() with what these options "
            "say; the command does not know it."
        )
    if "nodes" in run.provenance:
        notes.append("The provenance names the nodes. Those of others must be started again, too.")
    for role, simulator in c["simulators"].items():
        for name in simulator["changed"]:
            given, value = _given(run, role, name), simulator["parameters"][name]
            if given != value:
                notes.append(f"{name} {given} had the checksum {value}.")
    return notes


def suggested_attribution(folder: Path, rows: Sequence[Json]) -> str:
    """The command that finds the cause, if all that varies in a sweep is switches."""
    taken = [row["simulators"]["engine"]["parameters"] for row in rows]
    names = [name for name in taken[0] if len({json.dumps(one.get(name)) for one in taken}) > 1]
    switches = all(isinstance(one.get(name), bool) for name in names for one in taken)
    return f"rosrun sim2sim_eval attribute {folder.name}" if len(names) > 1 and switches else ""
