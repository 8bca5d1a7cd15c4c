#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Figures of pushes, and what orders engines."""

import unittest
from typing import Any

import numpy as np
from sim2sim import STATE_FIELDS
from sim2sim_study import noise, pushes


def state(x: float, y: float, yaw: float) -> Any:
    values = dict.fromkeys(STATE_FIELDS, 0.0)
    values.update(tee_x=x, tee_y=y, tee_yaw=yaw)
    return [values[name] for name in STATE_FIELDS]


class Pushes(unittest.TestCase):
    def figures(self, reference: Any, engine: Any) -> Any:
        """Figures of one push that begins in the middle of the table."""
        start, end = np.array([state(0.0, 0.0, 0.0)]), np.array([state(*reference)])
        made = pushes.Pushes(np.zeros(1, int), start, np.zeros((1, 5, 2)), end)
        found = pushes.figures_of(made, np.array([state(*engine)]))
        return {name: float(values[0]) for name, values in found.items()}

    def test_the_same_answer(self) -> None:
        same = self.figures((0.01, 0.0, 0.2), (0.01, 0.0, 0.2))
        for name in ("position_error", "missed", "other_way", "direction", "size", "weak"):
            self.assertAlmostEqual(same[name], 0.0, places=5, msg=name)

    def test_other_answers(self) -> None:
        back = self.figures((0.01, 0.0, 0.0), (-0.02, 0.0, 0.0))
        self.assertEqual((back["missed"], back["other_way"]), (0.0, 1.0))
        self.assertAlmostEqual(back["direction"], 180.0)
        self.assertAlmostEqual(back["size"], np.log(2.0))
        self.assertAlmostEqual(back["position_error"], 0.03)
        missed = self.figures((0.01, 0.0, 0.0), (0.0, 0.002, 0.0))
        self.assertEqual((missed["missed"], missed["direction"]), (1.0, 90.0))
        self.assertTrue(np.isnan(missed["other_way"]))
        self.assertAlmostEqual(missed["weak"], 0.8)

    def test_a_turn_about_the_center_of_mass_moves_it_nowhere(self) -> None:
        center = 0.06 * 0.045 / 0.105  # [m] along body -y
        turned = (-center * np.sin(0.5), -center + center * np.cos(0.5), 0.5)
        move = pushes.displacement(np.zeros(3), np.array(turned))
        np.testing.assert_allclose(move, [0.0, 0.0, 0.022], atol=1e-12)

    def test_engines_are_drawn_once_and_no_two_are_alike(self) -> None:
        plan = noise.whole_plan()["pushes"]
        engines = pushes.population(plan)
        self.assertEqual(len(set(engines)), 39)
        self.assertEqual(engines, pushes.population(plan))
        self.assertFalse(set(engines) & set(plan["seen"]))

    def judged(self, lost_by: str) -> Any:
        """Forty engines whose lost success is one of the figures, with noise of starts."""
        generator = np.random.default_rng(3)
        engines, shape = np.linspace(0.0, 1.0, 40), (4, 40, 100)
        figures = {name: generator.permutation(engines) for name in pushes.FIGURES}
        figures["size"] = np.where(figures["weak"] > 0.5, -0.2, 0.2)
        recipes = []
        for _ in range(2):
            spread = generator.normal(0.0, 0.1, shape)
            lost = figures[lost_by][None, :, None] + generator.normal(0.0, 0.5, shape)
            values = {name: y[None, :, None] + spread for name, y in figures.items()}
            counts = {name: np.ones(shape) for name in figures}
            recipes.append(pushes.Sums(values, counts, lost))
        return {one.name.split()[0]: one.verdict for one in pushes.judge(recipes, 300)}

    def test_what_orders_engines_is_found(self) -> None:
        by_direction = self.judged("direction")
        self.assertEqual((by_direction["P1"], by_direction["P2"]), ("holds", "not shown"))
        by_error = self.judged("position_error")
        self.assertEqual((by_error["P1"], by_error["P2"]), ("contradicted", "contradicted"))
        self.assertEqual(by_error["P3"], "contradicted", "they cost a half")
        by_weakness = self.judged("weak")
        self.assertEqual(by_weakness["P4"], "holds")

    def test_the_reference_answers_its_own_pushes(self) -> None:
        import sim2sim

        rollouts = pushes.roll_out(sim2sim.load_policy("expert"), [400_000, 400_001])
        made = pushes.pushes_in(rollouts, 5, 0.002)
        self.assertGreater(len(made.start), 5)
        found = pushes.figures_of(made, pushes.answers("mujoco", made))
        self.assertLess(found["position_error"].max(), 1e-6, "contacts are found to 1e-6 m")


if __name__ == "__main__":
    unittest.main()
