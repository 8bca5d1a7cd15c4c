#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Figures of pushes, and what orders engines."""

import math
import unittest
from typing import Any

import numpy as np
import sim2sim
from sim2sim_study import predictions, push_hypotheses, pushes
from sim2sim_study.parts import whole_plan
from study_case import StudyCase


def state(x: float, y: float, yaw: float) -> Any:
    values = dict.fromkeys(sim2sim.STATE_FIELDS, 0.0)
    values.update(tee_x=x, tee_y=y, tee_yaw=yaw)
    return [values[name] for name in sim2sim.STATE_FIELDS]


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
        plan = whole_plan()["pushes"]
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
            recipes.append(push_hypotheses.Sums(values, counts, lost))
        return {one.name.split()[0]: one.verdict for one in push_hypotheses.judge(recipes, 300)}

    def test_what_orders_engines_is_found(self) -> None:
        by_direction = self.judged("direction")
        self.assertEqual((by_direction["P1"], by_direction["P2"]), ("holds", "not shown"))
        by_error = self.judged("position_error")
        self.assertEqual((by_error["P1"], by_error["P2"]), ("contradicted", "contradicted"))
        self.assertEqual(by_error["P3"], "contradicted", "they cost a half")
        by_weakness = self.judged("weak")
        self.assertEqual(by_weakness["P4"], "holds")

    def test_the_reference_answers_its_own_pushes(self) -> None:
        rollouts = pushes.roll_out(sim2sim.load_policy("expert"), [400_000, 400_001])
        made = pushes.pushes_in(rollouts, 5, 0.002)
        self.assertGreater(len(made.start), 5)
        found = pushes.figures_of(made, pushes.Engine("mujoco").answers(made))
        self.assertLess(found["position_error"].max(), 1e-6, "contacts are found to 1e-6 m")

    def test_a_comparison_has_the_same_figures(self) -> None:
        seeds = range(10_000, 10_004)
        results = sim2sim.compare("expert", episodes=len(seeds), floor=False, reanchor=[1, 5])
        rollouts = pushes.roll_out(sim2sim.load_policy("expert"), seeds)
        columns = {
            "missed": "pushes_missed_share",
            "other_way": "pushes_turned_share",
            "direction": "push_direction_error_rad",
            "size": "push_size_log",
        }
        for window in (1, 5):
            made = pushes.pushes_in(rollouts, window, 0.0004 * window)
            found = pushes.figures_of(made, pushes.Engine("two_mass").answers(made))
            found["direction"] = np.radians(found["direction"])
            rows = results.episodes["mode"] == f"engine_reanchored_{window}"
            for figure, column in columns.items():
                means = [np.nanmean(found[figure][made.episode == i]) for i in range(len(seeds))]
                measured = results.episodes[column][rows]
                np.testing.assert_allclose(measured, means, atol=1e-6, err_msg=column)
            self.assertGreater(found["missed"].mean(), 0.0, "they are not all alike")


STILL = np.tile(state(0.3, 0.2, 0.1), (7, 2, 1))  # states of two episodes


