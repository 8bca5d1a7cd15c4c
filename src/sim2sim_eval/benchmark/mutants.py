# SPDX-License-Identifier: BSD-3-Clause
"""Plants defects in a built clone of the project, one by one, and says which test finds each.

mutants.yaml has the defects, and says how they are written. A defect is found by the first of its
tests that fails, or that does not end in time, or by the compiler. That says nothing unless the
test passes without a defect: --control, first, in the same clone.
"""

import argparse
import contextlib
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, Dict, Iterator, List, Optional, Sequence, Set, Tuple

from mutant_table import ALL, Defect, Test, chosen, read, test_named, tests_of
from pusht_task.command import OneLineParser, run_command, say
from pusht_task.error import Error, ExitCode
from pusht_task.json_file import Json, read_json, write_json

ROOT = Path(__file__).resolve().parents[3]
MISSED = 1  # exit code: a defect that no test finds, or a test that fails without one
COMPILER = "the compiler"
NO_GTEST = b"Running 0 tests"
PATIENCE = 3  # [s] for an end in order at the limit, or after an interrupt
LEAST_LIMIT, SLOWNESS = 60, 5  # a test may take so long [s], and so many times what it usually does


class Tree:
    """A built clone, in which defects are planted."""

    def __init__(self, root: Path, log: Path) -> None:
        """Raises Error for a tree in which nothing may be planted."""
        self.root = root.resolve()
        if self.root == ROOT:
            raise Error(f"tree {root}: is the source tree of this script; must be a clone")
        if not all((self.root / name).exists() for name in (".git", "build", "devel/setup.bash")):
            raise Error(f"tree {root}: must be a clone that is built (script/build all tests)")
        changes = self._git("status", "--porcelain")
        if changes:
            first = changes.splitlines()[0].split(maxsplit=1)[1]
            raise Error(f"tree {root}: has changes ({first}); must have none (git checkout .)")
        self.commit = self._git("rev-parse", "HEAD")
        self._log = log
        self._stale: Set[str] = {ALL, "tests"}  # targets in which there may be a defect

    def _git(self, *arguments: str) -> str:
        command = ["git", "-C", str(self.root), *arguments]
        return subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout.strip()

    @contextlib.contextmanager
    def with_defect(self, defect: Defect) -> Iterator[None]:
        """The defect is in its file as long as the context lasts."""
        path = self.root / defect.file
        sound = path.read_bytes()
        broken = defect.in_text(sound.decode("utf-8")).encode("utf-8")
        try:
            path.write_bytes(broken)
            yield
        finally:
            path.write_bytes(sound)

    def build(self, target: str = "", with_defect: bool = False) -> bool:
        """Builds a target, and all in which a defect was before. False if that fails."""
        targets = self._stale | ({target} if target else set())
        if not targets:
            return True
        self._stale = targets
        built = self._run([str(self.root / "script" / "build"), *sorted(targets)], None)[0] == 0
        if built and not with_defect:
            self._stale = set()
        return built

    def passes(self, test: Test, limit: Optional[float]) -> bool:
        """Whether a test passes within a limit [s]. One that finds no case does not."""
        prepare = f'source "{self.root}/devel/setup.bash" && exec "$@"'
        code, said = self._run(["bash", "-c", prepare, "bash", *test.command], limit)
        return code == 0 and NO_GTEST not in said

    def _run(self, command: Sequence[str], limit: Optional[float]) -> Tuple[Optional[int], bytes]:
        """Exit code, none beyond the limit, and what a command says, which the log keeps."""
        environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
        environment["PYTHONDONTWRITEBYTECODE"] = "1"  # or it would stay where sources change
        environment.setdefault("ROS_IP", "127.0.0.1")
        with self._log.open("a+b") as log:
            begin = log.seek(0, os.SEEK_END)
            process = subprocess.Popen(
                ["env", "--default-signal=INT,QUIT", *command],
                cwd=self.root / "build",
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
            try:
                code: Optional[int] = process.wait(limit)
            except subprocess.TimeoutExpired:
                code = None
            finally:
                _end(process)
            log.seek(begin)
            return code, log.read()


def _end(process: "subprocess.Popen[bytes]") -> None:
    """Ends a process and those of its session."""
    for number in (signal.SIGINT, signal.SIGKILL):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, number)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(PATIENCE)


