#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What policies do, from traces whose figures follow by hand."""

import math
import unittest
from pathlib import Path
from typing import Any, Sequence, Tuple

import numpy as np
from pusht_task import task
from sim2sim_study import conduct, findings
from study_case import HEADING, StudyCase

TRACE = [("episode", "<i4"), ("mode", "S16"), ("step", "<i4")]
TRACE += [(name, "<f8") for name in ("pusher_x", "pusher_y", "tee_x", "tee_y", "tee_yaw")]
TRACE += [(name, "<f4") for name in ("action_x", "action_y")]
Point = Tuple[float, float]


def trace(pushers: Sequence[Point], actions: Sequence[Point] = (), **fields: Any) -> Any:
    """States with the pusher at points of the tee's frame [m]. The tee lies anywhere."""
    x, y, yaw = 0.1, -0.2, 2.5
    records = np.zeros(len(pushers), dtype=TRACE)
    records["step"] = np.arange(len(pushers))
    records["tee_x"], records["tee_y"], records["tee_yaw"] = x, y, yaw
    along, across = np.array(pushers).T
    records["pusher_x"] = x + math.cos(yaw) * along - math.sin(yaw) * across
    records["pusher_y"] = y + math.sin(yaw) * along + math.cos(yaw) * across
    records["action_x"] = records["action_y"] = math.nan
    for i, action in enumerate(actions):
        records["action_x"][i], records["action_y"][i] = action
    for name, value in fields.items():
        records[name] = value
    return records


class Gap(unittest.TestCase):
    def assert_gap(self, gap: Any, point: Point, expected: float) -> None:
        with self.subTest(point):
            self.assertAlmostEqual(float(gap(trace([point]))[0]), expected)

    def test_boxes(self) -> None:
        radius = task.PUSHER_RADIUS
        self.assert_gap(conduct.box_gap, (0.04, 0.015 + radius + 0.002), 0.002)  # above the bar
        self.assert_gap(conduct.box_gap, (-0.06 - radius - 0.003, 0.0), 0.003)  # beside it
        self.assert_gap(conduct.box_gap, (0.06 + 0.03, 0.015 + 0.04), 0.05 - radius)  # off a corner
        self.assert_gap(conduct.box_gap, (0.0, -0.105 - radius - 0.004), 0.004)  # below the stem
        self.assert_gap(conduct.box_gap, (0.015 + radius, -0.08), 0.0)  # touches its side
        self.assert_gap(conduct.box_gap, (0.0, 0.01), -0.005 - radius)  # inside the bar

    def test_discs(self) -> None:
        radius = task.PUSHER_RADIUS
        self.assert_gap(conduct.disc_gap, (0.0, 0.032 + radius + 0.002), 0.002)
        self.assert_gap(conduct.disc_gap, (0.03, 0.04), 0.05 - 0.032 - radius)
        self.assert_gap(conduct.disc_gap, (0.026 + radius + 0.003, -0.06), 0.003)
        self.assert_gap(conduct.disc_gap, (0.0, -0.06 - 0.026), -radius)  # center on the stem's rim


FAR_OFF, AT_BOX, AT_DISC = (0.3, 0.3), (0.0, 0.0309), (0.0, 0.0479)  # gaps of 0.9 mm


