#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The rooms that know no ROS need none of its libraries, nor those of a simulator."""

import os
import re
import sys
from pathlib import Path
from typing import Set

sys.path.insert(0, os.path.dirname(__file__))  # nosetests does not
from command_case import CommandCase, executable  # noqa: E402

LIBRARIES = Path(executable("sim2sim_eval", "compare")).parents[1]
FOREIGN = re.compile(r"lib(ros|xmlrpcpp|tf2|actionlib|mujoco|chipmunk|pusht_task_ros)")


class Rooms(CommandCase):
    def foreign(self, room: str) -> Set[str]:
        """The libraries of ROS and of simulators that come with a room, also through others."""
        process = self.run_command("ldd", str(LIBRARIES / f"libsim2sim_{room}.so"))
        self.assertEqual(process.returncode, 0, process.stderr)
        needed = {line.split()[0] for line in process.stdout.splitlines()}
        self.assertIn("libpusht_task.so", needed)
        return {name for name in needed if FOREIGN.match(name)}

    def test_statistics_protocol_and_results_need_no_ros(self) -> None:
        for room in ("statistics", "protocol", "results"):
            self.assertEqual(self.foreign(room), set(), room)

    def test_those_that_need_it_show_it(self) -> None:
        """Or the other test could not fail."""
        for room, library in (("bag", "librosbag_storage.so"), ("eval", "libmujoco.so")):
            self.assertTrue(any(name.startswith(library) for name in self.foreign(room)), room)
