#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A kind of simulator in another workspace: nothing outside its package names it."""

import hashlib
import shlex
import shutil
import socket
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import rospkg  # type: ignore[import]
from pusht_testing.long_tests import LONG

from command_case import CommandCase

PACKAGE = Path(rospkg.RosPack().get_path("sim2sim_eval")) / "examples" / "pusht_toy"
KNOWN = "box2d, bullet, chipmunk, gym_pusht, mujoco, rigid_body, toy, two_mass"


def free_port() -> str:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return str(probe.getsockname()[1])


class Overlay(CommandCase):
    workspace: Path

    @classmethod
    def setUpClass(cls) -> None:
        """Builds the workspace. Beside the kind, it has a package that exports one unbuilt."""
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.workspace = Path(folder.name)
        source = cls.workspace / "src"
        shutil.copytree(PACKAGE, source / "pusht_toy")
        planned = source / "pusht_planned"
        planned.mkdir()
        for name in ("package.xml", "plugin_description.xml"):
            text = (PACKAGE / name).read_text()
            text = text.replace("pusht_toy", "pusht_planned").replace('"toy"', '"planned"')
            (planned / name).write_text(text)
        (planned / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.18)\nproject(pusht_planned)\n"
            "find_package(catkin REQUIRED COMPONENTS pusht_task)\ncatkin_package()\n"
        )
        python = [f"-D{name}_EXECUTABLE={sys.executable}" for name in ("PYTHON", "Python3")]
        command = ["catkin_make", "--directory", str(cls.workspace)]
        command.append(f"-DCATKIN_ENABLE_TESTING={'ON' if LONG else 'OFF'}")
        build = subprocess.run(
            [*command, *python], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        assert build.returncode == 0, build.stdout

    def setUp(self) -> None:
        super().setUp()
        self.library = self.workspace / "devel" / "lib" / "libpusht_toy.so"

    def in_overlay(self, *command: str) -> "subprocess.CompletedProcess[str]":
        setup = shlex.quote(str(self.workspace / "devel" / "setup.bash"))
        return self.run_command("bash", "-c", f"source {setup} && exec {shlex.join(command)}")

    def compare(self, *arguments: str) -> "subprocess.CompletedProcess[str]":
        run = ("rosrun", "sim2sim_eval", "compare", "--policy", "expert", "--episodes", "1")
        return self.in_overlay(*run, *arguments)

    def succeed(self, *arguments: str) -> None:
        process = self.compare(*arguments)
        self.assertEqual(process.returncode, 0, process.stderr)

    def test_the_kind_runs_by_its_name_in_process_and_live(self) -> None:
        self.succeed("--engine", "toy", "--set", "reach=0.1", "--out", "batch")
        metrics = self.load("batch", "metrics.json")
        self.assertEqual(metrics["engine_simulator"], "toy")
        self.assertEqual(metrics["simulators"]["engine"]["parameters"], {"reach": 0.1})
        code = self.load("batch", "provenance.json")["code"]
        self.assertEqual(
            code["libpusht_toy.so"], hashlib.sha256(self.library.read_bytes()).hexdigest()
        )
        launch = self.in_overlay(
            *("roslaunch", "-p", free_port(), "sim2sim_eval", "compare.launch", "rviz:=false"),
            *("policy:=expert", "episodes:=1", "engine:=toy", "engine_parameters:=reach=0.1"),
            f"out:={self.folder}/live",
        )
        self.assertEqual(launch.returncode, 0, launch.stdout + launch.stderr)
        self.assertEqual(self.result_bytes("live"), self.result_bytes("batch"))

    @unittest.skipUnless(LONG, "long form: script/test --long")
    def test_its_own_tests_pass(self) -> None:
        build = ("catkin_make", "--directory", str(self.workspace), "run_tests_pusht_toy")
        self.assertEqual(self.in_overlay(*build).returncode, 0)
        results = self.in_overlay("catkin_test_results", str(self.workspace / "build"))
        self.assertEqual(results.returncode, 0, results.stdout)
        self.assertRegex(results.stdout, r"Summary: [1-9]\d+ tests, 0 errors, 0 failures")

    def test_it_is_listed_where_its_workspace_is(self) -> None:
        process = self.compare("--engine", "toi")
        self.assert_one_line(process, 2, "compare")
        self.assertTrue(
            process.stderr.endswith(f"'toi': unknown; known: {KNOWN}\n"), process.stderr
        )
        outside = ("rosrun", "sim2sim_eval", "compare", "--engine", "toy")
        process = self.run_command(*outside)
        self.assert_one_line(process, 2, "compare")
        self.assertIn("'toy': unknown; known: ", process.stderr)

    def test_what_is_not_built_is_told_by_name(self) -> None:
        process = self.compare("--engine", "planned")
        self.assert_one_line(process, 3, "compare")
        self.assertIn("simulator 'planned': libpusht_planned.so of ", process.stderr)
        self.assertIn("build it, and source its setup.bash", process.stderr)

    def test_a_library_of_other_bytes_asks_for_other_references(self) -> None:
        def kept() -> int:
            run = (
                "--reference",
                "toy",
                "--reference-cache",
                "cache",
                "--overwrite",
                "--out",
                "out",
            )
            self.succeed(*run)
            return sum(path.is_file() for path in (self.folder / "cache").rglob("*"))

        first = kept()
        self.assertGreater(first, 0)
        self.assertEqual(kept(), first)
        before = self.library.read_bytes()
        self.addCleanup(self.library.write_bytes, before)
        self.library.write_bytes(before + b"\n")  # code that runs as before
        self.assertGreater(kept(), first)


if __name__ == "__main__":
    unittest.main()
