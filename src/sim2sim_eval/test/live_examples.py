#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A run over the examples in Python."""

import json

from pusht_msgs.msg import Parameter  # type: ignore[import]
from pusht_task.testing import run

from live_support import RECORDED_RESULTS, GoalCase, files, metrics_of, result_bytes


class LiveExamples(GoalCase):
    def test_run_over_the_examples(self) -> None:
        result = self.compare(episodes=2)
        self.assertEqual((result.exit_code, result.reason), (0, "finished"))
        self.assertEqual(files(self.out), RECORDED_RESULTS)
        metrics = metrics_of(self.out)
        self.assertEqual(
            (metrics["policy"], metrics["engine_simulator"]), ("by_hand", "quasi_static")
        )
        self.assertEqual(metrics["knobs"]["characteristic_length"], 0.04)
        provenance = json.loads((self.out / "provenance.json").read_text())
        self.assertTrue(provenance["policy"]["numpy"])
        self.assert_recomputed(self.out)

    def test_same_bytes_again_and_other_ones_with_another_knob(self) -> None:
        results = []
        for name, length in (("a", "0.04"), ("b", "0.04"), ("c", "0.08")):
            self.out = self.folder / name
            knobs = [Parameter("characteristic_length", length)]
            self.compare(episodes=1, horizon=100, knobs=knobs)
            results.append(result_bytes(self.out))
        self.assertEqual(results[0], results[1])
        self.assertNotEqual(results[0], results[2])


run(LiveExamples)