class Record:
    """The file of outcomes, which is whole after each of them."""

    def __init__(self, path: Path, commit: str) -> None:
        """Goes on with a file that is there. Raises Error for one of another commit."""
        self._path = path
        self._content: Json = {"commit": commit, "control": {}, "defects": {}}
        if path.exists():
            self._content = read_json(path)
        if self._content.get("commit") != commit:
            raise Error(f"out {path}: is of another commit than {commit}; name a new file")
        self.control: Dict[str, Json] = self._content["control"]
        self.defects: Dict[str, Json] = self._content["defects"]

    def keep(self, rows: Dict[str, Json], name: str, begin: float, **row: Any) -> None:
        """Adds the outcome of what began at a time of the monotonic clock."""
        rows[name] = {**row, "seconds": round(time.monotonic() - begin, 1)}
        write_json(self._path, self._content)
        say(f"{name}: " + ", ".join(f"{key} {value}" for key, value in rows[name].items()))

    def limit(self, name: str) -> float:
        """[s] Time for a test to end. Raises Error unless it passes without a defect."""
        control = self.control.get(name, {})
        if not control.get("passes"):
            raise Error(f"test {name}: must pass without a defect; run --control first")
        return LEAST_LIMIT + SLOWNESS * float(control["seconds"])


def run_control(tree: Tree, record: Record, names: Sequence[str]) -> List[str]:
    """Runs the tests without a defect, but for those that have passed. Returns those that fail."""
    for name in names:
        if not record.control.get(name, {}).get("passes"):
            begin = time.monotonic()
            passes = tree.passes(test_named(name, tree.root), None)
            record.keep(record.control, name, begin, passes=passes)
    return [name for name in names if not record.control[name]["passes"]]


def run_defects(tree: Tree, record: Record, defects: Sequence[Defect]) -> List[str]:
    """Plants defects, but for those that have an outcome. Returns those that no test finds."""
    for defect in defects:
        if defect.id not in record.defects:
            begin = time.monotonic()
            with tree.with_defect(defect):
                finder = finder_of(tree, record, defect)
            if finder == COMPILER and not (defect.is_compiled and tree.build()):
                raise Error(f"tree {tree.root}: does not build", ExitCode.BAD_DEPENDENCY)
            row = {"file": defect.file, "what": defect.what, "found_by": finder}
            record.keep(record.defects, defect.id, begin, **row)
    return [defect.id for defect in defects if not record.defects[defect.id]["found_by"]]


def finder_of(tree: Tree, record: Record, defect: Defect) -> str:
    """The first test that finds a defect in the tree; empty if none does."""
    for name in defect.tests:
        test = test_named(name, tree.root)
        if not tree.build(test.target if defect.is_compiled else "", defect.is_compiled):
            return COMPILER
        if not tree.passes(test, record.limit(name)):
            return name
    return ""


def shard_of(text: str) -> Tuple[int, int]:
    match = re.fullmatch(r"([1-9]\d*)/([1-9]\d*)", text)
    if not match or int(match[1]) > int(match[2]):
        raise argparse.ArgumentTypeError(f"{text!r}: must be K/N with K from 1 to N")
    return int(match[1]), int(match[2])


def parse_arguments() -> Any:
    parser = OneLineParser(prog="mutants", description=(__doc__ or "").splitlines()[0])
    add = parser.add_argument
    add("--tree", metavar="DIR", type=Path, help="a clone that is built; its files are changed")
    add("--out", metavar="FILE", type=Path, help="JSON file of outcomes; one that is there goes on")
    add("--control", action="store_true", help="run the tests without a defect, which comes first")
    help_only = "these defects alone (default: all)"
    add("--only", metavar="ID,ID", type=lambda text: text.split(","), default=[], help=help_only)
    help_shard = "every Nth defect from the Kth on; each shard needs a tree and a file of its own"
    add("--shard", metavar="K/N", type=shard_of, default=(1, 1), help=help_shard)
    add("--list", action="store_true", help="say what would be planted, and where")
    return parser.parse_args()


def main() -> int:
    args = parse_arguments()
    missed: List[str] = []

    def work() -> None:
        defects = chosen(read(), args.only, args.shard)
        names = tests_of(defects)
        if args.list:
            say("\n".join(f"{d.id}: {d.what} ({d.file}): {', '.join(d.tests)}" for d in defects))
            return
        if args.tree is None or args.out is None:
            raise Error("--tree and --out: must be given")
        tree = Tree(args.tree, args.out.resolve().with_suffix(".log"))
        record = Record(args.out, tree.commit)
        if not args.control:
            for name in names:
                record.limit(name)
        if not tree.build():
            raise Error(f"tree {args.tree}: does not build", ExitCode.BAD_DEPENDENCY)
        if args.control:
            missed.extend(run_control(tree, record, names))
            say(f"{len(names) - len(missed)} of {len(names)} tests pass without a defect")
        else:
            missed.extend(run_defects(tree, record, defects))
            tree.build()
            say(f"{len(defects) - len(missed)} of {len(defects)} defects found")
        if missed:
            say("not so: " + ", ".join(missed))

    code = run_command("mutants", work, "what is done stays in --out")
    return code or (MISSED if missed else 0)


if __name__ == "__main__":
    sys.exit(main())
