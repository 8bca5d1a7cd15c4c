#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Tables of the study over policies, on small inputs whose figures follow by hand."""

import math
import unittest
from pathlib import Path
from typing import Any, Dict, List, Sequence, Tuple

from scipy import stats  # type: ignore[import]
from sim2sim_study import findings
from study_case import HEADING, StudyCase, T

POSITION, LOST = findings.LADDER_GAPS
Episode = Tuple[str, str, float, float]  # mode, success, errors in the end [m], [rad]


def failure(position: float, angle: float) -> Episode:
    return "reference_closed", "false", position, angle


NEAR = failure(0.05, 0.1)
FAR = failure(0.3, 0.1)
WON = ("reference_closed", "true", 0.01, 0.01)


def ladder(*policies: Sequence[float]) -> List[Dict[str, float]]:
    """Shares of the switches a, b, ... for each policy."""
    return [dict(zip("abcdefgh", shares)) for shares in policies]


class LadderRows(StudyCase):
    def test_shares_are_means_over_policies_and_all_are_the_gap(self) -> None:
        policies = ladder([0.25, 0.5], [0.75, 0.5])
        rows = findings._ladder_rows({("g", POSITION): policies, ("h", LOST): policies[:1]})
        self.assertEqual({(row.pop("p"), row.pop("adjusted_p")) for row in rows}, {("", "")})
        named = [(row.pop("group"), row.pop("gap"), row.pop("switch")) for row in rows]
        of = [("g", POSITION), ("h", LOST)]
        self.assertEqual(named, [(*key, switch) for key in of for switch in ("a", "b", "all")])
        self.assert_interval(rows[0], 0.5, T[1] * 0.25)
        self.assert_interval(rows[1], 0.5, 0.0)
        self.assert_interval(rows[2], 1.0, T[1] * 0.25)
        self.assertEqual(rows[5], {"mean": 0.75, "low": "", "high": ""})

    def test_groups_are_held_against_each_other(self) -> None:
        shares = {
            ("g", POSITION): ladder([0.25, 0.5], [0.75, 1.0]),
            ("g", LOST): ladder([0.0, 0.0]),
            ("h", POSITION): ladder([1.25, 0.0], [1.75, 0.5]),
        }
        rows = findings._ladder_rows(shares)[9:]
        named = [(row.pop("group"), row.pop("gap"), row.pop("switch")) for row in rows]
        self.assertEqual(named, [("h less g", POSITION, s) for s in ("a", "b", "all")])
        # Variances 1 / 8 each: standard error sqrt(1 / 8), 2 degrees of freedom, with which the
        # p of t is 1 - t / sqrt(2 + t^2): t is sqrt(8) and -sqrt(2).
        p = [row.pop("p") for row in rows][:2]
        self.assertAlmostEqual(p[0], 1 - math.sqrt(0.8))
        self.assertAlmostEqual(p[1], 1 - math.sqrt(0.5))
        adjusted = [row.pop("adjusted_p") for row in rows]  # of the switches, not of their sum
        self.assertAlmostEqual(adjusted[0], 2 * p[0])
        self.assertAlmostEqual(adjusted[1], p[1])
        self.assertEqual(adjusted[2], "")
        self.assert_interval(rows[0], 1.0, T[2] * math.sqrt(1 / 8))
        self.assert_interval(rows[1], -0.5, T[2] * math.sqrt(1 / 8))
        self.assertAlmostEqual(rows[2]["mean"], 0.5)


