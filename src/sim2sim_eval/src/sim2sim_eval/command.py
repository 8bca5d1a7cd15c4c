# SPDX-License-Identifier: BSD-3-Clause
"""What the commands in Python share: refusals, and calls of other commands."""

import argparse
import subprocess
from typing import NoReturn

from pusht_task.exit_codes import ExitCode


class Refusal(Exception):
    """Why nothing is written: one line that names the thing, its value and the rule."""

    def __init__(self, message: str, exit_code: int = ExitCode.INVALID_INPUT) -> None:
        super().__init__(message)
        self.exit_code = exit_code


class OneLineParser(argparse.ArgumentParser):
    """Bad arguments are one line on stderr and exit code 2."""

    def error(self, message: str) -> NoReturn:
        self.exit(ExitCode.INVALID_INPUT, f"{self.prog}: {message}\n")


def rosrun(command: str, *arguments: str) -> None:
    """Runs a command of the suite. Refuses with its own line if it refuses."""
    try:
        process = subprocess.run(
            ["rosrun", "sim2sim_eval", command, *arguments],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
    except FileNotFoundError:
        raise Refusal(
            "rosrun: not found; source the workspace's setup.bash", ExitCode.BAD_DEPENDENCY
        ) from None
    if process.returncode != 0:
        lines = process.stderr.strip().splitlines() or [f"{command} failed"]
        raise Refusal(
            lines[-1], process.returncode if process.returncode > 0 else ExitCode.RUNTIME_FAULT
        )
