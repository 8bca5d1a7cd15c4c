# SPDX-License-Identifier: BSD-3-Clause
"""Recomputes what the documents claim, and compares it with what they print, to the printed digits.

A document marks its figures, docs/claims.yaml says where they come from and how marks are written.
Source the workspace first.
"""

import json
import operator
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, Dict, Iterator, List, NamedTuple, Optional, Set, Tuple

import yaml  # type: ignore[import]

from pusht_task.command import OneLineParser, run_command, say
from pusht_task.error import Error, ExitCode
from pusht_task.files import write_file

ROOT = Path(__file__).resolve().parents[3]
TABLE = ROOT / "docs" / "claims.yaml"
DIFFERS = 1  # exit code
OUTSIDE = "outside"  # the mark of a figure that no command of the suite repeats
MARK = re.compile(r"<!--(\w+)(?:\.(.+?))?-->")
NUMBER = re.compile(r"(?<![\d.])[+-]?\d+(?:\.\d+)?")
INTERVAL = re.compile(r"\[{0}[^\d,\[\]]*, {0}[^\d\[\]]*\]".format(r"[+-]?\d+(?:\.\d+)?"))
FIGURE = re.compile(
    r"{0}(?:[^\d\[\]()|,;:.]{{0,16}}{1}| ?(?:times|%|(?:mm|mrad|m|rad|s|ms)\b))?".format(
        NUMBER.pattern, INTERVAL.pattern
    )
)
CONDITION = re.compile(r"(\S+) (<|<=|>|>=|=) (\S+)")
SCALES = {"%": 100.0, "mm": 1000.0, "mrad": 1000.0}  # of a printed unit; files have 1, m and rad
RELATIONS = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "=": operator.eq,
}


class Claim(NamedTuple):
    """Where the figures of a mark are in the results of a run."""

    name: str  # RUN.CLAIM
    file: str  # of the results; after a # the JSON pointer under which the keys are
    keys: List[str]  # one for each figure, with its unit if the figure is printed without
    where: List[str]  # what else must hold, such as KEY < NUMBER


class Run(NamedTuple):
    """Commands, or results that are kept, and the claims that rest on them."""

    name: str
    commands: List[str]
    kept: str  # the folder of kept results, relative to the root of the project; empty: none
    cheap: bool  # takes seconds
    claims: List[Claim]


class Figure(NamedTuple):
    """A number that a document prints, with its unit and its interval."""

    begin: int  # in the document's text
    end: int
    text: str


class Mark(NamedTuple):
    """A claim in a document: the figures before the mark."""

    claim: str
    document: str  # relative to the root of the project
    figures: List[Figure]


class Row(NamedTuple):
    """A figure as printed, and as measured in the same form."""

    claim: str
    printed: str
    measured: str

    @property
    def verdict(self) -> str:
        return "same" if self.measured == self.printed else "DIFFERS"


def documents(root: Path) -> List[str]:
    """The pages whose marks are claims."""
    pages = [root / "README.md", *sorted((root / "docs").rglob("*.md"))]
    return [str(page.relative_to(root)) for page in pages if page.exists()]


def named_by_marks(root: Path) -> Set[str]:
    """The names in the marks of all documents, without those of figures measured outside."""
    return {
        f"{mark[1]}.{mark[2]}"
        for document in documents(root)
        for mark in MARK.finditer((root / document).read_text("utf-8"))
        if mark[2]
    }


def read(path: Path) -> List[Run]:
    """The table of claims. Raises Error for a claim that cannot be checked."""
    table = yaml.safe_load(path.read_text("utf-8"))
    marked = named_by_marks(path.resolve().parents[1])
    return [_run(name, entry, marked) for name, entry in table.items()]


def _run(name: str, entry: Dict[str, Any], marked: Set[str]) -> Run:
    _require_keys(name, entry, set(), {"run", "kept", "cheap", "file", "claims"})
    if ("run" in entry) == ("kept" in entry) or ("file" in entry and "kept" not in entry):
        raise Error(f"claim {name}: must have either run or kept, and file with kept alone")
    claims = [
        _claim(f"{name}.{key}", file, fields)
        for file, of_file in entry.get("claims", {}).items()
        for key, fields in of_file.items()
    ]
    if "file" in entry:
        known = {claim.name for claim in claims}
        keys = sorted(mark for mark in marked - known if mark.startswith(f"{name}."))
        claims += [Claim(key, entry["file"], [key[len(name) + 1 :]], []) for key in keys]
    kept = entry.get("kept", "")
    return Run(name, entry.get("run", []), kept, entry.get("cheap", bool(kept)), claims)


def _claim(name: str, file: str, fields: Any) -> Claim:
    if not isinstance(fields, dict):
        fields = {"keys": fields}
    _require_keys(name, fields, {"keys"}, {"where"})
    keys = [fields["keys"]] if isinstance(fields["keys"], str) else fields["keys"]
    claim = Claim(name, file, keys, fields.get("where", []))
    for condition in claim.where:
        if not CONDITION.fullmatch(condition):
            raise Error(f"claim {name}: {condition!r}: must be like 'KEY < 0.05'")
    return claim