class Conduct(StudyCase):
    def test_contact_is_the_share_of_the_ends_of_steps(self) -> None:
        # The first and the last of four control steps end in contact; the initial state is no end.
        states = trace([AT_BOX, AT_BOX, FAR_OFF, FAR_OFF, AT_BOX])
        self.assertEqual(conduct.contact(states, conduct.box_gap), 0.5)
        self.assertEqual(conduct.contact(trace([AT_BOX, FAR_OFF]), conduct.box_gap), 0.0)
        # The tee's shape is that of the simulator; 1.1 mm are no contact.
        self.assertEqual(conduct.contact(trace(2 * [AT_DISC]), conduct.box_gap), 0.0)
        self.assertEqual(conduct.contact(trace(2 * [AT_DISC]), conduct.disc_gap), 1.0)
        self.assertEqual(conduct.contact(trace(2 * [(0.0, 0.0311)]), conduct.box_gap), 0.0)

    def test_sharpness_is_the_mean_change_of_the_action(self) -> None:
        # Changes of 0.5, 0 and 0.25 m/s.
        actions = [(0.3, 0.0), (0.0, 0.4), (0.0, 0.4), (0.25, 0.4)]
        self.assertAlmostEqual(conduct.sharpness(trace(5 * [FAR_OFF], actions)), 0.25)

    def test_only_the_first_five_seconds_count(self) -> None:
        self.assertEqual(conduct.STEPS * task.CONTROL_STEP, 5.0)
        pushers = [FAR_OFF] + 25 * [AT_BOX] + 25 * [FAR_OFF] + 50 * [AT_BOX]
        actions = 50 * [(0.5, 0.0)] + 25 * [(0.0, 0.0), (1.0, 0.0)]
        self.assertEqual(conduct.contact(trace(pushers), conduct.box_gap), 0.5)
        self.assertEqual(conduct.sharpness(trace(pushers, actions)), 0.0)
        actions[49] = (0.5, 0.49)  # the last of them; 49 changes
        self.assertAlmostEqual(conduct.sharpness(trace(pushers, actions)), 0.01)

    def run_of(self, name: str, changes: Sequence[float]) -> Path:
        """A run of an episode for each change, won at home from the second on. Its policy changes
        its action once: at home by as much, in the engine by twice."""
        folder = self.folder / name
        folder.mkdir(parents=True)
        records, rows = [], []
        for i, change in enumerate(changes):
            for mode, factor in (
                ("reference_closed", 1),
                ("engine_closed", 2),
                ("engine_replay", 9),
            ):
                pushers = [FAR_OFF, FAR_OFF, AT_DISC if factor == 2 else AT_BOX]
                actions = [(0.0, 0.0), (0.0, factor * change)]
                records.append(trace(pushers, actions, episode=i, mode=mode.encode()))
                rows.append((mode, "true" if i and factor == 1 else "false", 0.0, 0.0))
        np.save(folder / "traces.npy", np.concatenate(records))
        lines = [",".join(map(str, (i // 3, *row))) for i, row in enumerate(rows)]
        (folder / "episodes.csv").write_text("\n".join([HEADING, *lines]) + "\n")
        return folder

    def test_conduct_of_a_policy_is_a_mean_over_episodes(self) -> None:
        found = conduct.policy_conduct(self.run_of("run", [0.125, 0.25, 0.0, 0.125]), "two_mass")
        expected = {
            ("mujoco", "contact"): 0.5,
            ("mujoco", "sharpness"): 0.125,
            ("mujoco", "success"): 0.75,
            ("two_mass", "contact"): 0.5,
            ("two_mass", "sharpness"): 0.25,
            ("two_mass", "success"): 0.0,
        }
        self.assertEqual(found, expected)

    def test_explored_trainings_are_kept_apart(self) -> None:
        plan = {
            "first_seed": 100,
            "groups": {"small": {"seeds": 3}, "big": {"seeds": 2}},
            "conduct": {
                "groups": ["small", "after-60-big"],
                "slower": {"group": "big", "factor": 0.5},
                "engine": "two_mass",
                "explored": 1,
            },
        }
        names = [name for _, _, name in conduct.conduct_runs(plan)]
        expected = ["small-100", "small-101", "small-102", "after-60-big-100", "after-60-big-101"]
        self.assertEqual(names, [*expected, "slower-big-100", "slower-big-101"])
        for i, name in enumerate(names):
            self.run_of(f"conduct/{name}", [i / 8])
        explored, tested = findings._conduct(plan, self.folder)
        self.assertEqual(explored["small", "two_mass", "sharpness"], [0.0])
        self.assertEqual(tested["small", "two_mass", "sharpness"], [0.25, 0.5])
        self.assertEqual(tested["slower-big", "mujoco", "sharpness"], [0.75])

    def test_slower_policy(self) -> None:
        import torch  # here, as it takes seconds

        class Double(torch.nn.Module):  # type: ignore[misc]
            def forward(self, observations: torch.Tensor) -> torch.Tensor:
                return observations[:, :2] * 2.0

        policy, slower = self.folder / "policy.pt", self.folder / "slower.pt"
        torch.jit.save(torch.jit.script(Double()), str(policy))
        conduct.write_slower(policy, slower, 0.75)
        observations = torch.tensor([[0.25, -0.5, 9.0], [4.0, -0.125, 9.0]])
        actions = torch.jit.load(str(slower))(observations)
        self.assertEqual(
            actions.tolist(), [[0.375, -0.75], [0.75, -0.1875]]
        )  # clipped, then slower


if __name__ == "__main__":
    unittest.main()
