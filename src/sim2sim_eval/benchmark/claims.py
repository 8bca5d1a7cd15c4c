# SPDX-License-Identifier: BSD-3-Clause
"""Recomputes what the documents claim, and compares it with what they print, to the printed digits.

docs/claims.yaml has the claims, and says how they are written. Source the workspace first.
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

ROOT = Path(__file__).resolve().parents[3]
TABLE = ROOT / "docs" / "claims.yaml"
DIFFERS = 1  # exit code
NUMBER = re.compile(r"[+-]?\d+(?:\.\d+)?")
FIGURE = re.compile(r"{0}[^\d[\]]*(?:\[{0}[^\d,]*, {0}[^\d\]]*\])?".format(NUMBER.pattern))
BRACES = re.compile(r"\{([^{}]*)\}")
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
    """A sentence or a table's row of a document, and where its figures are in the results."""

    name: str
    document: str  # relative to the root of the project
    says: str  # what the document says, each figure in braces
    file: str  # of the results; after a # the JSON pointer under which the keys are
    keys: List[str]  # one for each figure, with its unit if the figure is printed without
    where: List[str]  # what else must hold, such as KEY < NUMBER

    @property
    def text(self) -> str:
        return BRACES.sub(r"\1", self.says)

    @property
    def figures(self) -> List[str]:
        return BRACES.findall(self.says)


class Run(NamedTuple):
    """Commands, or results that are kept, and the claims that rest on them."""

    name: str
    commands: List[str]  # none: no command of the suite repeats it, or the results are kept
    kept: str  # the folder of kept results, relative to the root of the project; empty: none
    cheap: bool  # takes seconds
    claims: List[Claim]

    @property
    def is_measured(self) -> bool:
        return bool(self.commands or self.kept)


class Row(NamedTuple):
    """A figure as printed, and as measured in the same form; empty if no command measures it."""

    claim: str
    printed: str
    measured: str

    @property
    def verdict(self) -> str:
        if not self.measured:
            return "measured outside"
        return "same" if self.measured == self.printed else "DIFFERS"


def read(path: Path) -> List[Run]:
    """The table of claims. Raises Error for a claim that cannot be checked."""
    return [_run(name, entry) for name, entry in yaml.safe_load(path.read_text("utf-8")).items()]


def _run(name: str, entry: Dict[str, Any]) -> Run:
    _require_keys(name, entry, {"claims"}, {"run", "kept", "cheap"})
    claims = [_claim(f"{name}.{key}", fields) for key, fields in entry["claims"].items()]
    kept = entry.get("kept", "")
    run = Run(name, entry.get("run", []), kept, entry.get("cheap", bool(kept)), claims)
    for claim in claims:
        count = len(claim.figures) if run.is_measured else 0
        if len(claim.keys) != count:
            raise Error(f"claim {claim.name}: {len(claim.keys)} keys: must be {count}")
    return run


def _claim(name: str, fields: Dict[str, Any]) -> Claim:
    _require_keys(name, fields, {"in", "says"}, {"file", "keys", "where"})
    claim = Claim(
        name,
        fields["in"],
        fields["says"],
        fields.get("file", ""),
        fields.get("keys", []),
        fields.get("where", []),
    )
    for figure in claim.figures:
        if not FIGURE.fullmatch(figure):
            raise Error(f"claim {name}: {figure!r}: must be like '31 % [30, 32]', or a number")
    for condition in claim.where:
        if not CONDITION.fullmatch(condition):
            raise Error(f"claim {name}: {condition!r}: must be like 'KEY < 0.05'")
    return claim


def _require_keys(name: str, entry: Dict[str, Any], needed: Set[str], known: Set[str]) -> None:
    wrong = (needed - set(entry)) | (set(entry) - needed - known)
    if wrong:
        raise Error(f"claim {name}: {', '.join(sorted(wrong))}: missing or unknown")


def plain(text: str) -> str:
    """A text with single spaces."""
    return " ".join(text.split())


def stands(claim: Claim, root: Path = ROOT) -> bool:
    """Whether the document says what the claim says."""
    return plain(claim.text) in plain((root / claim.document).read_text("utf-8"))


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


def check(run: Run, folder: Path) -> Iterator[Row]:
    """The figures and conditions of a run's claims, against its results."""
    results = Results(folder)
    for claim in run.claims:
        for i, figure in enumerate(claim.figures):
            measured = ""
            if run.is_measured:
                key, unit = _with_unit(claim.keys[i])
                measured = in_form_of(figure, results.numbers(claim, key), unit)
            yield Row(claim.name, figure, measured)
        for condition in claim.where:
            key, relation, bound = CONDITION.fullmatch(condition).groups()  # type: ignore
            value = results.numbers(claim, key)[0]
            holds = value is not None and RELATIONS[relation](value, float(bound))
            yield Row(claim.name, condition, condition if holds else f"{key} is {value}")


def execute(run: Run, folder: Path, root: Path) -> Path:
    """The folder of the run's results. They are made if they are not there."""
    if run.kept:
        return root / run.kept
    results = folder / run.name
    if results.exists() or not run.commands:
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
    options = parser.parse_args(arguments)
    rows: List[Row] = []

    def work() -> None:
        runs = chosen(read(options.table), options.names, options.cheap)
        root = options.table.resolve().parents[1]
        for claim in (claim for run in runs for claim in run.claims):
            if not stands(claim, root):
                rows.append(Row(claim.name, claim.text, f"is not in {claim.document}"))
        with tempfile.TemporaryDirectory() as temporary:
            folder = options.out or Path(temporary)
            folder.mkdir(parents=True, exist_ok=True)
            for run in runs:
                rows.extend(check(run, execute(run, folder.resolve(), root)))
        say(table(rows))
        count = {verdict: 0 for verdict in ("same", "DIFFERS", "measured outside")}
        for row in rows:
            count[row.verdict] += 1
        say(", ".join(f"{number} {verdict}" for verdict, number in count.items()))

    code = run_command("claims", work, "finished runs stay in --out")
    return code or (DIFFERS if any(row.verdict == "DIFFERS" for row in rows) else 0)


if __name__ == "__main__":
    sys.exit(main())
