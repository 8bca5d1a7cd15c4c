#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What becomes of the output of `coverage`: rows of data, and the table of docs/statistics.md."""

import sys
import unittest
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(PACKAGE / "benchmark"))
import coverage_data as data  # noqa: E402
from coverage_figure import shares_of, table  # noqa: E402
from pusht_task.error import Error  # noqa: E402

PAGE = PACKAGE.parents[1] / "docs" / "statistics.md"
PRINTED = """4000 repetitions, seed 0. Each figure has its standard error.

Share of repetitions in which the interval over starts x repeats holds the truth [%], nominal 95

| interval | population | 10 x 5 | 25 x 2 | 25 x 5 |
| --- | --- | --- | --- | --- |
| success rate | a coin | **92.3 ± 0.6** | (98.0 ± 0.3) | none |

Median interval of the median divergence, in multiples of the truth

| interval | population | n = 10 |
| --- | --- | --- |
| median, order statistics | angle | [0.057, 9e+02] |
"""


class Rows(unittest.TestCase):
    def test_every_cell_is_a_row(self) -> None:
        shares, widths = data.rows_of(PRINTED)
        found = [(r["starts"], r["repeats"], r["percent"], r["standard_error"]) for r in shares]
        self.assertEqual(
            found, [("10", "5", "92.3", "0.6"), ("25", "2", "98.0", "0.3"), ("25", "5", "", "")]
        )
        self.assertEqual([r["differs"] for r in shares], ["worse", "better", ""])
        self.assertEqual({r["repetitions"] for r in shares}, {"2000"})
        self.assertEqual([(r["low"], r["high"]) for r in widths], [("0.057", "9e+02")])

    def test_what_is_no_output_of_the_command_is_refused(self) -> None:
        for text, why in (
            (PRINTED[1:].lstrip("0"), "must begin with the number of repetitions"),
            (PRINTED.replace("over starts x repeats", "over nothing"), "unknown"),
            (PRINTED.replace("(98.0", "[98.0"), "must be a share"),
            (PRINTED.replace("[0.057, 9e+02]", "0.057"), "must be an interval"),
        ):
            with self.subTest(why), self.assertRaisesRegex(Error, why):
                data.rows_of(text)


class Table(unittest.TestCase):
    def test_page_has_the_table_of_the_data(self) -> None:
        lines = list(table(shares_of(data.read(data.COVERAGE))))
        page = PAGE.read_text(encoding="utf-8").splitlines()
        begin = page.index(lines[0])
        self.assertEqual(page[begin : begin + len(lines) + 1], [*lines, ""])

    def test_a_method_that_is_in_no_group_is_refused(self) -> None:
        row = {**data.read(data.COVERAGE)[0], "method": "guess"}
        with self.assertRaisesRegex(Error, "one policy, guess: must be in one group"):
            shares_of([row])

    def test_too_few_repetitions_are_refused(self) -> None:
        rows = [{**row, "standard_error": "11.2"} for row in data.read(data.COVERAGE)]
        with self.assertRaisesRegex(Error, "run coverage with more repetitions"):
            list(table(shares_of(rows)))


if __name__ == "__main__":
    unittest.main()
