# SPDX-License-Identifier: BSD-3-Clause
"""The install space by itself, as script/test-install runs it: what users run, without sources."""

import ctypes
import os
import socket
import subprocess
import tempfile
import unittest
from pathlib import Path
from xml.etree import ElementTree

SPACE = Path(os.environ["CMAKE_PREFIX_PATH"].split(":")[0])
DEADLINE = 120  # [s] for one command


def free_port() -> str:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return str(probe.getsockname()[1])


class InstallSpace(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def succeed(self, *command: str) -> str:
        process = subprocess.run(
            command,
            cwd=self.folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=DEADLINE,
        )
        self.assertEqual(process.returncode, 0, process.stdout)
        return process.stdout

    def test_no_other_space_is_at_hand(self) -> None:
        for hidden in ("src", "build", "devel"):
            self.assertFalse((SPACE.parent / hidden).exists(), hidden)
        found = self.succeed("rospack", "find", "sim2sim_eval").strip()
        self.assertEqual(Path(found), SPACE / "share" / "sim2sim_eval")

    def test_live_and_batch_give_the_same_bytes(self) -> None:
        self.succeed("rosrun", "sim2sim_eval", "compare", "--episodes", "2", "--out", "batch")
        launch = ("roslaunch", "-p", free_port(), "sim2sim_eval", "compare.launch", "rviz:=false")
        self.succeed(*launch, "episodes:=2", f"out:={self.folder}/live", "report:=true")
        for name in ("metrics.json", "episodes.csv", "statistics.json"):
            batch, live = (self.folder / run / name for run in ("batch", "live"))
            self.assertEqual(batch.read_bytes(), live.read_bytes(), name)
        self.assertIn("</html>", (self.folder / "live" / "report.html").read_text())

    def test_every_kind_by_name(self) -> None:
        for kind in ("mujoco", "two_mass", "rigid_body", "chipmunk", "box2d", "bullet"):
            with self.subTest(kind):
                run = ("rosrun", "sim2sim_eval", "compare", "--policy", "expert", "--engine", kind)
                self.succeed(*run, "--episodes", "1", "--out", kind)

    def test_sweep_and_its_plot(self) -> None:
        plan = SPACE / "share" / "sim2sim_eval" / "config" / "block_damp_sweep.yaml"
        sweep = ("rosrun", "sim2sim_eval", "sweep", str(plan), "--episodes", "2", "--out", "sweep")
        self.succeed(*sweep)
        self.succeed("rosrun", "sim2sim_eval", "plot_sweep", "sweep", "--out", "plot.png")
        self.assertTrue((self.folder / "plot.png").is_file())

    def test_panel_of_rviz_loads(self) -> None:
        description = ElementTree.parse(SPACE / "share" / "pusht_rviz" / "plugin_description.xml")
        library = SPACE / "lib" / f"{description.getroot().get('path')}.so"
        ctypes.CDLL(str(library))
        plugins = self.succeed("rospack", "plugins", "--attrib=plugin", "rviz")
        self.assertIn(str(SPACE / "share" / "pusht_rviz"), plugins)

    def test_training_and_its_evaluation_begin(self) -> None:
        for package, name in (("pusht_policy", "train"), ("sim2sim_eval", "record_evaluation")):
            self.assertIn(f"usage: {name}", self.succeed("rosrun", package, name, "--help"))

    def test_python_gives_the_bytes_of_the_command(self) -> None:
        self.succeed("rosrun", "sim2sim_eval", "compare", "--episodes", "2", "--out", "command")
        program = "import sim2sim; sim2sim.compare('bc', episodes=2, out='python')"
        self.succeed("python3", "-c", program)
        for name in ("metrics.json", "episodes.csv", "statistics.json"):
            command, python = (self.folder / run / name for run in ("command", "python"))
            self.assertEqual(command.read_bytes(), python.read_bytes(), name)
        examples = sorted((SPACE / "share" / "sim2sim_python" / "examples").glob("*.py"))
        self.assertEqual(len(examples), 4)
        for example in examples:
            self.assertNotEqual(self.succeed("python3", str(example)), "")

    def test_contracts_say_how_they_are_used(self) -> None:
        for name in ("simulator_contract", "own_simulator_contract", "policy_contract"):
            self.assertIn("usage: rosrun", self.succeed("rosrun", "pusht_testing", name, "--help"))
