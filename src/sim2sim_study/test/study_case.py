# SPDX-License-Identifier: BSD-3-Clause
"""What tests of the studies share: a folder, intervals."""

import tempfile
import unittest
from pathlib import Path
from typing import Any, Dict

# Student's t from a printed table: 97.5 %, by degrees of freedom.
T = {1: 12.7062, 2: 4.30265, 4: 2.77645, 8: 2.30600}
HEADING = "episode,mode,success,final_position_error_m,final_angle_error_rad"  # of episodes.csv


class StudyCase(unittest.TestCase):
    """A test with a folder of its own."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def assert_interval(self, found: Dict[str, Any], mean: float, half: float) -> None:
        self.assertEqual(set(found), {"mean", "low", "high"})
        self.assertAlmostEqual(found["mean"], mean)
        self.assertAlmostEqual(found["low"], mean - half, places=4)
        self.assertAlmostEqual(found["high"], mean + half, places=4)
