# SPDX-License-Identifier: BSD-3-Clause
"""Runs commands as a user does, for tests."""

import functools
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from types import ModuleType
from typing import Any, Callable, Dict, List, Optional, Sequence, Set
from unittest import mock

from catkin.find_in_workspaces import find_in_workspaces  # type: ignore[import]
from pusht_testing.warm_commands import is_warm, run_warm

DEADLINE = 120.0  # s, for one command


@functools.lru_cache(maxsize=None)
def executable(package: str, name: str) -> str:
    """An executable of a package, in the devel or the install space."""
    found: List[str] = find_in_workspaces(["libexec"], package, name, first_match_only=True)
    assert found, f"{package} has no executable {name}"
    return found[0]


def load_script(name: str) -> ModuleType:
    """A script of this package, as a module."""
    loader = SourceFileLoader(name, str(Path(__file__).resolve().parents[1] / "scripts" / name))
    spec = spec_from_loader(name, loader)
    assert spec
    module = module_from_spec(spec)
    with mock.patch.object(sys, "dont_write_bytecode", True):  # it would lie beside the script
        loader.exec_module(module)
    return module


def until(holds: Callable[[], bool], deadline: float = DEADLINE) -> None:
    """Waits for what nothing tells of: asks again and again."""
    expiry = time.monotonic() + deadline
    while not holds():
        if time.monotonic() > expiry:
            raise TimeoutError(f"not within {deadline} s")


def catches(pid: int, number: signal.Signals) -> bool:
    """Whether a process has a handler for a signal."""
    return bool(signals(pid, "SigCgt") & 1 << (number - 1))


def signals(pid: int, which: str) -> int:
    """A set of signals, as /proc names it."""
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return next(int(line.split()[1], 16) for line in lines if line.startswith(which))


class CommandCase(unittest.TestCase):
    """Runs commands in a folder of its own."""

    deadline = DEADLINE

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def run_command(
        self,
        *command: str,
        environment: Optional[Dict[str, str]] = None,
        deadline: Optional[float] = None,
    ) -> "subprocess.CompletedProcess[str]":
        if is_warm(command[0]) and environment is None:
            return run_warm(command, self.folder, deadline or self.deadline)
        return subprocess.run(
            command,
            cwd=self.folder,
            env={**os.environ, **(environment or {})},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            timeout=deadline or self.deadline,
        )

    def run_all(self, *commands: Sequence[str]) -> str:
        """Runs commands that must succeed, in turn; returns what the last one prints."""
        for command in commands:
            process = self.run_command(*command)
            self.assertEqual(process.returncode, 0, process.stderr)
        return process.stdout

    def assert_one_line(
        self, process: "subprocess.CompletedProcess[str]", code: int, command: str
    ) -> None:
        self.assertEqual(process.returncode, code, process.stderr)
        self.assertEqual(process.stderr.count("\n"), 1, process.stderr)
        self.assertTrue(process.stderr.startswith(f"{command}: "), process.stderr)

    def files(self, out: str) -> Set[str]:
        return {file.name for file in (self.folder / out).iterdir()}

    def load(self, out: str, name: str) -> Dict[str, Any]:
        content: Dict[str, Any] = json.loads((self.folder / out / name).read_text())
        return content

    def result_bytes(self, out: str) -> bytes:
        """What the determinism contract covers."""
        return b"".join(
            (self.folder / out / f).read_bytes() for f in ("metrics.json", "episodes.csv")
        )

    def charging_policy(self) -> str:
        """Drives into the tee at full speed, which a soft link does not survive."""
        from torch_policies import save_charging  # takes a second

        path = str(self.folder / "charge.pt")
        save_charging(path)
        return path

    def write(self, name: str, content: bytes) -> str:
        path = self.folder / name
        path.write_bytes(content)
        return str(path)