def _require_keys(name: str, entry: Dict[str, Any], needed: Set[str], known: Set[str]) -> None:
    wrong = (needed - set(entry)) | (set(entry) - needed - known)
    if wrong:
        raise Error(f"claim {name}: {', '.join(sorted(wrong))}: missing or unknown")


def marks_in(document: str, text: str, counts: Dict[str, int]) -> Iterator[Mark]:
    """The marks of a document; `counts` has the number of figures of each claim. Raises Error for a
    mark of no claim, or one with too few figures before it in its paragraph."""
    for mark in MARK.finditer(text):
        name = f"{mark[1]}.{mark[2]}" if mark[2] else mark[1]
        count = 1 if name == OUTSIDE else counts.get(name)
        if count is None:
            raise Error(f"{document}: mark {mark[0]}: claims.yaml has no claim {name}")
        paragraph = text.rfind("\n\n", 0, mark.start()) + 1
        found = [Figure(*one.span(), one[0]) for one in figures_in(text, paragraph, mark.start())]
        if len(found) < count:
            raise Error(
                f"{document}: mark {mark[0]}: {len(found)} figures before it: must be {count}"
            )
        yield Mark(name, document, found[len(found) - count :])


def figures_in(text: str, begin: int, end: int) -> "Iterator[re.Match[str]]":
    """The figures of a part of a text; marks have none."""
    blank = MARK.sub(lambda mark: " " * len(mark[0]), text[:end])
    return FIGURE.finditer(blank, begin)


def marks(runs: List[Run], root: Path) -> List[Mark]:
    """The marks of all documents. Raises Error if a claim of the table has none."""
    counts = {claim.name: len(claim.keys) for run in runs for claim in run.claims}
    found = [
        mark
        for document in documents(root)
        for mark in marks_in(document, (root / document).read_text("utf-8"), counts)
    ]
    unmarked = sorted(set(counts) - {mark.claim for mark in found})
    if unmarked:
        raise Error(f"claim {unmarked[0]}: no document has its mark <!--{unmarked[0]}-->")
    return found


class Results:
    """The JSON files of a run."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._contents: Dict[str, Any] = {}

    def numbers(self, claim: Claim, key: str) -> List[Optional[float]]:
        """The number at a key, and the interval beside it: value, low, high; None if it is null."""
        file, _, pointer = claim.file.partition("#")
        *path, last = [part for part in f"{pointer}/{key}".split("/") if part]
        try:
            if file not in self._contents:
                self._contents[file] = json.loads((self._folder / file).read_text("utf-8"))
            holder = self._contents[file]
            for part in path:
                holder = holder[int(part)] if isinstance(holder, list) else holder[part]
            if isinstance(holder, list):
                return [float(holder[int(last)])]
            return [holder[last], *(_interval(holder, last) or [None, None])]
        except (OSError, ValueError, LookupError, TypeError) as error:
            problem = f"{type(error).__name__}: {error}"
            raise Error(f"claim {claim.name}: {claim.file} {key}: {problem}") from None


def _interval(holder: Dict[str, Any], key: str) -> Any:
    """The interval that stands beside a figure: `transfer_interval`, `x_interval_m` of `x_m`,
    `engine_success_interval` of `engine_success_rate`, `interval` of `difference`."""
    words = key.split("_")
    names = [f"{key}_interval"]
    for count in reversed(range(1, len(words))):
        begin, end = "_".join(words[:count]), "_".join(words[count:])
        names.append(f"{begin}_interval_{end}")
    if len(words) > 1:
        names.append("_".join(words[:-1]) + "_interval")
    names.append("interval")
    return next((holder[name] for name in names if name in holder), None)


def _with_unit(key: str) -> Tuple[str, str]:
    """A key, and the unit that follows it; keys may have spaces."""
    begin, _, last = key.rpartition(" ")
    return (begin, last) if last in SCALES else (key, "")


def in_form_of(printed: str, numbers: List[Optional[float]], unit: str = "") -> str:
    """Numbers with the digits, the signs and the unit of a printed figure."""
    rest = iter(numbers)
    unit = unit or re.split(r"[\s[]+", NUMBER.sub("", printed, count=1).strip())[0]

    def measured(match: "re.Match[str]") -> str:
        number = next(rest, None)
        if number is None:
            return "none"
        digits = len(match[0].partition(".")[2])
        text = f"{number * SCALES.get(unit, 1.0):+.{digits}f}"
        if not float(text):
            text = "+" + text[1:]
        return text if match[0][0] == "+" else text.lstrip("+")

    return NUMBER.sub(measured, printed)


class Checked(NamedTuple):
    """A figure of a document beside what was measured."""

    document: str
    figure: Figure
    row: Row


def check(run: Run, found: List[Mark], folder: Path) -> Tuple[List[Checked], List[Row]]:
    """The figures of a run's marks, and the conditions of its claims, against its results."""
    results = Results(folder)
    figures, conditions = [], []
    for claim in run.claims:
        for mark in (mark for mark in found if mark.claim == claim.name):
            for figure, key_and_unit in zip(mark.figures, claim.keys):
                key, unit = _with_unit(key_and_unit)
                measured = in_form_of(figure.text, results.numbers(claim, key), unit)
                row = Row(claim.name, figure.text, measured)
                figures.append(Checked(mark.document, figure, row))
        for condition in claim.where:
            key, relation, bound = CONDITION.fullmatch(condition).groups()  # type: ignore
            value = results.numbers(claim, key)[0]
            holds = value is not None and RELATIONS[relation](value, float(bound))
            conditions.append(
                Row(claim.name, condition, condition if holds else f"{key} is {value}")
            )
    return figures, conditions