class LadderRanks(unittest.TestCase):
    def assert_rank(self, row: Dict[str, Any], name: str, count: int, w: float, p: float) -> None:
        self.assertEqual(row["policies of"], name)
        self.assertEqual(row["policies"], count)
        self.assertAlmostEqual(row["kendall_w"], w)
        self.assertAlmostEqual(row["p"], p)

    def rows(self, shares: "findings.Shares", gap: str = POSITION) -> List[Dict[str, Any]]:
        return [row for row in findings._ladder_ranks(shares) if row["gap"] == gap]

    def test_equal_rankings_have_one(self) -> None:
        # Chi-square is 3 * 2 * W = 6; with 2 degrees of freedom its p is exp(-6 / 2).
        policies = ladder([0.1, 0.2, 0.3], [1.0, 20.0, 21.0], [-3.0, -2.0, 7.0])
        for row, name in zip(self.rows({("g", POSITION): policies}), ("all", "g")):
            self.assert_rank(row, name, 3, 1.0, math.exp(-3.0))

    def test_mixed_rankings(self) -> None:
        # Ranks 123, 123, 132 have the sums 3, 7, 8 around 6: S = 14, and
        # W = 12 S / (3^2 (3^3 - 3)) = 7 / 9; chi-square is 3 * 2 * W = 14 / 3.
        policies = ladder([0.1, 0.2, 0.3], [0.0, 0.5, 0.6], [0.1, 0.9, 0.4])
        found = self.rows({("g", POSITION): policies})
        self.assert_rank(found[1], "g", 3, 7 / 9, math.exp(-7 / 3))

    def test_ties_share_their_ranks(self) -> None:
        # Ranks 123 and 1.5 1.5 3 have the sums 2.5, 3.5, 6 around 4: S = 6.5, and with the
        # correction for the tie W = 12 S / (2^2 (3^3 - 3) - 2 (2^3 - 2)) = 13 / 14.
        found = self.rows({("g", POSITION): ladder([0.1, 0.2, 0.3], [0.1, 0.1, 0.3])})
        self.assert_rank(found[0], "all", 2, 13 / 14, math.exp(-13 / 7))

    def test_all_policies_are_ranked_together_and_gaps_apart(self) -> None:
        shares = {
            ("up", POSITION): ladder([1.0, 2.0, 3.0], [1.0, 2.0, 3.0]),
            ("down", POSITION): ladder([3.0, 2.0, 1.0], [3.0, 2.0, 1.0]),
            ("up", LOST): ladder([1.0, 2.0, 3.0], [1.0, 2.0, 3.0]),
        }
        found = self.rows(shares)
        self.assertEqual(len(found), 3)
        self.assert_rank(found[0], "all", 4, 0.0, 1.0)
        self.assert_rank(found[1], "up", 2, 1.0, math.exp(-2.0))
        self.assert_rank(found[2], "down", 2, 1.0, math.exp(-2.0))
        found = self.rows(shares, LOST)
        self.assertEqual(len(found), 2)
        self.assert_rank(found[0], "all", 2, 1.0, math.exp(-2.0))

    def test_one_policy_or_two_switches_have_none(self) -> None:
        for policies in (ladder([0.1, 0.2, 0.3]), ladder([0.1, 0.2], [0.1, 0.2])):
            for row in self.rows({("g", POSITION): policies}):
                self.assertEqual(row["policies"], len(policies))
                self.assertTrue(math.isnan(row["kendall_w"]))
                self.assertTrue(math.isnan(row["p"]))


class Predictions(StudyCase):
    A, B, C = [6.0, 7, 8, 9, 10], [1.0, 2, 3, 4, 5], [6.0, 7, 8, 9, 11]

    def row(self, more: Sequence[float], less: Sequence[float], **asked: Any) -> Dict[str, Any]:
        found = {(s, "two_mass", "contact"): [*v] for s, v in (("more", more), ("less", less))}
        of = {"figure": "contact", "in": "two_mass", "more": "more", "less": "less", **asked}
        rows = findings._prediction_rows({"P1 all is well": of}, found)
        self.assertEqual(len(rows), 1)
        self.assertEqual((rows[0]["prediction"], rows[0]["says"]), ("P1", "all is well"))
        return rows[0]

    def test_groups_of_other_trainings_have_welchs_interval(self) -> None:
        row = self.row(self.A, self.B, side="above")
        self.assert_interval({key: row[key] for key in ("mean", "low", "high")}, 5.0, T[8])
        self.assertAlmostEqual(row["p"], 2 * stats.t.sf(5.0, 8))
        self.assertEqual(row["verdict"], "holds")

    def test_the_same_trainings_have_the_interval_of_their_differences(self) -> None:
        # Differences 5, 5, 5, 5, 6: variance 0.2, standard error 0.2.
        row = self.row(self.C, self.B, side="above", paired=True)
        self.assert_interval({key: row[key] for key in ("mean", "low", "high")}, 5.2, T[4] * 0.2)
        self.assertAlmostEqual(row["p"], 2 * stats.t.sf(26.0, 4))

    def test_verdicts(self) -> None:
        for more, less, side, verdict in (
            (self.A, self.B, "above", "holds"),
            (self.A, self.B, "below", "contradicted"),
            (self.B, self.A, "below", "holds"),
            (self.A, self.C, "below", "not shown"),
            ([1.0], [2.0], "below", "not shown"),
        ):
            with self.subTest((more, less, side)):
                self.assertEqual(self.row(more, less, side=side)["verdict"], verdict)

    def test_many_predictions_count(self) -> None:
        """One that is significant alone is not shown beside seven others."""
        found = {
            ("more", "two_mass", "contact"): [1.0, 2.0, 3.0, 4.0, 5.0],
            ("less", "two_mass", "contact"): [-1.5, -0.5, 0.5, 1.5, 2.5],
        }
        asked = {"figure": "contact", "in": "two_mass", "more": "more", "less": "less"}
        for count, verdict in ((1, "holds"), (8, "not shown")):
            of = {f"P{i} x": {**asked, "side": "above"} for i in range(count)}
            rows = findings._prediction_rows(of, found)
            self.assertLess(rows[0]["p"], 0.05)
            self.assertEqual([row["verdict"] for row in rows], count * [verdict])


