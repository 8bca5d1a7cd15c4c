#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Names of result files have one owner: the table. C++ and Python take them from there."""

import re
import unittest
from pathlib import Path
from typing import Iterator

from sim2sim_protocol.result_files import format_of, name_of, row_folder

SOURCES = Path(__file__).resolve().parents[2]
KEYS = (
    *("metrics", "statistics", "episodes", "bands", "journal", "bag", "traces", "sweep"),
    *("sweep_table", "attribution", "attribution_table", "report", "provenance", "status"),
    "audit",
)


def products() -> Iterator[Path]:
    """Sources in C++ and Python of the packages that write and read results."""
    for package in SOURCES.glob("sim2sim_*"):
        for folder in ("apps", "include", "nodes", "scripts", "src"):
            for path in (package / folder).rglob("*"):
                if path.suffix in (".cpp", ".hpp", ".py") or (
                    path.is_file() and path.parent.name == "scripts"
                ):
                    yield path


class ResultFiles(unittest.TestCase):
    def test_names_and_formats(self) -> None:
        self.assertEqual(name_of("metrics"), "metrics.json")
        self.assertGreaterEqual(format_of("metrics"), 4)
        self.assertEqual(row_folder(Path("a"), 7), Path("a/rows/007"))

    def test_no_source_has_a_name_of_its_own(self) -> None:
        """A name in quotation marks, as code has it; prose and help may mention it."""
        names = "|".join(re.escape(name_of(key)) for key in KEYS)
        literal = re.compile(rf"""["'](?:{names})["']""")
        sources = list(products())
        self.assertGreater(len(sources), 100)
        found = [
            f"{path.relative_to(SOURCES)}: {line.strip()}"
            for path in sources
            for line in path.read_text("utf-8").splitlines()
            if literal.search(line)
        ]
        self.assertEqual(found, [])


if __name__ == "__main__":
    unittest.main()
