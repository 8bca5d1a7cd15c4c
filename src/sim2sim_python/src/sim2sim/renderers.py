# SPDX-License-Identifier: BSD-3-Clause
"""Processes that draw images beside this one, as Python draws in one thread of a process.

The bytes of an image do not depend on the process.
"""

import atexit
import functools
import json
import os
import select
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any, List, Optional

import numpy as np
from numpy.typing import NDArray

from sim2sim.errors import BadDependency, RuntimeFault

LEAST_SHARE = 8  # images, 2 ms: what a question costs is little beside them
MOST = 12  # a renderer draws 4 k images/s, of which this process reads 50 k
QUIET = {"PYGAME_HIDE_SUPPORT_PROMPT": "1"}  # pygame says nothing on the standard output
# A renderer finds what this process would find, wherever it is started.
PROGRAM = (
    "import json, runpy, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "runpy.run_path(sys.argv[2], run_name='__main__')"
)


def pictures() -> Any:
    """The module that draws. Raises BadDependency if pygame or OpenCV is not there."""
    os.environ.update(QUIET)
    try:
        from sim2sim import pictures as module
    except ImportError as error:
        raise BadDependency(
            "pictures: need pygame and OpenCV (Debian's python3-pygame and python3-opencv), "
            f"but {error}"
        ) from None
    return module


class Renderer:
    """A process that draws. Raises OSError if there can be no further process."""

    def __init__(self) -> None:
        path = json.dumps([entry for entry in sys.path if isinstance(entry, str)])
        module = str(Path(__file__).with_name("pictures.py"))
        self.process = subprocess.Popen(
            [sys.executable, "-c", PROGRAM, path, module],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, **QUIET},
            start_new_session=True,  # Ctrl-C is for this process, with which the other one ends
        )
        assert self.process.stdin is not None and self.process.stdout is not None
        self._questions, self._answers = self.process.stdin, self.process.stdout
        self._is_ready: Optional[bool] = None  # None: it is starting; False: it has failed to

    def is_ready(self, patience: float = 0.0) -> bool:
        """Whether it has started; waits so long [s] for that. One that cannot start has said why,
        and is never ready."""
        if self._is_ready is None:
            poll = select.poll()
            poll.register(self._answers, select.POLLIN)
            if poll.poll(1000.0 * patience):
                self._is_ready = len(self._answers.read(1)) == 1
        return bool(self._is_ready)

    def ask(self, rows: NDArray[np.float64], width: int, height: int) -> None:
        """Asks for images, which answer() gives."""
        try:
            self._questions.write(np.array([len(rows), width, height], np.int64).tobytes())
            self._questions.write(np.ascontiguousarray(rows, np.float64).tobytes())
            self._questions.flush()
        except BrokenPipeError:
            raise self._fault() from None

    def answer(self, images: NDArray[np.uint8]) -> None:
        """Fills the images that were asked for."""
        filled = self._answers.readinto(images.data)  # type: ignore[attr-defined]
        if filled < images.nbytes:
            raise self._fault()

    def end(self) -> None:
        """Ends the process, whatever it does."""
        self.process.kill()
        self.process.communicate()

    def _fault(self) -> RuntimeFault:
        status = self.process.wait()
        return RuntimeFault(
            f"renderer: process {self.process.pid} ended with status {status} while it drew "
            "images; if memory ran out, use fewer worlds at once"
        )


class Renderers:
    """The renderers of a process. Each further core gets one when there is work for it."""

    def __init__(self) -> None:
        self.others: List[Renderer] = []
        self._most = min(MOST, len(os.sched_getaffinity(0)) - 1)
        self._lock = threading.Lock()

    def images(self, rows: NDArray[np.float64], width: int, height: int) -> NDArray[np.uint8]:
        """Images, by as many as are ready and worth asking."""
        if len(rows) < 2 * LEAST_SHARE or not self._lock.acquire(blocking=False):
            return np.asarray(pictures().images(rows, width, height))
        try:
            return self._shared(rows, width, height)
        except BaseException:
            self.end()  # one that was asked would give its images to the next batch
            raise
        finally:
            self._lock.release()

    def end(self) -> None:
        """Ends them all."""
        for renderer in self.others:
            renderer.end()
        self.others = []

    def _shared(self, rows: NDArray[np.float64], width: int, height: int) -> NDArray[np.uint8]:
        asked = self._ready(len(rows) // LEAST_SHARE - 1)
        shares = np.array_split(np.arange(len(rows)), len(asked) + 1)
        for renderer, share in zip(asked, shares[1:]):
            renderer.ask(rows[share], width, height)
        images = np.empty((len(rows), height, width, 3), np.uint8)
        images[shares[0]] = pictures().images(rows[shares[0]], width, height)
        for renderer, share in zip(asked, shares[1:]):
            renderer.answer(images[share[0] : share[-1] + 1])
        return images

    def _ready(self, wanted: int) -> List[Renderer]:
        """Gives at most `wanted` that are ready; starts what is missing."""
        try:
            while len(self.others) < min(wanted, self._most):
                self.others.append(Renderer())
        except OSError:  # no more processes: those that are there draw
            self._most = len(self.others)
        return [renderer for renderer in self.others[:wanted] if renderer.is_ready()]


@functools.lru_cache(maxsize=1)
def _renderers_of(process: int) -> Renderers:
    """The renderers of a process: one that was forked must not ask those of its parent."""
    renderers = Renderers()
    atexit.register(lambda: renderers.end() if os.getpid() == process else None)
    return renderers


def images(rows: NDArray[np.float64], width: int, height: int) -> NDArray[np.uint8]:
    """Images as pictures.images(), for which other processes draw, too. Raises RuntimeFault if one
    of them ends."""
    return _renderers_of(os.getpid()).images(rows, width, height)
