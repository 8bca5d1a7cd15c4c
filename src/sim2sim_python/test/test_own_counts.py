#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The statistics in Python: those of the results, for counts and samples of any origin."""

import math
import unittest
from typing import Any, Dict, List, Tuple

import numpy as np
import sim2sim
from sim2sim.statistics import (
    PairTable,
    episodes_for,
    episodes_for_rates,
    holm,
    mcnemar_exact,
    mcnemar_mid_p,
    mcnemar_power,
    mean_of,
    median_of,
    paired_difference,
    repeated_difference,
    repeated_rate_interval,
    repeated_ratio_interval,
    smallest_difference,
    smallest_rate_difference,
    tang_interval,
    tango_interval,
    transfer_sequence,
    verdict,
    verdict_of,
    wilson_interval,
)

TABLE = PairTable(both=30, first_only=12, second_only=3, neither=5)


class OwnNumbers(unittest.TestCase):
    def test_closed_forms(self) -> None:
        z = 1.959963984540054
        low, high = wilson_interval(11, 50)
        middle = (0.22 + z * z / 100) / (1 + z * z / 50)
        half = z / (1 + z * z / 50) * math.sqrt(0.22 * 0.78 / 50 + z * z / 10000)
        self.assertAlmostEqual(low, middle - half, 9)
        self.assertAlmostEqual(high, middle + half, 9)
        exact = 2 * sum(math.comb(15, k) for k in range(4)) / 2**15
        self.assertAlmostEqual(mcnemar_exact(TABLE), exact, 12)
        self.assertAlmostEqual(mcnemar_mid_p(TABLE), exact - math.comb(15, 3) / 2**15, 12)
        self.assertEqual(holm([0.01, 0.04, 0.03]), [0.03, 0.06, 0.06])
        self.assertEqual(holm([]), [])
        self.assertEqual(median_of([3.0, 1.0, 2.0]).value, 2.0)
        self.assertEqual(mean_of([1.0, 2.0]), (1.5, None))
        self.assertAlmostEqual(smallest_difference(0.1, 100), 0.028016, 6)
        self.assertEqual(episodes_for(0.1, 0.028016), 100)

    def test_pairs(self) -> None:
        first = [True] * 42 + [False] * 8
        second = [True] * 30 + [False] * 12 + [True] * 3 + [False] * 5
        self.assertEqual(PairTable.of(first, second), TABLE)
        self.assertEqual(PairTable.of(np.array(first, int), np.array(second)), TABLE)
        self.assertEqual((TABLE.pairs, TABLE.difference, TABLE.ratio), (50, -0.18, 33 / 42))
        for interval, value in (
            (tango_interval(TABLE), TABLE.difference),
            (tang_interval(TABLE), TABLE.ratio),
            (transfer_sequence(TABLE), TABLE.ratio),
        ):
            assert interval
            self.assertLess(interval.low, value)
            self.assertGreater(interval.high, value)
        self.assertEqual(tango_interval((30, 12, 3, 5)), tango_interval(TABLE))
        self.assertIsNone(tango_interval(PairTable(1, 1, 1, 1)))
        self.assertTrue(math.isnan(PairTable(0, 0, 3, 5).ratio))

    def test_verdicts(self) -> None:
        for table, word in (
            ((95, 2, 3, 0), "transfers"),
            ((0, 50, 0, 0), "does_not_transfer"),
            ((0, 0, 10, 40), "nothing_to_transfer"),
            ((1, 1, 0, 0), "cannot_say"),
            ((40, 0, 60, 0), "exceeds"),
        ):
            self.assertEqual(verdict(table), word)
        self.assertEqual(verdict_of((0.6, 0.8)), "transfers_in_part")
        self.assertEqual(verdict_of((0.4, 0.8)), "at_most_in_part")
        self.assertEqual(verdict_of(None), "cannot_say")

    def test_repeats(self) -> None:
        alike = [PairTable(4, 0, 0, 0), PairTable(0, 4, 0, 0)] * 10
        different = [PairTable(2, 2, 0, 0)] * 20
        for starts in (alike, different):
            self.assertEqual(repeated_difference(starts).value, -0.5)
        wide, narrow = (repeated_ratio_interval(starts) for starts in (alike, different))
        assert wide and narrow
        self.assertGreater(wide.high - wide.low, narrow.high - narrow.low)
        self.assertIsNone(repeated_rate_interval([1], [4]))

    def test_planning_and_its_power(self) -> None:
        least = smallest_rate_difference(0.3, 200)
        assert least
        self.assertAlmostEqual(mcnemar_power(0.3, least, 200), 0.8, 2)
        self.assertEqual(episodes_for_rates(0.3, 0.3), episodes_for_rates(0.3, 0.3))
        needed = episodes_for_rates(0.3, 0.1)
        assert needed
        self.assertGreaterEqual(mcnemar_power(0.3, 0.1, needed), 0.8)
        self.assertLess(mcnemar_power(0.3, 0.1, needed - 10), 0.8)
        self.assertIsNone(episodes_for(10.0, 1e-6))

    def test_bad_input_is_one_line(self) -> None:
        few: Any = (1, 2, 3)
        words: Any = "up"
        for call, line in (
            (lambda: wilson_interval(3, 0), "^trials 0: must be from 1 to"),
            (lambda: wilson_interval(6, 5), "^successes 6: must be from 0 to 5$"),
            (lambda: wilson_interval(words, 5), "^successes 'up': must be an integer$"),
            (lambda: tango_interval(few), r"^table \[1, 2, 3\]: must have 4 counts: both, first"),
            (lambda: repeated_difference(words), "^starts 'up': must be a list$"),
            (lambda: tango_interval((1, 2, 3, -4)), "^neither -4: must be from"),
            (lambda: PairTable.of([1, 2], [0, 0]), "^first: must be a list of true and false"),
            (lambda: PairTable.of([1, 1], [0]), "^second: 1 successes; must be 2, as of first$"),
            (lambda: mean_of([1.0, -1.0]), "must be"),
            (lambda: mean_of([[1.0], []]), "^samples .*inhomogeneous"),  # type: ignore
            (lambda: mean_of(words), "^samples <U2 of shape"),
            (lambda: holm([2.0]), "must be"),
            (lambda: mcnemar_power(words, 0.1, 50), "^discordant 'up': must be a number$"),
            (lambda: repeated_rate_interval([1], [4, 4]), "^episodes: 2 starts; must be 1"),
        ):
            with self.subTest(line), self.assertRaisesRegex(sim2sim.InvalidInput, line) as caught:
                call()
            self.assertNotIn("\n", str(caught.exception))


