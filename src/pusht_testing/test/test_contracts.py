#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What the suites in Python say of what they test, and the task against the golden vectors."""

import contextlib
import json
import tempfile
import unittest
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import rosunit  # type: ignore[import]
from pusht_msgs.srv import StepResponse  # type: ignore[import]

from pusht_task.task import spawn
from pusht_testing import own_simulator_contract, simulator_contract
from pusht_testing.nodes import SKIPPED, mark_skipped

GOLDEN = json.loads((Path(__file__).parents[1] / "data" / "pusht_golden.json").read_text())


class Task(unittest.TestCase):
    def test_spawns_are_the_golden_ones(self) -> None:
        for golden in GOLDEN["spawn"]:
            state = spawn(golden["seed"])
            found = [state.tee_x, state.tee_y, state.tee_yaw, state.pusher_x, state.pusher_y]
            wanted = [*golden["tee"], golden["tee_yaw"], *golden["pusher"]]
            np.testing.assert_allclose(found, wanted, rtol=0, atol=4e-15)
            velocities = [state.pusher_vx, state.pusher_vy, state.tee_vx, state.tee_vy]
            self.assertEqual([*velocities, state.tee_yaw_rate], [0.0] * 5)


class Contracts(unittest.TestCase):
    def test_results_name_what_was_skipped(self) -> None:
        """rosunit alone does not."""
        case = simulator_contract.SimulatorContract("test_step_before_reset")
        case.before_reset = None
        with tempfile.TemporaryDirectory() as folder:
            results = str(Path(folder, "results.xml"))
            runner = rosunit.create_xml_runner("pusht_testing", "contract", results)
            self.assertEqual([test for test, _ in runner.run(case).skipped], [case])
            mark_skipped(results, SKIPPED)
            (skipped,) = ElementTree.parse(results).iter("skipped")
        self.assertEqual(skipped.get("message"), "the world had been reset before")

    def test_words_of_a_refusal_are_free_but_for_our_nodes(self) -> None:
        every = simulator_contract.SimulatorContract("test_horizon")
        ours = own_simulator_contract.OwnSimulatorContract("test_horizon")
        for message, accepted in (
            ("the horizon is reached", (True, True)),
            ("no more steps", (True, False)),
            ("", (False, False)),
            ("no more\nsteps", (False, False)),
        ):
            answer = StepResponse(success=False, message=message, exit_code=2, instance_id="1")
            for case, holds in zip((every, ours), accepted):
                case.instance_id = "1"
                with self.subTest(message, case=case.id()), contextlib.ExitStack() as expected:
                    if not holds:
                        expected.enter_context(self.assertRaises(AssertionError))
                    case.assert_refusal(answer, "horizon")


if __name__ == "__main__":
    unittest.main()