class RankingRows(unittest.TestCase):
    def ranking(self, reference: int, test: int, kendall: float) -> Dict[str, Any]:
        return {
            "reference": reference,
            "test": test,
            "policy_count": 9,
            "kendall": {"value": kendall, "interval": [-0.25, 0.75]},
            "spearman": {"value": 0.5, "interval": None},
            "pearson": {"value": None, "interval": None},
            "mean_maximum_rank_violation": {"value": 0.125, "interval": [0.0, 0.25]},
            "agreement": [
                {"from": 0.0, "to": 0.05, "pairs": 0, "value": None, "interval": None},
                {"from": 0.2, "to": 1.0, "pairs": 21, "value": 0.75, "interval": [0.5, 1.0]},
            ],
        }

    def test_rows_are_the_rankings_beside_the_home(self) -> None:
        matrix = {
            "simulators": [{"name": "chipmunk"}, {"name": findings.HOME}, {"name": "two_mass"}],
            "rankings": [self.ranking(0, 1, 0.1), self.ranking(1, 2, 0.2), self.ranking(1, 0, 0.3)],
        }
        rows = list(findings._ranking_rows(matrix))
        bins = [
            f"better in both, success differs by {ends}" for ends in ("0.0 to 0.05", "0.2 to 1.0")
        ]
        expected = [
            ("kendall", "", 0.2, -0.25, 0.75),
            ("spearman", "", 0.5, "", ""),
            ("pearson", "", None, "", ""),
            ("mean_maximum_rank_violation", "", 0.125, 0.0, 0.25),
            (bins[0], 0, None, "", ""),
            (bins[1], 21, 0.75, 0.5, 1.0),
        ]
        keys = ("figure", "pairs", "value", "value_low", "value_high")
        self.assertEqual([tuple(row[key] for key in keys) for row in rows[:6]], expected)
        self.assertEqual([row["there"] for row in rows], 6 * ["two_mass"] + 6 * ["chipmunk"])
        self.assertEqual(rows[6]["value"], 0.3)
        self.assertEqual({row["policies"] for row in rows}, {9})


class VariantRows(StudyCase):
    def test_success_is_held_against_that_at_home(self) -> None:
        # Differences of success: 0, 0.5 and 0.25; outcomes alike: 0.5, 0.5 and 0.75.
        outcomes = (("a", "1010", "1001"), ("a", "1100", "0000"), ("b", "1111", "0111"))
        matrix = {
            "simulators": [{"name": "elliptic"}, {"name": findings.HOME}],
            "policies": [
                {"group": group, "cells": [{"success_by_episode": s} for s in cells]}
                for group, *cells in outcomes
            ],
        }
        rows = {(r.pop("figure"), r.pop("policies of")): r for r in findings._variant_rows(matrix)}
        for key, count, mean, half in (
            (("success_difference", "all"), 3, 0.25, T[2] * math.sqrt(1 / 48)),
            (("success_difference", "a"), 2, 0.25, T[1] * 0.25),
            (("alike", "all"), 3, 7 / 12, T[2] / 12),
            (("alike", "a"), 2, 0.5, 0.0),
        ):
            row = rows.pop(key)
            self.assertEqual((row.pop("simulator"), row.pop("policies")), ("elliptic", count))
            self.assert_interval(row, mean, half)
        self.assertEqual(rows["success_difference", "b"]["mean"], 0.25)
        self.assertEqual(set(rows), {("success_difference", "b"), ("alike", "b")})


class FailureCase(StudyCase):
    def write(self, row: str, *episodes: Episode) -> Path:
        """Episodes of a row of the sweep."""
        folder = self.folder / "matrix" / row
        folder.mkdir(parents=True, exist_ok=True)
        lines = [",".join(map(str, (i, *episode))) for i, episode in enumerate(episodes)]
        (folder / "episodes.csv").write_text("\n".join([HEADING, *lines]) + "\n")
        return folder


