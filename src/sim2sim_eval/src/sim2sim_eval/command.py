# SPDX-License-Identifier: BSD-3-Clause
"""Calls of other commands of the suite."""

import subprocess

from pusht_task.error import Error, ExitCode


def rosrun(command: str, *arguments: str) -> str:
    """What a command of the suite prints. Refuses with its line if it fails."""
    try:
        process = subprocess.run(
            ["rosrun", "sim2sim_eval", command, *arguments],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
    except FileNotFoundError:
        raise Error(
            "rosrun: not found; source the workspace's setup.bash", ExitCode.BAD_DEPENDENCY
        ) from None
    except BlockingIOError as error:  # no further process is allowed
        raise Error(f"rosrun {command}: {error.strerror}", ExitCode.RUNTIME_FAULT) from None
    if process.returncode != 0:
        lines = process.stderr.strip().splitlines() or [f"{command} failed"]
        raise Error(
            lines[-1], process.returncode if process.returncode > 0 else ExitCode.RUNTIME_FAULT
        )
    return process.stdout
