#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Hypotheses on success under noise, in tables in which the truth is known."""

import unittest
from typing import Any

import numpy as np
from sim2sim_study import hypotheses
from sim2sim_study.endings import Cell, Endings, Table


class Hypotheses(unittest.TestCase):
    """Tables in which the truth is known."""

    STARTS = 120

    def table(self, rate: Any, stuck: float = 0.9, step: float = 0.02) -> Table:
        """Endings of independent episodes, of which rate(group, loop, simulator) succeed, and
        `step` more with each training seed."""
        generator = np.random.default_rng(5)
        recipes = ("small", "shipped")
        seeds = {f"{recipe}-mujoco": range(100, 108) for recipe in recipes}
        for number in range(1, 6):
            first = 100 + 10 * number
            seeds.update({f"{r}-draw_{number}": range(first, first + 3) for r in recipes})
        seeds.update({f"epochs_{e}-width_{w}": range(100, 105) for e, w in ((60, 512), (600, 256))})
        simulators = (
            "mujoco",
            "two_mass",
            "chipmunk",
            "box2d",
            "bullet",
            "bullet:preset=idiomatic",
        )
        table = {}
        for group, numbers in seeds.items():
            for loop in ("none", "tracker"):
                for simulator in simulators:
                    for seed in numbers:
                        p = rate(group, loop, simulator) + step * (seed % 5 - 2)
                        draw = generator.random((2, self.STARTS))
                        failed = np.where(draw[1] < stuck, "t", "m")
                        cell = Cell("primary", group, f"{group}-{seed}", loop, simulator)
                        table[cell] = "".join(np.where(draw[0] < p, "S", failed))
        return table

    def verdicts(self, table: Table) -> Any:
        found = hypotheses.judge(Endings(table))
        self.assertEqual([int(one.name.split()[0][1:]) for one in found], list(range(1, 18)))
        return {one.name.split()[0]: one.verdict for one in found}

    def test_what_is_so_is_found(self) -> None:
        def rate(group: str, loop: str, simulator: str) -> float:
            home = 0.7 if loop == "tracker" else 0.4
            if simulator == "two_mass":
                home -= 0.5 if "shipped" in group else 0.3
            return home - (0.3 if "idiomatic" in simulator else 0.0)

        verdicts = self.verdicts(self.table(rate))
        for number in (7, 8, 9, 10, 11, 12, 14, 15, 16, 17):
            self.assertEqual(verdicts[f"N{number}"], "holds", number)

    def test_the_other_way_is_contradicted(self) -> None:
        def rate(group: str, loop: str, simulator: str) -> float:
            home = 0.3 if loop == "tracker" else 0.6
            return home + (0.3 if simulator != "mujoco" else 0.0)

        verdicts = self.verdicts(self.table(rate, stuck=0.1))
        for number in (*range(1, 10), *range(14, 18)):
            self.assertEqual(verdicts[f"N{number}"], "contradicted", number)

    def test_what_is_not_there_is_not_shown(self) -> None:
        verdicts = self.verdicts(self.table(lambda *_: 0.5, stuck=0.5))
        for number in (7, 8, 9, 10, 11, 12, 14, 15, 16, 17):
            self.assertEqual(verdicts[f"N{number}"], "not shown", number)

    def test_ranks_are_of_the_same_policies(self) -> None:
        found = hypotheses.tau_within_recipes(Endings(self.table(lambda *_: 0.5, step=0.15)))
        self.assertEqual(found.verdict, "holds", "success grows with the seed, in both")

    def test_what_was_not_run_is_said(self) -> None:
        """Without new draws and schedules; the family stays one of ten."""
        whole = self.table(lambda *_: 0.5, step=0.0)
        groups = ("small-mujoco", "shipped-mujoco")
        some = {cell: ends for cell, ends in whole.items() if cell.group in groups}
        found = {one.name.split()[0]: one for one in hypotheses.judge(Endings(some))}
        missing = {name for name, one in found.items() if one.verdict == "not run"}
        self.assertEqual(missing, {"N10", "N11", "N12", "N13"})
        self.assertTrue(np.isnan(found["N10"].estimate))
        smallest = min(one.p for one in found.values() if one.p == one.p)
        self.assertAlmostEqual(
            min(one.adjusted for one in found.values() if one.adjusted == one.adjusted),
            min(1.0, 10 * smallest),
        )


if __name__ == "__main__":
    unittest.main()