class NearShare(FailureCase):
    def test_failures_within_both_bounds_are_near(self) -> None:
        position, angle = findings.NEAR
        self.assertEqual((position, angle), (0.1, 0.2))
        for near, expected in (
            (failure(0.1, 0.2), 0.5),  # at the bounds
            (failure(0.1001, 0.0), 0.0),
            (failure(0.0, 0.2001), 0.0),
        ):
            with self.subTest(near):
                self.assertEqual(findings._near_share(self.write("rows/0", near, FAR)), expected)

    def test_only_failures_in_the_reference_count(self) -> None:
        others = [(mode, "false", 0.0, 0.0) for mode in ("engine_closed", "engine_replay")]
        folder = self.write("rows/0", NEAR, *others, FAR, WON, FAR, WON, FAR)
        self.assertEqual(findings._near_share(folder), 0.25)

    def test_a_policy_without_failures_has_none(self) -> None:
        folder = self.write("rows/0", WON, ("engine_closed", "false", 0.0, 0.0), WON)
        self.assertIsNone(findings._near_share(folder))


class FailureRows(FailureCase):
    PLAN = {"failures": {"more": "small", "less": "big"}}

    def matrix(self, groups: Dict[str, List[List[Episode]]], away: Sequence[str] = ()) -> Any:
        """Matrix with the home as its second simulator. Policies of the groups `away` have another
        reference, but a cell at home all the same."""
        policies: List[Dict[str, Any]] = []
        listed: List[Dict[str, Any]] = []
        for name, members in groups.items():
            listed.append({"group": name, "policies": []})
            for episodes in members:
                row = f"rows/{len(policies):03}"
                self.write(row, *episodes)
                listed[-1]["policies"].append(len(policies))
                reference = 0 if name in away else 1
                policies.append({"reference": reference, "cells": [None, {"row": row}]})
        simulators = [{"name": "chipmunk"}, {"name": findings.HOME}]
        return {"simulators": simulators, "policies": policies, "groups": listed}

    def rows(self, matrix: Any) -> Dict[str, Dict[str, Any]]:
        return {
            row.pop("group"): row for row in findings._failure_rows(self.PLAN, matrix, self.folder)
        }

    def test_shares_are_means_over_policies(self) -> None:
        # Shares 1, 0.5 and 0.75; 0, 0.5 and 0.25, besides a policy that never fails. Each group has
        # the variance 1 / 16, hence 1 / 48 for its mean, and Welch's degrees of freedom are 4.
        matrix = self.matrix(
            {
                "big": [[FAR], [NEAR, FAR, WON], [WON, WON], [FAR, FAR, NEAR, FAR]],
                "other": [[NEAR]],
                "small": [[NEAR], [NEAR, FAR], [NEAR, NEAR, FAR, NEAR]],
            },
            away=["other"],
        )
        rows = self.rows(matrix)
        self.assertEqual(list(rows), ["big", "small", "small less big"])
        self.assertEqual([row.pop("policies") for row in rows.values()], [3, 3, 6])
        self.assert_interval(rows["big"], 0.25, T[2] * math.sqrt(1 / 48))
        self.assert_interval(rows["small"], 0.75, T[2] * math.sqrt(1 / 48))
        self.assert_interval(rows["small less big"], 0.5, T[4] * math.sqrt(1 / 24))

    def test_a_group_that_never_fails_has_no_row(self) -> None:
        rows = self.rows(self.matrix({"small": [[NEAR], [FAR]], "big": [[WON], [WON]]}))
        self.assertEqual(list(rows), ["small"])

    def test_one_policy_that_fails_has_no_interval(self) -> None:
        rows = self.rows(self.matrix({"small": [[NEAR], [WON]], "big": [[FAR], [NEAR]]}))
        self.assertEqual(rows["small"], {"policies": 1, "mean": 1.0, "low": "", "high": ""})
        expected = {"policies": 3, "mean": 0.5, "low": "", "high": ""}
        self.assertEqual(rows["small less big"], expected)

    def test_groups_of_another_reference_have_no_row(self) -> None:
        matrix = self.matrix({"small": [[NEAR], [FAR]], "big": [[FAR], [NEAR]]}, away=["big"])
        self.assertEqual(list(self.rows(matrix)), ["small"])


if __name__ == "__main__":
    unittest.main()
