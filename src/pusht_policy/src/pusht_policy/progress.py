# SPDX-License-Identifier: BSD-3-Clause
"""The progress of a training, on stdout."""

import sys
import time

from pusht_task.command import say

LINE_INTERVAL = 10  # epochs between two plain lines


class Progress:
    """A line that is updated on a terminal; elsewhere a plain line every few epochs."""

    def __init__(self, first_epoch: int, epochs: int) -> None:
        self._first_epoch = first_epoch
        self._epochs = epochs
        self._start = time.monotonic()
        self._terminal = sys.stdout.isatty()

    def show(self, epoch: int, train_loss: float, validation_loss: float) -> None:
        """Called after every epoch."""
        if not (self._terminal or epoch % LINE_INTERVAL == 0 or epoch == self._epochs):
            return
        elapsed = time.monotonic() - self._start
        left = round(elapsed / (epoch - self._first_epoch) * (self._epochs - epoch))
        line = (
            f"epoch {epoch}/{self._epochs}  train {train_loss:.6f}  "
            f"validation {validation_loss:.6f}  {left // 60} min {left % 60:02d} s left"
        )
        say(f"\r{line}\033[K" if self._terminal else line, end="" if self._terminal else "\n")

    def close(self) -> None:
        """Ends the updated line."""
        if self._terminal:
            say("")
