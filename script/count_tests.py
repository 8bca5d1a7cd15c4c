#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The last lines of a script that tests: the files that took longest, every case that failed or was
skipped, then "N passed, N failed", and ", N skipped" where some were.

A test that left no result has failed: one that CMake registered, or, with --all, a file of tests in
the source tree. Lint is one test more. A report of a sanitizer is a failure.
"""

import argparse
import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Dict, Iterator, List
from xml.etree import ElementTree

SLOWEST = 10
RUNNER = "run_tests.py"  # catkin's; the file of results is its first argument
TESTS = re.compile(r"^\s*def test_|^TEST(_F|_P)?\(", re.MULTILINE)


def registered(build: Path, targets: List[str]) -> Iterator[Path]:
    """The files of results that the targets of a build folder must leave, as CMake has them."""
    listing = subprocess.run(
        ["ctest", "--show-only=json-v1"], cwd=build, stdout=subprocess.PIPE, check=True
    )
    for test in json.loads(listing.stdout)["tests"]:
        name = re.sub(r"^_ctest", "run_tests", test["name"])
        command = test.get("command", [])
        places = [i for i, word in enumerate(command) if Path(word).name == RUNNER]
        if places and any(f"{name}_".startswith(f"{target}_") for target in targets):
            yield Path(command[places[0] + 1])


def test_files(packages: Path) -> Iterator[Path]:
    """The files of the source tree that hold tests: C++, Python and rostest."""
    for path in sorted(packages.glob("*/test/*")):
        if path.suffix == ".test" or (
            path.suffix in (".cpp", ".py") and TESTS.search(path.read_text())
        ):
            yield path


def slowest(times: Path) -> Iterator[str]:
    """The longest tests in ctest's report, a line each."""
    cases = ElementTree.parse(times).getroot().iter("testcase")
    seconds = {str(case.get("name")): float(case.get("time") or 0) for case in cases}
    for name in sorted(seconds, key=lambda name: -seconds[name])[:SLOWEST]:
        yield f"{seconds[name]:6.1f} s  {name.replace('_ctest_', '')}"


class Count:
    """Cases, by what became of them."""

    def __init__(self) -> None:
        self.passed = 0
        self.failed: List[str] = []
        self.skipped: List[str] = []
        self.results: Dict[Path, ElementTree.Element] = {}

    def lint(self, outcome: str) -> None:
        if outcome == "failed":
            self.failed.append("lint")
        elif outcome == "skipped":
            self.skipped.append("lint: its tools are those of Debian 12")
        else:
            self.passed += 1

    def folder(self, build: Path) -> None:
        """Counts the results and reports in a build folder."""
        for path in sorted(build.glob("test_results/**/*.xml")):
            try:
                self.results[path.resolve()] = ElementTree.parse(path).getroot()
            except ElementTree.ParseError as error:
                self.failed.append(f"{path}: {error}")
                continue
            for case in self.results[path.resolve()].iter("testcase"):
                self.case(case)
        for report in sorted(build.glob("reports/*")):
            self.failed.append(f"sanitizer's report {report}\n{report.read_text(errors='replace')}")

    def case(self, case: ElementTree.Element) -> None:
        name = f"{case.get('classname')}.{case.get('name')}"
        skip = case.find("skipped")
        if case.find("failure") is not None or case.find("error") is not None:
            self.failed.append(name)
        elif skip is not None:
            self.skipped.append(f"{name}: {(skip.get('message') or '').strip()}")
        elif case.get("status") == "notrun":
            self.skipped.append(f"{name}: disabled")
        else:
            self.passed += 1

    def has_case(self, path: Path) -> bool:
        root = self.results.get(path.resolve())
        return root is not None and root.find(".//testcase") is not None

    def require(self, build: Path, targets: List[str]) -> None:
        """Counts as failed each test that CMake registered for the targets and that has no case."""
        for path in registered(build, targets):
            if not self.has_case(path):
                self.failed.append(f"{path}: has no test that ran")

    def require_tree(self, packages: Path) -> None:
        """Counts as failed each file of tests in the source tree that left no case.

        A file that another one runs needs none of its own.
        """
        sources = {
            (path.parent.name, Path(case.get("file", "")).name)
            for path, root in self.results.items()
            for case in root.iter("testcase")
        }
        ran: Dict[Path, str] = {}
        missing: List[Path] = []
        for path in test_files(packages):
            text = path.read_text()
            package = path.parents[1].name
            results = result_names(path, text)
            folders = {found.parent for found in self.results if found.parent.name == package}
            if (package, path.name) in sources or any(
                results and all(self.has_case(folder / name) for name in results)
                for folder in folders
            ):
                ran[path] = text
            else:
                missing.append(path)
        for path in missing:
            program = path.name if path.suffix == ".py" else path.stem
            if path.suffix == ".test" or not any(f'"{program}"' in text for text in ran.values()):
                self.failed.append(f"{path}: has no test that ran")

    def __str__(self) -> str:
        lines = [f"skipped: {name}" for name in self.skipped]
        lines += [f"FAILED: {name}" for name in self.failed]
        total = f"{self.passed} passed, {len(self.failed)} failed"
        return "\n".join(
            [*lines, f"{total}, {len(self.skipped)} skipped" if self.skipped else total]
        )


def result_names(path: Path, text: str) -> List[str]:
    """The files of results that a file of tests leaves if a test of its own runs it; for C++ the
    results say themselves from which file a case is."""
    if path.suffix == ".py":
        return [f"pytest-test.{path.name}.xml"]
    if path.suffix == ".test":
        tests = re.findall(r'test-name="([^"]+)"', text)
        return [f"rostest-test_{path.stem}.xml", *(f"rosunit-{test}.xml" for test in tests)]
    return []


def main(arguments: List[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--lint", choices=("passed", "failed", "skipped"), help="if it ran")
    parser.add_argument(
        "--failed", action="append", default=[], metavar="WHAT", help="what else has failed"
    )
    parser.add_argument(
        "--times", type=Path, metavar="FILE", help="ctest's report: print its longest tests"
    )
    parser.add_argument(
        "--all", type=Path, metavar="SRC", help="every test file in SRC must have run"
    )
    parser.add_argument(
        "--ran", nargs="+", action="append", default=[], metavar="BUILD TARGET",
        help="a build folder, and the targets that ran in it",
    )  # fmt: skip
    parser.add_argument(
        "--result", type=Path, action="append", default=[], metavar="FILE",
        help="a file of results, in a build folder that is counted, that must have a case",
    )  # fmt: skip
    options = parser.parse_args(arguments)
    count = Count()
    if options.lint:
        count.lint(options.lint)
    for build, *targets in options.ran:
        count.folder(Path(build))
        count.require(Path(build), targets)
    for path in options.result:
        if not count.has_case(path):
            count.failed.append(f"{path}: has no test that ran")
    if options.all:
        count.require_tree(options.all)
    count.failed.extend(options.failed)
    if options.times and options.times.exists():  # what did not start has none
        print("the longest tests:", *slowest(options.times), sep="\n")
    print(count)
    return 1 if count.failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
