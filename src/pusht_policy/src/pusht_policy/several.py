# SPDX-License-Identifier: BSD-3-Clause
"""Several trainings that differ in their seed, as many at once as the processor has cores for.

Each is a process of its own with the command that trains one, so it has the bits of that command.
"""

import os
import queue
import signal
import subprocess
import threading
from pathlib import Path
from typing import IO, Dict, List, Sequence

from pusht_task.command import TIED_TO_PARENT, say
from pusht_task.error import Error, ExitCode


def out_of_seed(out: Path, seed: int) -> Path:
    """The checkpoint of one seed: "small.ts.pt" becomes "small-3.ts.pt"."""
    stem, dot, suffix = out.name.partition(".")
    return out.with_name(f"{stem}-{seed}{dot}{suffix}")


def train_seeds(commands: Dict[int, Sequence[str]], threads: int) -> None:
    """Runs the command of each seed. A failure ends no other seed; the first one is raised."""
    at_once = max(1, len(os.sched_getaffinity(0)) // threads)
    failures: List[Exception] = []
    waiting: "queue.SimpleQueue[int]" = queue.SimpleQueue()
    for seed in commands:
        waiting.put(seed)
    group = _Group()

    def work() -> None:
        while not group.interrupted:
            try:
                seed = waiting.get_nowait()
            except queue.Empty:
                return
            try:
                group.run(f"seed {seed}", commands[seed])
            except Error as failure:  # of this seed; the others go on
                failures.append(failure)
            except Exception as failure:  # of this process, such as a closed stdout
                failures.append(failure)
                group.interrupt()

    workers = [threading.Thread(target=work) for _ in range(min(at_once, len(commands)))]
    for worker in workers:
        worker.start()
    try:
        for worker in workers:
            worker.join()
    except KeyboardInterrupt:
        group.interrupt()
        for worker in workers:
            worker.join()
        raise Error(
            "interrupted, states saved; run the same command again to resume",
            ExitCode.RUNTIME_FAULT,
        ) from None
    if failures:
        raise failures[0]


class _Group:
    """Processes that are interrupted together."""

    def __init__(self) -> None:
        self.interrupted = False
        self._lock = threading.Lock()
        self._running: List["subprocess.Popen[str]"] = []

    def run(self, name: str, command: Sequence[str]) -> None:
        """Runs a command to its end, its lines with `name` in front. Raises Error if it fails."""
        with self._lock:
            if self.interrupted:
                return
            process = subprocess.Popen(
                [*TIED_TO_PARENT, *command],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                start_new_session=True,  # a terminal's interrupt comes through interrupt() alone
            )
            self._running.append(process)
        complaints: List[str] = []
        assert process.stdout is not None and process.stderr is not None
        reader = threading.Thread(target=_collect, args=(process.stderr, complaints))
        reader.start()
        try:
            for line in process.stdout:
                say(f"{name}: {line.rstrip()}")
        finally:
            process.stdout.close()  # it may wait to write
            code = process.wait()
            reader.join()
            with self._lock:
                self._running.remove(process)
        if code != 0 and not self.interrupted:
            last = complaints[-1] if complaints else f"ended with exit code {code}"
            known = code in set(ExitCode)
            raise Error(f"{name}: {last}", ExitCode(code) if known else ExitCode.RUNTIME_FAULT)

    def interrupt(self) -> None:
        """Interrupts all that run, and starts no further one."""
        with self._lock:
            self.interrupted = True
            for process in self._running:
                process.send_signal(signal.SIGINT)


def _collect(stream: IO[str], lines: List[str]) -> None:
    lines.extend(line.rstrip() for line in stream)
