# SPDX-License-Identifier: BSD-3-Clause
"""What the commands do, from Python: the options are those of the command, as keywords."""

import contextlib
import itertools
import json
import os
import tempfile
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, Optional, Union

from pusht_task.error import Error
from pusht_task.files import read_text
from sim2sim import _sim2sim
from sim2sim.checks import checked_path, checked_text
from sim2sim.errors import InvalidInput, of_exit_code
from sim2sim.results import (
    Comparison,
    Findings,
    Sweep,
    columns_from,
    loaded_sweep,
    table_of,
)
from sim2sim_eval.command import rosrun
from sim2sim_protocol.result_files import name_of

Run = Union[str, "os.PathLike[str]", Comparison, Sweep]


def contrast(*results: Run, **options: object) -> Findings:
    """Compares runs over the same episodes pair by pair, as `rosrun sim2sim_eval contrast` does.

    `results`: folders of runs or sweeps, or what compare() and sweep() return. Options: against=1,
    out="contrast.json". A row of the table is a figure of a run, less that of the baseline.
    """
    answer = _run_over("contrast", {"results": list(results)}, options)
    figures = answer["figures"]
    rows = [
        {"run": found["title"], "figure": name, **_with_ends(figure)}
        for found in figures["contrasts"]
        for name, figure in found["figures"].items()
    ]
    return Findings(figures, columns_from(rows), answer["text"])


def plan(pilot: Run, other: Optional[Run] = None, **options: object) -> Findings:
    """Says how small a difference a run can show, as `rosrun sim2sim_eval plan` does.

    Options: episodes=[50, 200], and differences of which it says how many episodes show them:
    success=0.1, position=0.01 [m], angle=0.1 [rad]. A row of the table is a difference, or, where
    the pilot is a sweep over policies, a ranking. NaN: none suffices, or the pilot does not tell.
    """
    answer = _run_over("plan", {"pilot": [pilot], "other": [other] if other else None}, options)
    figures = answer["figures"]
    if "rankings" in figures:
        rows = [{"here": row["here"], "there": row["there"], **row} for row in figures["rankings"]]
    else:
        rows = [
            {"figure": row["figure"], **dict(zip(_smallest_in(figures), row["smallest"])), **row}
            for row in figures["differences"]
        ]
        for row in rows:
            del row["smallest"]
    return Findings(figures, columns_from(rows), answer["text"])


def sweep(
    plan: Union[str, "os.PathLike[str]", Mapping[str, object]],
    *,
    progress: bool = False,
    **options: object,
) -> Sweep:
    """Runs many policies, engines and values of parameters, as `rosrun sim2sim_eval sweep` does.

    `plan` is a YAML file, or what stands in one: {"grid": {"block_damp": [2, 6]}, "episodes": 20}.
    Options: out="FOLDER" (default: the next free results/sweep-N), threads=2, overwrite=True.
    """
    with _scratch() as folder:
        if isinstance(plan, Mapping):
            text, plan = _yaml_of(plan), folder / "plan.yaml"
            plan.write_text(text)
        answer = _run("sweep", {**options, "plan": plan}, progress)
    return loaded_sweep(Path(answer["figures"]["folder"]), answer["text"])


def matrix(sweep: Run, **options: object) -> Findings:
    """Says how each policy of a sweep does in each simulator, as `rosrun sim2sim_eval matrix` does.

    Options: group=["small"], hypotheses="expected.yaml", overwrite=True. A row of the table is a
    policy in a simulator.
    """
    folder = _folder_of(sweep)
    answer = _run("matrix", {**options, "sweep": folder})
    table = table_of(read_text(Path(folder) / name_of("matrix_table")))
    return Findings(answer["figures"], table, answer["text"], Path(folder))


def report(*results: Run, **options: object) -> Path:
    """Writes an HTML page of runs, a sweep or an agreement, as `rosrun sim2sim_eval report` does.

    Options: out="page.html", images="FOLDER", animate=[7, 12], overwrite=True. Returns the page.
    """
    arguments: List[str] = []
    for name, value in options.items():
        arguments += _arguments_of(name.replace("_", "-"), value)
    try:
        page = rosrun("report", *arguments, "--", *map(_folder_of, results))
    except Error as error:
        line = str(error)
        raise of_exit_code(error.exit_code, line.split("report: ", 1)[-1]) from None
    return Path(page.rstrip("\n"))


def _run(name: str, options: Mapping[str, object], progress: bool = False) -> Dict[str, Any]:
    answer = _sim2sim.run(name, dict(options), bool(progress))
    return {"text": answer["text"], "figures": json.loads(answer["figures"])}


def _folder_of(run: Run) -> str:
    if isinstance(run, (Comparison, Sweep)):
        if run.folder is None:
            raise InvalidInput("results: must have files; give compare() a folder with out=")
        return str(run.folder)
    return checked_path("results", run)


def _run_over(
    name: str, runs: Mapping[str, Optional[List[Run]]], options: Mapping[str, object]
) -> Dict[str, Any]:
    """Runs a command over the folders of runs, by its argument. A comparison without files lends
    what commands read of it, as run-0, run-1, ..."""
    with _scratch() as scratch:
        lent = (scratch / f"run-{number}" for number in itertools.count())
        folders = {
            argument: found and [_lent(run, lent) or _folder_of(run) for run in found]
            for argument, found in runs.items()
        }
        answer = _run(name, {**options, **folders})
        return {**answer, "text": answer["text"].replace(f"{scratch}/", "")}


@contextlib.contextmanager
def _scratch() -> Iterator[Path]:
    """A folder for a while. Errors name what is in it without it."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            yield Path(folder)
        except Error as error:
            raise type(error)(str(error).replace(f"{folder}/", "")) from None


def _lent(run: Run, folders: Iterator[Path]) -> Optional[str]:
    """The next of the folders, with the files of a comparison that has none; None for others."""
    if not isinstance(run, Comparison) or run.folder is not None:
        return None
    folder = next(folders)
    folder.mkdir()
    for name, text in run.files.items():
        (folder / name).write_text(text)
    return str(folder)


def _smallest_in(figures: Mapping[str, Any]) -> List[str]:
    """The columns of a plan, one for each number of episodes."""
    return [f"smallest_in_{episodes}" for episodes in figures["episodes"]]


def _with_ends(figure: Mapping[str, Any]) -> Dict[str, Any]:
    """The figure with the ends of its interval as numbers of their own, behind the difference."""
    low, high = figure["interval"] or (None, None)
    row = {"unit": figure["unit"], "difference": figure["difference"], "low": low, "high": high}
    return {**row, **{name: value for name, value in figure.items() if name != "interval"}}


def _yaml_of(plan: Mapping[str, object]) -> str:
    """The plan as JSON, which is YAML; paths as their names."""
    try:
        return json.dumps(plan, default=os.fspath)
    except TypeError as error:
        raise InvalidInput(f"plan: {error}") from None


def _arguments_of(name: str, value: object) -> List[str]:
    """An option of a command whose command line is not C++'s."""
    if value is None or value is False:
        return []
    if value is True:
        return [f"--{name}"]
    if isinstance(value, (list, tuple)):
        value = ",".join(map(str, value))
    text = os.fspath(value) if isinstance(value, os.PathLike) else str(value)
    return [f"--{name}={checked_text(name, text)}"]
