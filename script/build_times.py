#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Measures the way from a clone to an answer, and writes the table into docs/performance.md.

Each step runs in one fresh clone of the last commit, after the one before: the first comparison,
the build of everything, all tests, a check after a touched header. With --bare, in a bare Debian
beside this system (root, debootstrap and chroot are needed), where the first step also installs.
Let nothing else run meanwhile.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Dict, Iterator, List, NamedTuple, Sequence

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "performance.md"
TABLE = re.compile(r"(<!-- script/bench build -->\n).*?(<!-- end -->)", re.DOTALL)
ENGINE_HEADER = "src/pusht_engine/include/pusht_engine/two_mass_dynamics.hpp"
PROTOCOL_HEADER = "src/sim2sim_protocol/include/sim2sim_protocol/quantities.hpp"


class Step(NamedTuple):
    """A script that is timed; a comment is added to the file `touched` first."""

    name: str
    script: str
    reach: float  # [s]
    touched: str = ""
    timed: bool = True
    with_last: bool = False  # includes the time of the step before


STEPS = (
    Step("first comparison, headless", "script/compare rviz:=false", 300),
    Step("the rest of the build, with tests", "script/build -DPUSHT_BENCHMARKS=ON all tests", 600),
    Step("that, every test, and style of what changed", "script/test", 900, with_last=True),
    Step("", "script/check", 0, timed=False),
    Step("check after an engine's header", "script/check", 60, ENGINE_HEADER),
    Step("check after a header of the protocol", "script/check", 120, PROTOCOL_HEADER),
)


class Place:
    """Where the clone is: beside this one, or in a system of its own."""

    def __init__(self, folder: Path, release: str) -> None:
        self._chroot: List[str] = []
        self.clone = folder / "clone"
        if release:
            system = folder / "system"
            run(["debootstrap", "--variant=minbase", release, str(system)])
            for name in ("hosts", "resolv.conf"):
                shutil.copy(Path("/etc", name), system / "etc" / name)
            self._proc = system / "proc"
            self.clone = system / "clone"
            plain = ["HOME=/root", "PATH=/usr/sbin:/usr/bin:/sbin:/bin", "LANG=C.UTF-8"]
            self._chroot = ["chroot", str(system), "env", "--ignore-environment", *plain]
        run(["git", "clone", "--quiet", str(ROOT), str(self.clone)])

    def __enter__(self) -> "Place":
        if self._chroot:
            run(["mount", "-t", "proc", "proc", str(self._proc)])
        return self

    def __exit__(self, *_: object) -> None:
        if self._chroot:  # what a step has left running may still look at it
            run(["umount", "--lazy", str(self._proc)])

    def seconds(self, script: str) -> float:
        """What a script takes that must succeed."""
        inside = f"cd /clone && {script}" if self._chroot else f"cd {self.clone} && {script}"
        begin = time.monotonic()
        run([*self._chroot, "bash", "-c", inside])
        return time.monotonic() - begin


def run(command: Sequence[str]) -> None:
    subprocess.run(command, stdin=subprocess.DEVNULL, stdout=sys.stderr, check=True)


def measured(place: Place, steps: Sequence[Step]) -> Iterator[str]:
    """A row of the table for each step."""
    took = 0.0
    for step in steps:
        if step.touched:
            with (place.clone / step.touched).open("a", encoding="utf-8") as header:
                header.write("\n// A line more.\n")
        took = place.seconds(step.script) + (took if step.with_last else 0)
        if step.timed:
            yield f"| {step.name} | `{step.script}` | {took:.0f} s | <= {step.reach:.0f} s |"


def machine(release: str) -> str:
    cpu = re.search(r"model name\s*: (.+)", Path("/proc/cpuinfo").read_text())
    system = f"bare {release}, packages included" if release else "packages were there"
    return f"{len(os.sched_getaffinity(0))} cores, {cpu[1] if cpu else 'unknown CPU'}; {system}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bare", default="", metavar="RELEASE", help="such as bookworm or trixie")
    parser.add_argument("--steps", type=int, default=len(STEPS), help="only the first so many")
    parser.add_argument("--print", action="store_true", help="leave the page as it is")
    options = parser.parse_args()
    git: Dict[str, str] = {
        key: subprocess.check_output(["git", *words], cwd=ROOT, text=True).strip()
        for key, words in {
            "commit": ("rev-parse", "--short", "HEAD"),
            "date": ("log", "-1", "--format=%cs"),
        }.items()
    }
    with tempfile.TemporaryDirectory(prefix="build-times-") as folder:
        with Place(Path(folder), options.bare) as place:
            rows = list(measured(place, STEPS[: options.steps]))
    head = [f"Commit {git['commit']}, {git['date']}; {machine(options.bare)}.", ""]
    head += ["| what | command | measured | to reach |", "|---|---|---|---|"]
    text = "\n".join([*head, *rows]) + "\n"
    sys.stdout.write(text)
    if not options.print:
        page, count = TABLE.subn(lambda found: found[1] + text + found[2], PAGE.read_text())
        if count != 1:
            raise SystemExit(f"{PAGE}: must have the marks of one table of script/bench build")
        part = PAGE.with_name(f"{PAGE.name}.part")
        part.write_text(page)
        part.rename(PAGE)
    return 0


if __name__ == "__main__":
    sys.exit(main())
