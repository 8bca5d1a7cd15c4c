# SPDX-License-Identifier: BSD-3-Clause
"""The figures that `coverage` prints, as rows of docs/statistics/coverage.csv and widths.csv."""

import csv
import io
import re
from pathlib import Path
from typing import Dict, Iterator, List, NamedTuple, Sequence, Tuple

from pusht_task.error import Error

FOLDER = Path(__file__).resolve().parents[3] / "docs" / "statistics"
COVERAGE = FOLDER / "coverage.csv"  # shares of repetitions
WIDTHS = FOLDER / "widths.csv"  # median intervals, in multiples of the truth
SHAPE = ("policies", "starts", "repeats")
WHAT = ("experiment", "method", "population", *SHAPE)
COLUMNS = (*WHAT, "quantity", "percent", "standard_error", "nominal", "differs", "repetitions")
WIDTH_COLUMNS = (*WHAT, "low", "high", "repetitions")
WIDTH_REPETITIONS = "201"
LOOKS = "2000"  # episodes after each of which a verdict is looked at

Row = Dict[str, str]  # by column


class Table(NamedTuple):
    """A table of the command."""

    experiment: str
    quantity: str = "holds"  # the truth; or errs, answers
    nominal: str = "95"  # [%]
    divisor: int = 1  # repetitions of the command over those of the table
    shape: Tuple[str, ...] = ("starts",)  # what the numbers of a column's name count


POLICIES, REPEATS = ("policies", "starts"), ("starts", "repeats")
HOLDS = "Share of repetitions in which the interval "
FINDS = "Share of repetitions in which a test "
TABLES = {
    f"{HOLDS}holds the truth [%], nominal 95": Table("one policy"),
    f"{FINDS}finds a difference that is not there [%], nominal 5": Table("tests", "errs", "5"),
    "Share of runs with a wrong verdict [%], looked at after each of 2 000 episodes, at most 5": (
        Table("watching", "errs", "5")
    ),
    f"{HOLDS}holds the mean divergence [%], nominal 95": Table("mean divergence"),
    f"{HOLDS}holds the ratio of mean divergences [%], nominal 95": Table("ratio of divergences"),
    f"{HOLDS}holds the mean difference of divergences [%], nominal 95": (
        Table("difference of divergences")
    ),
    f"{HOLDS}holds the median divergence [%], nominal 95": Table("median divergence"),
    "Median interval of the mean divergence, in multiples of the truth": (
        Table("mean divergence", "width")
    ),
    "Median interval of the ratio of mean divergences, in multiples of the truth": (
        Table("ratio of divergences", "width")
    ),
    "Median interval of the mean difference of divergences, in multiples of the truth": (
        Table("difference of divergences", "width")
    ),
    "Median interval of the median divergence, in multiples of the truth": (
        Table("median divergence", "width")
    ),
    f"{HOLDS}over policies and starts holds the truth [%], nominal 95": (
        Table("success of policies", divisor=2, shape=POLICIES)
    ),
    "The same of divergences [%]; none where few starts carry the mean in all repetitions": (
        Table("divergence of policies", divisor=2, shape=POLICIES)
    ),
    f"{HOLDS}between simulators holds the truth [%], nominal 95": (
        Table("rankings", divisor=8, shape=POLICIES)
    ),
    "Share of repetitions [%]": Table("rankings", "answers", "", 8, POLICIES),
    f"{HOLDS}of an equivalent error holds its size [%], nominal 95": Table("equivalent errors"),
    f"{HOLDS}over starts x repeats holds the truth [%], nominal 95": (
        Table("repeats", divisor=2, shape=REPEATS)
    ),
    "The same of intervals that take repeats for independent episodes, which is wrong [%]": (
        Table("repeats as episodes", divisor=2, shape=REPEATS)
    ),
    f"{FINDS}by start finds a difference that is not there [%], nominal 5": (
        Table("repeats", "errs", "5", 2, REPEATS)
    ),
    f"{HOLDS}of the difference of two transfers holds it [%], nominal 95": (
        Table("two policies", divisor=2, shape=REPEATS)
    ),
    f"{FINDS}finds a difference of two transfers that is not there [%], nominal 5": (
        Table("two policies", "errs", "5", 2, REPEATS)
    ),
}
# **worse than nominal**, (better), neither; a share without an error has none of these.
CELL = re.compile(r"(?P<mark>\*\*|\()?(?P<percent>[\d.]+)(?: ± (?P<error>[\d.]+))?(?:\*\*|\))?")
ENDS = re.compile(r"\[(?P<low>\S+), (?P<high>\S+)\]")
DIFFERS = {"**": "worse", "(": "better", None: ""}


def read(path: Path) -> List[Row]:
    """The rows of a CSV file."""
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def written(columns: Sequence[str], rows: Sequence[Row]) -> bytes:
    """A CSV file."""
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue().encode()


def rows_of(printed: str) -> Tuple[List[Row], List[Row]]:
    """Shares and median intervals in what the command has printed. Raises Error for a table that is
    not known."""
    counted = re.match(r"(\d+) repetitions, seed \d+\. ", printed)
    if not counted:
        raise Error("no output of coverage: must begin with the number of repetitions")
    shares: List[Row] = []
    widths: List[Row] = []
    for title, lines in _tables(printed):
        if title not in TABLES:
            raise Error(f"table {title!r}: unknown")
        table = TABLES[title]
        repetitions = max(1, int(counted[1]) // table.divisor)
        for row in _rows(table, lines, str(repetitions)):
            (widths if table.quantity == "width" else shares).append(row)
    return shares, widths


def _tables(printed: str) -> Iterator[Tuple[str, List[List[str]]]]:
    """Each table with its title: lines of cells, the names of the columns first."""
    for title, table in re.findall(r"^(\S.*)\n\n((?:\|.*\n)+)", printed, re.MULTILINE):
        lines = [line.strip("| ").split(" | ") for line in table.splitlines()]
        yield title, [lines[0], *lines[2:]]


def _rows(table: Table, lines: List[List[str]], repetitions: str) -> Iterator[Row]:
    (first, second, *columns), *body = lines
    for what, of, *cells in body:
        row = {"experiment": table.experiment, "method": what, "population": of}
        if first.startswith("size"):  # no method, but two parts of a population
            row.update(method="Tango at each size", population=f"{first} {what}, {second} {of}")
        for column, cell in zip(columns, cells):
            counts = dict(zip(table.shape, re.findall(r"\d+", column) or [LOOKS]))
            shape = {"policies": "1", "repeats": "1", **counts}
            if table.quantity == "width":
                yield {**row, **shape, **_ends(cell), "repetitions": WIDTH_REPETITIONS}
            else:
                about = {"quantity": table.quantity, "nominal": table.nominal}
                yield {**row, **shape, **about, **_share(cell), "repetitions": repetitions}


def _share(cell: str) -> Row:
    """A share of repetitions; empty where none of them has an answer."""
    if cell == "none":
        return {"percent": "", "standard_error": "", "differs": ""}
    share = CELL.fullmatch(cell)
    if not share:
        raise Error(f"cell {cell!r}: must be a share")
    error = share["error"] or ""
    return {"percent": share["percent"], "standard_error": error, "differs": DIFFERS[share["mark"]]}


def _ends(cell: str) -> Row:
    """An interval; empty where there is none."""
    if cell == "none":
        return {"low": "", "high": ""}
    ends = ENDS.fullmatch(cell)
    if not ends:
        raise Error(f"cell {cell!r}: must be an interval")
    return ends.groupdict()
