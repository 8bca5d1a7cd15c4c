#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The task in Python, and the files of commands."""

import math
import os
import re
import tempfile
import unittest
from pathlib import Path
from typing import Any, Dict, List
from unittest import mock

import numpy as np

from pusht_task import files, task
from pusht_task.command import require_folder_of
from pusht_task.error import Error, ExitCode
from pusht_task.task import spawn, wrap_angle

HEADERS = Path(__file__).parents[1] / "include" / "pusht_task"
CONSTANTS = (HEADERS / "constants.hpp").read_text()
ERRORS = (HEADERS / "error.hpp").read_text()


class Task(unittest.TestCase):
    def test_seeds_that_are_no_uint64(self) -> None:
        with self.assertRaises(ValueError):
            spawn(-1)

    def test_angles(self) -> None:
        for angle, wrapped in (
            (math.pi, -math.pi),
            (-math.pi, -math.pi),
            (3.0 + 10 * math.pi, 3.0),
            (-4.0, 2 * math.pi - 4.0),
        ):
            self.assertAlmostEqual(wrap_angle(angle), wrapped, delta=1e-14)
        for angle in (0.1, -0.0, np.nextafter(math.pi, 0)):
            self.assertEqual(wrap_angle(angle), angle)

    def test_constants_are_those_of_the_cpp_header(self) -> None:
        found = 0
        for name, value in re.findall(r"constexpr \w+ k(\w+) = (-?[\d.]+)F?;", CONSTANTS):
            python_name = re.sub(r"(?<!^)([A-Z])", r"_\1", name).upper()
            if hasattr(task, python_name):
                self.assertEqual(getattr(task, python_name), float(value), name)
                found += 1
        self.assertGreaterEqual(found, 18)

    def test_exit_codes_are_those_of_the_cpp_header(self) -> None:
        codes = re.findall(r"k(\w+) = (\d+),", ERRORS)
        found = {re.sub(r"(?<!^)([A-Z])", r"_\1", name).upper(): int(c) for name, c in codes}
        self.assertEqual(found, {code.name: code.value for code in ExitCode})


class Files(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = Path(folder.name, "result.json")

    def found(self) -> Dict[str, str]:
        return {path.name: path.read_text() for path in self.path.parent.iterdir()}

    def changing(self, text: bytes) -> Any:
        """Instead of os.fstat: the file gets another text before the second look at it."""
        looks: List[int] = []
        look = os.fstat

        def fstat(file: int) -> os.stat_result:
            looks.append(file)
            if len(looks) == 2:
                self.path.write_bytes(text)
            return look(file)

        return fstat

    def test_is_read_whole_or_refused_by_name(self) -> None:
        self.path.write_bytes(b"12345")
        self.assertEqual(files.read_file(self.path, 5), b"12345")
        pipe = self.path.with_name("pipe")
        os.mkfifo(pipe)
        for path, rule in (
            (self.path, "has 5 bytes, must have at most 4"),
            (self.path.parent, "is a folder; it must be a plain file"),
            (pipe, "must be a plain file"),
            (Path("/dev/zero"), "must be a plain file"),
        ):
            with self.subTest(path):
                with self.assertRaisesRegex(Error, f"^{path}: {rule}$"):
                    files.read_file(path, 4)
        with mock.patch.object(os, "access", return_value=False):  # root may read all
            with self.assertRaisesRegex(Error, f"^{self.path}: must be a readable file$"):
                files.read_file(self.path)
        for text in (b"", b"123", b"1234567"):
            with self.subTest(text), mock.patch.object(os, "fstat", self.changing(text)):
                self.path.write_bytes(b"12345")
                with self.assertRaisesRegex(Error, "it must not change meanwhile$") as refused:
                    files.read_file(self.path)
                self.assertEqual(refused.exception.exit_code, ExitCode.RUNTIME_FAULT)
        with self.assertRaises(OSError) as raised:
            files.read_file(Path("/proc/self/mem"))  # whose first page cannot be read
        self.assertEqual(raised.exception.filename, "/proc/self/mem")

    def test_takes_the_place_of_an_older_one(self) -> None:
        self.path.write_text("old")
        with files.aside(self.path) as file:
            file.write(b"new")
            self.assertEqual(self.path.read_text(), "old")
        self.assertEqual(self.found(), {"result.json": "new"})

    def test_failure_leaves_the_older_one(self) -> None:
        self.path.write_text("old")
        with self.assertRaises(KeyboardInterrupt), files.aside(self.path) as file:
            file.write(b"half")
            raise KeyboardInterrupt
        self.assertEqual(self.found(), {"result.json": "old"})

    def test_files_and_links_of_others_stay(self) -> None:
        for name in ("mine", "result.json.part"):
            self.path.with_name(name).write_text("mine")
        link = self.path.with_name("result.json.2.part")
        link.symlink_to("mine")
        files.write_file(self.path, b"new")
        self.assertTrue(link.is_symlink())
        kept = dict.fromkeys(("mine", "result.json.part", "result.json.2.part"), "mine")
        self.assertEqual(self.found(), {"result.json": "new", **kept})


class Places(unittest.TestCase):
    """Folders in which a command will write, before it works."""

    def test_a_folder_that_lets_nothing_in_is_refused_at_once(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "out.html")
            require_folder_of("out", path)
            with self.assertRaisesRegex(
                Error, "out .*none/a: must be in a folder that is there"
            ) as refused:
                require_folder_of("out", Path(folder, "none", "a"))
            self.assertEqual(refused.exception.exit_code, ExitCode.RUNTIME_FAULT)
            with mock.patch.object(os, "access", return_value=False):
                with self.assertRaisesRegex(Error, "out.html: cannot be written") as refused:
                    require_folder_of("out", path)
            self.assertEqual(refused.exception.exit_code, ExitCode.RUNTIME_FAULT)


if __name__ == "__main__":
    unittest.main()
