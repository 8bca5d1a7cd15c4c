#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What script/bench says of its figures."""

import random
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "benchmark"))
from live_runs import median  # noqa: E402
from targets import Figure, kinds  # noqa: E402


class Median(unittest.TestCase):
    def test_ranks_are_those_of_the_table(self) -> None:
        # The ranks of the sign test's tables, 95 %.
        for count, low, high in ((6, 1, 6), (10, 2, 9), (20, 6, 15), (40, 14, 27)):
            found = median([float(rank) for rank in range(1, count + 1)])
            self.assertEqual(found["interval"], (low, high), count)

    def test_interval_holds_the_median_as_often_as_it_says(self) -> None:
        draw = random.Random(1)
        held = 0
        for _ in range(2000):
            low, high = median([draw.expovariate(1.0) for _ in range(20)])["interval"]
            held += low < 0.6931471805599453 < high  # the median of that distribution: ln 2
        self.assertGreater(held / 2000, 0.94)
        self.assertLess(held / 2000, 0.98)  # ranks are whole: 0.959

    def test_too_few_values_have_no_interval(self) -> None:
        with self.assertRaisesRegex(ValueError, "5 values: too few"):
            median([1.0] * 5)


class Kinds(unittest.TestCase):
    def test_every_kind_has_its_speed_and_its_reset(self) -> None:
        rate = {"mujoco/bare": 20e3, "kind/box2d": 40e3, "reset/box2d": 500e3}
        rate.update({"kind/apple": 10e3, "reset/apple": 10e3})
        self.assertEqual(
            [(f.meaning, f.measured, f.unit, f.verdict) for f in kinds(rate)],
            [
                ("apple", 10e3, "control steps/s", ""),
                ("apple over bare mj_step", 0.5, "x", ""),
                ("apple, reset", 100.0, "us", "NOT MET"),
                ("box2d", 40e3, "control steps/s", ""),
                ("box2d over bare mj_step", 2.0, "x", ""),
                ("box2d, reset", 2.0, "us", "met"),
            ],
        )


class Verdict(unittest.TestCase):
    def test_interval_decides(self) -> None:
        for interval, verdict in (
            ((0.02, 0.04), "met"),
            ((0.06, 0.07), "NOT MET"),
            ((0.06, 0.16), "NOT MET"),  # however wide
            ((0.02, 0.06), "undecided"),
            ((-0.03, 0.04), "undecided"),  # wider than the bound
        ):
            figure = Figure("P", "share", 0.03, "", at_most=0.05, interval=interval)
            self.assertEqual(figure.verdict, verdict, interval)

    def test_value_without_an_interval(self) -> None:
        self.assertEqual(Figure("P", "speed", 1.9, "x", at_least=1.8).verdict, "met")
        self.assertEqual(Figure("P", "speed", 1.7, "x", at_least=1.8).verdict, "NOT MET")
        self.assertEqual(Figure("", "speed", 1.7, "x").verdict, "")


if __name__ == "__main__":
    unittest.main()