class FiguresOfARun(unittest.TestCase):
    def test_they_are_those_of_the_results(self) -> None:
        run: Dict[str, Any] = {"episodes": 24, "floor": False}
        found = sim2sim.compare("bc", **run)
        summary, columns = found.summary, found.episodes
        success = {
            mode: columns["success"][columns["mode"] == mode]
            for mode in ("reference_closed", "engine_closed")
        }
        table = PairTable.of(success["reference_closed"], success["engine_closed"])
        self.assertEqual(table.both, summary["both_succeed"])
        replays = columns["mode"] == "engine_replay"
        divergence = columns["mean_position_divergence_m"][replays]
        baseline = columns["null_position_divergence_m"][replays]
        paired = paired_difference(divergence - baseline, baseline.mean())
        own: List[Tuple[Any, str]] = [
            (table.ratio, "transfer"),
            (tang_interval(table), "transfer_interval"),
            (tango_interval(table), "success_difference_interval"),
            (mcnemar_mid_p(table), "success_difference_p"),
            (mcnemar_exact(table), "success_difference_exact_p"),
            (wilson_interval(table.both + table.second_only, 24), "engine_success_interval"),
            (paired.value, "mean_pos_divergence_minus_null_m"),
            (paired.interval, "mean_pos_divergence_minus_null_interval_m"),
        ]
        for found_here, name in own:
            np.testing.assert_allclose(found_here, summary[name], rtol=0, atol=1e-6, err_msg=name)


if __name__ == "__main__":
    unittest.main()