class Tables(StudyCase):
    """Pushes of two policies in two engines, from three starts."""

    def test_sums_by_start_have_what_the_hypotheses_need(self) -> None:
        path = self.folder / "pushes.csv.xz"
        found = {
            "folder/small-104.ts.pt": {
                engine: {
                    "episode": np.array([0, 2, 2]),
                    **{name: np.array([0.25, 0.5, size]) for name in pushes.FIGURES},
                    "missed": np.array([0.0, 1.0, 0.0]),
                    "other_way": np.array([1.0, np.nan, 0.0]),
                }
                for engine, size in (("a", 1.0), ("b:c=1", 3.0))
            }
        }
        pushes.write_sums(path, found, 3)
        table = push_hypotheses.read_sums(path)
        self.assertEqual(table["small-104", "a", "pushes"].tolist(), [1.0, 0.0, 2.0])
        self.assertEqual(table["small-104", "b:c=1", "weak"].tolist(), [0.25, 0.0, 3.5])
        sums = push_hypotheses.sums_of(table, np.zeros((1, 2, 3)), ["small-104"], ["a", "b:c=1"])
        policies, all_starts = np.array([0]), np.ones(3)

        def mean(figure: str, weights: Any) -> Any:
            return sums.mean(figure, policies, np.array(weights)).tolist()

        self.assertEqual(mean("size", all_starts), [1.75 / 3, 3.75 / 3])
        self.assertEqual(mean("size", [0.0, 1.0, 2.0]), [0.75, 1.75])
        self.assertEqual(mean("missed", all_starts), [1 / 3, 1 / 3])
        self.assertEqual(mean("other_way", all_starts), [0.5, 0.5], "of those that are not missed")

    def test_a_policy_may_push_nothing(self) -> None:
        none = pushes.pushes_in(
            pushes.Rollouts(STILL, np.zeros((6, 2, 2)), np.array([6, 6])), 5, 0.1
        )
        ends = pushes.Engine("two_mass").answers(none)
        self.assertEqual(ends.shape, (0, len(sim2sim.STATE_FIELDS)))
        figures = {"episode": none.episode, **pushes.figures_of(none, ends)}
        found = {5: {"still.ts.pt": {"two_mass": figures}}}
        pushes.write_pushes(self.folder / "pushes.csv", found)
        pushes.write_sums(self.folder / "pushes.csv.xz", found[5], 2)
        table = push_hypotheses.read_sums(self.folder / "pushes.csv.xz")
        self.assertEqual(table["still", "two_mass", "pushes"].tolist(), [0.0, 0.0])
        numbers = predictions.read_numbers(self.folder / "pushes.csv", ["still"], ["two_mass"])
        rows = list(predictions.prediction_rows(numbers, np.array([0.5])))
        self.assertEqual({row["kendall_tau"] for row in rows}, {None})

    def test_numbers_are_means_over_policies(self) -> None:
        path = self.folder / "pushes.csv"
        lines = [",".join(["window", "policy", "engine", "pushes", *pushes.FIGURES])]
        for policy, value in (("small-104", 1), ("small-105", 2), ("other-104", 9)):
            for window in (1, 5):
                for engine, more in (("a", 0), ("b", 4)):
                    values = ",".join(6 * [str(window * (value + more))])
                    lines.append(f"{window},{policy}.ts.pt,{engine},7,{values}")
        path.write_text("\n".join(lines) + "\n")
        found = predictions.read_numbers(path, ["small-104", "small-105"], ["b", "a"])
        self.assertEqual(len(found), 12)
        self.assertEqual(found["weak_5"].tolist(), [27.5, 7.5])
        self.assertEqual(found["size_1"].tolist(), [5.5, 1.5])


class Predictions(unittest.TestCase):
    def test_each_engine_is_predicted_from_the_others(self) -> None:
        # Left out one by one: the lines through the two others predict -3, 1.5 and 0.
        ranks, lost = np.array([1.0, 2.0, 3.0]), np.array([0.0, 0.0, 3.0])
        self.assertAlmostEqual(predictions.left_out_error([ranks], lost), (3 + 1.5 + 3) / 3)
        # And their means 1.5, 1.5 and 0.
        self.assertAlmostEqual(predictions.left_out_error([], lost), (1.5 + 1.5 + 3) / 3)

    def test_the_best_of_each_size_is_first(self) -> None:
        lost = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0])
        numbers = {
            "even": np.array([1.0, 2.0, 2.5, 7.0, 8.0, 99.0]),  # in the order of what is lost
            "back": -lost,
            "mixed": np.array([3.0, 1.0, 2.0, 2.0, 9.0, 0.0]),
            "gone": np.array([np.nan, 1.0, 2.0, 2.0, 9.0, 0.0]),
        }
        rows = list(predictions.prediction_rows(numbers, lost))
        self.assertEqual([row["size"] for row in rows], ["none", *4 * ["number"], *3 * ["pair"]])
        self.assertEqual({row["numbers"] for row in rows[1:3]}, {"even", "back"})
        self.assertAlmostEqual(rows[2]["mean_absolute_error"], 0.0)
        self.assertEqual((rows[4]["numbers"], rows[4]["mean_absolute_error"]), ("gone", None))
        taus = {row["numbers"]: row["kendall_tau"] for row in rows if row["size"] == "number"}
        self.assertEqual((taus["even"], taus["back"]), (1.0, -1.0))
        # An order have 14 of 15 pairs: 6 as what is lost, 8 the other way round.
        self.assertAlmostEqual(taus["mixed"], -2 / math.sqrt(14 * 15), places=5)
        self.assertIsNone(rows[0]["kendall_tau"])

    def test_two_numbers_may_do_what_one_does_not(self) -> None:
        generator = np.random.default_rng(2)
        a, b, other = (generator.permutation(12).astype(float) for _ in range(3))
        lost = 0.02 * a - 0.05 * b
        rows = list(predictions.prediction_rows({"a": a, "b": b, "other": other}, lost))
        best = {row["size"]: row for row in reversed(rows)}
        self.assertEqual(best["number"]["numbers"], "b")
        self.assertEqual(best["pair"]["numbers"], "a + b")
        self.assertAlmostEqual(best["pair"]["mean_absolute_error"], 0.0)
        self.assertLess(best["number"]["mean_absolute_error"], best["none"]["mean_absolute_error"])


if __name__ == "__main__":
    unittest.main()
