#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Statistics of the studies, on samples whose figures follow by hand."""

import math
import unittest

import numpy as np
from scipy import stats  # type: ignore[import]
from sim2sim_study import crossed, statistics
from study_case import StudyCase, T


class Mean(StudyCase):
    def test_interval_is_students(self) -> None:
        # Variance 2.5, so the standard error is sqrt(2.5 / 5), with 4 degrees of freedom.
        self.assert_interval(statistics.mean([1, 2, 3, 4, 5]), 3.0, T[4] * math.sqrt(0.5))
        self.assert_interval(statistics.mean([0.25, 0.75]), 0.5, T[1] * 0.25)
        self.assert_interval(statistics.mean([0.5, 0.5, 0.5]), 0.5, 0.0)

    def test_one_value_has_no_interval(self) -> None:
        self.assertEqual(statistics.mean([0.25]), {"mean": 0.25, "low": "", "high": ""})


class Difference(StudyCase):
    def test_interval_is_welchs(self) -> None:
        # Variances 2.5 each: standard error sqrt(2.5 / 5 + 2.5 / 5) = 1, 8 degrees of freedom.
        self.assert_interval(statistics.difference([6, 7, 8, 9, 10], [1, 2, 3, 4, 5]), 5.0, T[8])
        self.assert_interval(statistics.difference([1, 2, 3, 4, 5], [6, 7, 8, 9, 10]), -5.0, T[8])
        # A group without spread adds no degree of freedom: 4, where a pooled variance has 5.
        for more, less, mean in (
            ([1.0, 2.0, 3.0, 4.0, 5.0], [2.0, 2.0], 1.0),
            ([2.0, 2.0], [1.0, 2.0, 3.0, 4.0, 5.0], -1.0),
        ):
            self.assert_interval(statistics.difference(more, less), mean, T[4] * math.sqrt(0.5))

    def test_degrees_of_freedom_are_satterthwaites(self) -> None:
        # Squared standard errors 10 / 5 = 2 and 3.5 / 6 = 7 / 12, so the degrees of freedom are
        # (31 / 12)^2 / (4 / 4 + (7 / 12)^2 / 5) = 6.248, of which no table has t. Welch's test of
        # a difference at an end of the interval has p = 0.05.
        more, less = [6.0, 8.0, 10.0, 12.0, 14.0], [3.0, 4.0, 5.0, 6.0, 7.0, 8.0]
        found = statistics.difference(more, less)
        self.assert_interval(found, 4.5, 3.8953)
        for end in (found["low"], found["high"]):
            shifted = [value - end for value in more]
            self.assertAlmostEqual(stats.ttest_ind(shifted, less, equal_var=False).pvalue, 0.05)

    def test_groups_without_any_spread_have_a_point(self) -> None:
        self.assert_interval(statistics.difference([1.0, 1.0], [0.25, 0.25]), 0.75, 0.0)

    def test_one_value_on_a_side_has_no_interval(self) -> None:
        expected = {"mean": 1.5, "low": "", "high": ""}
        self.assertEqual(statistics.difference([3.0], [1.0, 2.0]), expected)
        self.assertEqual(statistics.difference([3.0, 4.0], [2.0]), expected)


class Crossed(unittest.TestCase):
    """Tables [policy, start] with a pattern that is none, as in crossed_test.cpp, whose figures are
    from another implementation of the formulas."""

    R, C = np.ogrid[:6, :20]
    UNEVEN = (7 * R * R + 3 * C + R * C * C) % 11 / 10.0 + 0.3 * R + 0.05 * C
    OTHER = (5 * R + 2 * C * C + 3 * R * C) % 13 / 10.0 + 1.0 + 0.1 * R

    def assert_ends(self, found: crossed.Interval, low: float, high: float) -> None:
        assert found
        self.assertAlmostEqual(found[0], low, places=7)  # SciPy's quantile of t has no more
        self.assertAlmostEqual(found[1], high, places=7)

    def test_rules_are_those_of_the_suite(self) -> None:
        self.assert_ends(crossed.mean_interval(self.UNEVEN), 1.071344194858661, 2.315322471808006)
        half = 0.22534171572304296
        self.assert_ends(crossed.mean_interval(self.OTHER), 1.8575 - half, 1.8575 + half)
        ratio = crossed.ratio_interval(self.UNEVEN, self.OTHER)
        self.assert_ends(ratio, 0.6537041010997111, 1.1163760938690812)
        inverse = crossed.ratio_interval(self.OTHER, self.UNEVEN)
        self.assert_ends(inverse, 1 / 1.1163760938690812, 1 / 0.6537041010997111)

    def test_a_ratio_over_a_constant_is_a_mean(self) -> None:
        ratio = crossed.ratio_interval(self.UNEVEN, np.full((6, 20), 2.0))
        self.assert_ends(ratio, 1.071344194858661 / 2, 2.315322471808006 / 2)

    def test_p_is_students(self) -> None:
        # Means of policies 1 to 5, the same at all starts: t = 3 / sqrt(2.5 / 5), 4 degrees.
        mean = crossed.mean_of(np.repeat(np.arange(1.0, 6.0)[:, None], 20, axis=1))
        self.assertAlmostEqual(mean.half_width, T[4] * math.sqrt(0.5), places=4)
        self.assertAlmostEqual(mean.p, 2 * stats.t.sf(3 / math.sqrt(0.5), 4))

    def test_no_interval_of_few_policies_or_where_nothing_varies(self) -> None:
        few, none = self.UNEVEN[:4], np.zeros((6, 20))
        self.assertIsNone(crossed.mean_interval(few))
        self.assertIsNone(crossed.ratio_interval(few, self.OTHER[:4]))
        self.assertIsNone(crossed.mean_interval(none + 0.5))
        self.assertTrue(math.isnan(crossed.mean_of(none).p))
        for numerators, denominators in (
            (none, self.OTHER),
            (self.OTHER, none),
            (self.OTHER, self.OTHER),
            (self.OTHER, np.where(self.R == 0, self.C % 2, 0.0)),  # its mean may be 0
        ):
            self.assertIsNone(crossed.ratio_interval(numerators, denominators))


class Holm(unittest.TestCase):
    def test_holm(self) -> None:
        for p, expected in (
            ([0.01, 0.04, 0.03], [0.03, 0.06, 0.06]),
            ([0.5, 0.6], [1.0, 1.0]),
            ([math.nan, 0.01], [1.0, 0.02]),
        ):
            for found, value in zip(statistics.holm(p), expected):
                self.assertAlmostEqual(found, value)


if __name__ == "__main__":
    unittest.main()
