# SPDX-License-Identifier: BSD-3-Clause
"""Commands in Python, each a process that is forked from one which has imported their libraries.

Importing them takes one second of the two of a report, and one and a half of the two of a training.
What a test shows of a command that is not started by this is how it is started and how it ends by a
signal; everything else is the same: arguments, folder, streams, exit code.
"""

import multiprocessing
import os
import runpy
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Sequence, Set

_processes = multiprocessing.get_context("forkserver")
_scripts: Set[str] = set()


def warm(scripts: Sequence[str], *libraries: str) -> None:
    """Says which scripts run so, and what they import. Once, before the first of them runs."""
    _scripts.update(scripts)
    _processes.set_forkserver_preload([__name__, *libraries])


def is_warm(script: str) -> bool:
    return script in _scripts


def run_warm(
    command: Sequence[str], folder: Path, deadline: float
) -> "subprocess.CompletedProcess[str]":
    """Runs a script in Python with its arguments in a folder; `deadline` in s."""
    with tempfile.TemporaryDirectory() as streams:
        out, error = (Path(streams, name) for name in ("out", "error"))
        process = _processes.Process(target=_become, args=(command, folder, out, error))
        process.start()
        process.join(deadline)
        if process.exitcode is None:
            process.kill()
            raise subprocess.TimeoutExpired(list(command), deadline)
        return subprocess.CompletedProcess(
            list(command), process.exitcode, out.read_text(), error.read_text()
        )


def _become(command: Sequence[str], folder: Path, out: Path, error: Path) -> None:
    for descriptor, path in ((0, Path(os.devnull)), (1, out), (2, error)):
        os.dup2(os.open(path, os.O_RDWR | os.O_CREAT, 0o600), descriptor)
    sys.stdin = open(0, closefd=False)
    sys.stdout, sys.stderr = open(1, "w", closefd=False), open(2, "w", closefd=False)
    os.chdir(folder)
    sys.argv = list(command)
    try:
        runpy.run_path(command[0], run_name="__main__")
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
