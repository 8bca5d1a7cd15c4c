# SPDX-License-Identifier: BSD-3-Clause
"""The command line that the studies share."""

import argparse
from pathlib import Path
from typing import Callable, Sequence

from pusht_task.command import OneLineParser, run_command

from sim2sim_study.plan import ROOT


class StudyParser(OneLineParser):
    """Arguments of a study; its tables come into `tables` unless they say otherwise."""

    def __init__(self, prog: str, what: str, tables: Path) -> None:
        super().__init__(prog=prog, description=what.splitlines()[0])
        self._default = ROOT / "build" / prog.replace(" ", "_"), tables
        work, tables = self._default
        help_work = (
            f"bags, policies and sweeps, kept for the next start (default: build/{work.name})"
        )
        self.add_argument("--work", metavar="DIR", type=Path, default=work, help=help_work)
        help_tables = f"tables and pictures (default: {tables.relative_to(ROOT)})"
        self.add_argument("--tables", metavar="DIR", type=Path, default=tables, help=help_tables)
        help_smoke = "run the least of everything: it tests this program, and says nothing"
        self.add_argument("--smoke", action="store_true", help=help_smoke)

    def run(self, arguments: Sequence[str], body: Callable[[argparse.Namespace], None]) -> int:
        """Runs a study with its arguments; returns the exit code."""
        options = self.parse_args(arguments)
        if options.smoke and (
            options.work == self._default[0] or options.tables == self._default[1]
        ):
            self.error("--smoke says nothing: give it folders of its own by --work and --tables")
        options.work, options.tables = options.work.resolve(), options.tables.resolve()
        return run_command(self.prog, lambda: body(options), "run the same command again to go on")
