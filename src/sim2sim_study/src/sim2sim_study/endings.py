# SPDX-License-Identifier: BSD-3-Clause
"""How each closed loop of the study under noise ended: a letter for each start. endings.csv.xz has
them all, so that every table of success follows from it."""

import csv
import io
import lzma
from pathlib import Path
from typing import Any, Dict, Iterator, List, NamedTuple, Sequence, Tuple

import numpy as np
from pusht_task.command import say
from pusht_task.error import Error
from pusht_task.files import read_file, write_file
from pusht_task.json_file import read_json
from sim2sim_protocol.result_files import name_of, row_folder
from sim2sim_report.results import read_rows

from sim2sim_study.crossed import Numbers
from sim2sim_study.parts import Part, name_of_loop
from sim2sim_study.plan import Plan
from sim2sim_study.steps import is_whole

LETTERS = {"success": "S", "stuck": "t", "moving": "m", "lost": "l"}
REFERENCE, ENGINE = "reference_closed", "engine_closed"


class Cell(NamedTuple):
    """Closed loops of a policy in a simulator: a row of the table."""

    part: str
    group: str
    policy: str
    loop: str
    simulator: str

    @property
    def sweep(self) -> str:
        """The name of the sweep that it is from, as Part.folder()."""
        return f"{self.part}-{self.loop}"


Table = Dict[Cell, str]  # a letter for each start. A group's first simulator is its reference


class NotRun(LookupError):
    """The table does not have what is asked for."""


class Endings:
    """Letters of groups of policies, as arrays."""

    def __init__(self, table: Table) -> None:
        self._rows: Dict[Tuple[str, str, str, str], Dict[str, Numbers]] = {}
        self.simulators: Dict[Tuple[str, str, str], List[str]] = {}  # by part, loop and group
        for cell, ends in table.items():
            group = cell.part, cell.loop, cell.group
            rows = self._rows.setdefault((*group, cell.simulator), {})
            if not rows:
                self.simulators.setdefault(group, []).append(cell.simulator)
            rows[cell.policy] = np.array(list(ends))

    def policies(self, part: str, loop: str, group: str) -> List[str]:
        """The policies of a group."""
        return sorted(self._rows[part, loop, group, self.simulators[part, loop, group][0]])

    def letters(
        self, part: str, loop: str, group: str, simulator: str, policies: Sequence[str] = ()
    ) -> Numbers:
        """[policy, start]: all policies of a group, or some. Raises NotRun without them."""
        try:
            rows = self._rows[part, loop, group, simulator]
            return np.array([rows[name] for name in policies or sorted(rows)])
        except KeyError:
            raise NotRun(f"{part}, {loop}, {group}, {simulator}") from None


def header(plan: Plan) -> str:
    """The first two lines of the table."""
    seed = 10_000 + plan["first_episode"]
    return (
        f"# start i: spawn seed {seed} + i; S success, t stuck, m moving, l lost\n"
        f"{','.join(Cell._fields)},ends\n"
    )


def write_endings(path: Path, plan: Plan, table: Table) -> None:
    text = io.StringIO()
    text.write(header(plan))
    csv.writer(text, lineterminator="\n").writerows([*cell, ends] for cell, ends in table.items())
    write_file(path, lzma.compress(text.getvalue().encode(), preset=9))


def read_endings(path: Path, plan: Plan) -> Table:
    """The table in a file; an empty one without a file. Raises Error for that of another plan."""
    if not path.exists():
        return {}
    text = lzma.decompress(read_file(path)).decode()
    head = header(plan)
    if not text.startswith(head):
        raise Error(f"{path}: must begin with {head!r}; it is of another study")
    return {Cell(*row[:-1]): row[-1] for row in csv.reader(io.StringIO(text[len(head) :]))}


def gather(parts: Sequence[Part], plan: Plan, work: Path, path: Path) -> Table:
    """The table of all sweeps that are finished, in the work folder or else in the file; says of
    each where it is from, or that it is missing."""
    sweeps = {part.folder(loop): (part, loop) for part in parts for loop in part.plan["loops"]}
    finished = [name for name in sweeps if is_whole(work / name)]
    kept = read_endings(path, plan) if len(finished) < len(sweeps) else {}
    table: Table = {}
    for name, (part, loop) in sweeps.items():
        rows = {cell: ends for cell, ends in kept.items() if cell.sweep == name}
        if name in finished:
            rows = dict(_swept(part, loop, work))
            source = f"from {work}"
        elif rows:
            _require_rows(path, part, loop, rows)
            source = f"kept from {path}"
        else:
            source = f"MISSING; --part {part.name} runs it"
        say(f"{name}: {source}")
        table.update(rows)
    return table


def _require_rows(path: Path, part: Part, loop: Any, rows: Table) -> None:
    wanted = [cell for cell, *_ in cells(part, loop)]
    if list(rows) != wanted or {len(ends) for ends in rows.values()} != {part.plan["episodes"]}:
        raise Error(
            f"{path}: its rows of {part.folder(loop)} must be those of the plan; "
            f"delete the file, or run --part {part.name}"
        )


def cells(part: Part, loop: Any) -> Iterator[Tuple[Cell, int, str]]:
    """The rows of a sweep in the order of the table, each with the sweep's row and the role that it
    is from."""
    number = 0
    for entry, policies in zip(part.policies, part.members):
        engines = [name for name in part.plan["engines"] if name != entry["reference"]]
        for policy in policies:
            of = part.name, entry["group"], policy, name_of_loop(loop)
            yield Cell(*of, entry["reference"]), number, REFERENCE
            for engine in engines:
                yield Cell(*of, engine), number, ENGINE
                number += 1


def _swept(part: Part, loop: Any, work: Path) -> Iterator[Tuple[Cell, str]]:
    """Rows of a finished sweep."""
    folder = work / part.folder(loop)
    swept = read_json(folder / name_of("sweep"))["rows"]
    for cell, number, role in cells(part, loop):
        if role == ENGINE:
            _require_row(swept[number], cell, part.plan["episodes"])
        episodes = read_rows(row_folder(folder, number) / name_of("episodes"))
        yield cell, "".join(LETTERS[row["ending"]] for row in episodes if row["mode"] == role)


def _require_row(row: Plan, cell: Cell, episodes: int) -> None:
    """Raises Error unless a row of a sweep is the one that the plan has in this place."""
    found = (row["policy"].partition(".")[0], row["engine_simulator"], row["episodes"])
    wanted = (cell.policy, cell.simulator.partition(":")[0], episodes)
    if found != wanted:
        raise Error(f"row of a sweep is {found}; it must be {wanted}")
