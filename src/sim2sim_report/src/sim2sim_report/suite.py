# SPDX-License-Identifier: BSD-3-Clause
"""Other commands of the suite that a report needs."""

import tempfile
from pathlib import Path
from typing import Callable, Sequence

from pusht_task.json_file import Json, read_json

__all__ = ["Suite"]


class Suite:
    """The commands, called by `call(command, *arguments)`, which refuses if the command fails."""

    def __init__(self, call: Callable[..., object]) -> None:
        self._call = call

    def contrast(self, folders: Sequence[Path], against: int = 0) -> Json:
        """Differences from the run or row `against`, pair by pair."""
        with tempfile.TemporaryDirectory() as scratch:
            out = Path(scratch, "contrast.json")
            names = [str(folder) for folder in folders]
            self._call("contrast", *names, "--against", str(against), "--out", str(out))
            return read_json(out)

    def recompute(self, bag: Path, out: Path) -> None:
        """Writes the results of a bag, with traces, into a new folder."""
        self._call("recompute", str(bag), "--traces", "--out", str(out))