def write_figures(checked: List[Checked], root: Path) -> None:
    """Puts what was measured into the documents, in the form of what they print."""
    for document in sorted({one.document for one in checked}):
        text = (root / document).read_text("utf-8")
        of_document = [one for one in checked if one.document == document]
        for one in sorted(of_document, key=lambda one: -one.figure.begin):
            text = text[: one.figure.begin] + one.row.measured + text[one.figure.end :]
        write_file(root / document, text.encode())


def execute(run: Run, folder: Path, root: Path) -> Path:
    """The folder of the run's results. They are made if they are not there."""
    if run.kept:
        return root / run.kept
    results = folder / run.name
    if results.exists():
        return results
    part = folder / f"{run.name}.part"  # until all commands have ended well
    shutil.rmtree(part, ignore_errors=True)
    part.mkdir()
    for command in run.commands:
        print(f"claims: {run.name}: {command}", file=sys.stderr, flush=True)
        process = subprocess.run(
            ["bash", "-c", command],
            cwd=part,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        if process.returncode != 0:
            last = (process.stderr.strip().splitlines() or ["failed"])[-1]
            raise Error(f"{run.name}: {command}: {last}", ExitCode.RUNTIME_FAULT)
    part.rename(results)
    return results


def table(rows: List[Row]) -> str:
    header = ("claim", "printed", "measured", "")
    lines = [header, *((row.claim, row.printed, row.measured, row.verdict) for row in rows)]
    widths = [max(len(line[i]) for line in lines) for i in range(len(header))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip() for line in lines
    )


def chosen(runs: List[Run], names: List[str], cheap: bool) -> List[Run]:
    """The runs whose claims are asked for, with these claims alone."""
    known = {run.name for run in runs} | {claim.name for run in runs for claim in run.claims}
    for name in names:
        if name not in known:
            raise Error(f"claim {name}: unknown; docs/claims.yaml has all")
    result = []
    for run in runs:
        claims = [
            claim for claim in run.claims if not names or run.name in names or claim.name in names
        ]
        if claims and (run.cheap or not cheap):
            result.append(run._replace(claims=claims))
    return result


def main(arguments: Optional[List[str]] = None) -> int:
    parser = OneLineParser(prog="claims", description=(__doc__ or "").splitlines()[0])
    help_names = "names of claims or of their runs, as in docs/claims.yaml (default: all)"
    parser.add_argument("names", metavar="NAME", nargs="*", help=help_names)
    parser.add_argument("--cheap", action="store_true", help="only of runs that take seconds")
    help_out = "keep the results here, and use those that are here (default: a temporary folder)"
    parser.add_argument("--out", metavar="DIR", type=Path, help=help_out)
    help_table = "another table, of documents relative to the folder above its own"
    parser.add_argument("--table", metavar="FILE", type=Path, default=TABLE, help=help_table)
    help_write = "put figures that differ into the documents; then look at the words around them"
    parser.add_argument("--write", action="store_true", help=help_write)
    options = parser.parse_args(arguments)
    rows: List[Row] = []

    def work() -> None:
        everything = read(options.table)
        root = options.table.resolve().parents[1]
        found = marks(everything, root)
        differing: List[Checked] = []
        with tempfile.TemporaryDirectory() as temporary:
            folder = options.out or Path(temporary)
            folder.mkdir(parents=True, exist_ok=True)
            for run in chosen(everything, options.names, options.cheap):
                figures, conditions = check(run, found, execute(run, folder.resolve(), root))
                differing += [one for one in figures if one.row.verdict == "DIFFERS"]
                rows.extend([*(one.row for one in figures), *conditions])
        if options.write:
            write_figures(differing, root)
        say(table(rows))
        count = {verdict: 0 for verdict in ("same", "DIFFERS")}
        for row in rows:
            count[row.verdict] += 1
        outside = sum(mark.claim == OUTSIDE for mark in found)
        counts = ", ".join(f"{number} {verdict}" for verdict, number in count.items())
        say(f"{counts}; {outside} were measured outside")

    code = run_command("claims", work, "finished runs stay in --out")
    return code or (DIFFERS if any(row.verdict == "DIFFERS" for row in rows) else 0)


if __name__ == "__main__":
    sys.exit(main())
