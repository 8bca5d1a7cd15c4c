# SPDX-License-Identifier: BSD-3-Clause
"""The table of defects that script/mutants plants, and the tests that should find them."""

import re
from pathlib import Path
from typing import List, NamedTuple, Sequence, Tuple

import yaml  # type: ignore[import]

from pusht_task.error import Error

TABLE = Path(__file__).with_name("mutants.yaml")
PYTHON = "/usr/bin/python3"
ALL = "all"  # the target that has what tests of commands and nodes need
GTEST = re.compile(r"\b(?:pusht_add_gtest|pusht_add_kind_gtest|catkin_add_gmock)\((\w+)")


class Defect(NamedTuple):
    """A defect of one line, as in the table."""

    id: str
    file: str  # relative to the root of the project
    old: str
    new: str
    what: str
    tests: List[str]

    @property
    def is_compiled(self) -> bool:
        return Path(self.file).suffix in (".cpp", ".hpp")

    def in_text(self, text: str) -> str:
        """The content of the file with the defect. Raises Error where it has no single place."""
        if text.count(self.old) != 1:
            raise Error(
                f"defect {self.id}: {self.old!r} is {text.count(self.old)} times in {self.file}: "
                "must be there once"
            )
        return text.replace(self.old, self.new)


def read(path: Path = TABLE) -> List[Defect]:
    """The table of defects."""
    return [Defect(**entry) for entry in yaml.safe_load(path.read_text("utf-8"))]


class Test(NamedTuple):
    """A test of a tree."""

    target: str  # what must be built for it
    command: List[str]


def test_named(name: str, tree: Path) -> Test:
    """The test that a defect names. Raises Error if there is none, or more than one."""
    program, _, chosen = name.partition(":")
    kind = Path(program).suffix
    if kind:
        files = list(tree.glob(f"src/*/test/{program}"))
    else:
        files = [
            p for p in tree.glob("src/*/CMakeLists.txt") if program in GTEST.findall(p.read_text())
        ]
    if len(files) != 1:
        raise Error(f"test {name}: is there {len(files)} times: must be there once")
    package = files[0].relative_to(tree).parts[1]
    if kind == ".test":
        return Test(ALL, ["rostest", str(files[0])])
    if kind == ".py":
        options = ["-x", "-q", "-p", "no:cacheprovider", f"--rootdir={tree}/src/{package}"]
        expression = ["-k", chosen] if chosen else []
        return Test(ALL, [PYTHON, "-m", "pytest", *options, str(files[0]), *expression])
    command = [f"{tree}/devel/lib/{package}/{program}", "--gtest_fail_fast"]
    return Test(program, [*command, f"--gtest_filter={chosen or '*'}"])


def tests_of(defects: Sequence[Defect]) -> List[str]:
    """The tests that defects name, each once."""
    return list(dict.fromkeys(name for defect in defects for name in defect.tests))


def chosen(defects: List[Defect], only: Sequence[str], shard: Tuple[int, int]) -> List[Defect]:
    """The defects that are asked for. Raises Error for a name that is none."""
    unknown = set(only) - {defect.id for defect in defects}
    if unknown:
        raise Error(f"defect {min(unknown)}: unknown; --list has all")
    asked = [defect for defect in defects if not only or defect.id in only]
    return asked[shard[0] - 1 :: shard[1]]
