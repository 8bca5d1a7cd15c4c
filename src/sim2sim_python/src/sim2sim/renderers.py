# SPDX-License-Identifier: BSD-3-Clause
"""Processes that draw images beside this one, as Python draws in one thread of a process.

The bytes of an image do not depend on who draws it.
"""

import atexit
import functools
import os
import select
import subprocess
import sys
import threading
from pathlib import Path
from typing import List

import numpy as np
from numpy.typing import NDArray

from sim2sim import _sim2sim
from sim2sim.errors import RuntimeFault

NUMBERS = 7  # of a state
LEAST_SHARE = 8  # images for which another process is asked
READY = b"r"
_PACKAGES = str(Path(_sim2sim.__file__).parents[1])  # a workspace's sim2sim is found from there


class Renderer:
    """A process that runs sim2sim.renderer."""

    def __init__(self) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "sim2sim.renderer"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, "PYTHONPATH": os.pathsep.join([_PACKAGES, *sys.path])},
            start_new_session=True,  # Ctrl-C is for this process, with which the other one ends
        )
        assert self.process.stdin is not None and self.process.stdout is not None
        self._questions, self._answers = self.process.stdin, self.process.stdout
        self._is_ready = False

    def is_ready(self) -> bool:
        """Whether it has started. It does not wait."""
        if not self._is_ready and select.select([self._answers], [], [], 0.0)[0]:
            self._read(len(READY))
            self._is_ready = True
        return self._is_ready

    def ask(self, states: NDArray[np.float64], width: int, height: int) -> None:
        """Asks for images, which answer() gives."""
        try:
            self._questions.write(np.array([len(states), width, height], np.int64).tobytes())
            self._questions.write(np.ascontiguousarray(states, np.float64).tobytes())
            self._questions.flush()
        except BrokenPipeError:
            raise self._fault() from None

    def answer(self, images: NDArray[np.uint8]) -> None:
        """Fills the images that were asked for."""
        images[:] = np.frombuffer(self._read(images.nbytes), np.uint8).reshape(images.shape)

    def end(self) -> None:
        """Ends the process, whatever it does."""
        self.process.kill()
        self.process.communicate()

    def _read(self, count: int) -> bytes:
        data = self._answers.read(count)
        if len(data) < count:
            raise self._fault()
        return data

    def _fault(self) -> RuntimeFault:
        status = self.process.wait()
        return RuntimeFault(
            f"renderer: process {self.process.pid} ended with status {status} while it drew "
            "images; if memory ran out, use fewer worlds at once"
        )


class Renderers:
    """The renderers of this process: one for each further core, from the first batch on."""

    def __init__(self) -> None:
        self.others: List[Renderer] = []
        self._lock = threading.Lock()

    def images(self, states: NDArray[np.float64], width: int, height: int) -> NDArray[np.uint8]:
        """Images, by as many as are ready and worth asking."""
        from sim2sim import pictures

        if len(states) < 2 * LEAST_SHARE or not self._lock.acquire(blocking=False):
            return pictures.images(states, width, height)
        try:
            return self._shared(states, width, height)
        except BaseException:
            self.end()  # one that was asked would give its images to the next batch
            raise
        finally:
            self._lock.release()

    def _shared(self, states: NDArray[np.float64], width: int, height: int) -> NDArray[np.uint8]:
        from sim2sim import pictures

        ready = self._ready()[: len(states) // LEAST_SHARE - 1]
        shares = np.array_split(np.arange(len(states)), len(ready) + 1)
        for renderer, share in zip(ready, shares[1:]):
            renderer.ask(states[share], width, height)
        images = np.empty((len(states), height, width, 3), np.uint8)
        images[shares[0]] = pictures.images(states[shares[0]], width, height)
        for renderer, share in zip(ready, shares[1:]):
            renderer.answer(images[share[0] : share[-1] + 1])
        return images

    def _ready(self) -> List[Renderer]:
        if not self.others:
            others = len(os.sched_getaffinity(0)) - 1
            self.others = [Renderer() for _ in range(others)]
        return [renderer for renderer in self.others if renderer.is_ready()]

    def end(self) -> None:
        """Ends them all."""
        for renderer in self.others:
            renderer.end()
        self.others = []


@functools.lru_cache(maxsize=1)
def _renderers_of(process: int) -> Renderers:
    """The renderers of a process: one that was forked must not ask those of its parent."""
    renderers = Renderers()
    atexit.register(lambda: renderers.end() if os.getpid() == process else None)
    return renderers


def images(states: NDArray[np.float64], width: int, height: int) -> NDArray[np.uint8]:
    """Images as pictures.images(), by as many processes as are ready and worth asking. Raises
    RuntimeFault if one of them ends."""
    return _renderers_of(os.getpid()).images(states, width, height)
