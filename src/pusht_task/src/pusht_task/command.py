# SPDX-License-Identifier: BSD-3-Clause
"""The rules of the commands in Python: arguments, signals, error lines, exit codes, new files.

They are those of the commands in C++ (docs/faults.md). Imports next to nothing, so that a command
obeys them before it loads the libraries that it needs.
"""

import argparse
import contextlib
import io
import mmap
import os
import signal
import sys
import time
from pathlib import Path
from typing import Any, Callable, Iterator, NoReturn, Optional

from pusht_task.error import Error, ExitCode, clipped
from pusht_task.files import named

# Signals of ending_signals.hpp.
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1, signal.SIGUSR2)
ONE_SIGNAL = 0.5  # [s] Closer signals are one: `timeout` sends to the command and to its group
PATIENCE = 10  # [s] for an end in order after a signal
BLAS_MEMORY = 300  # MB, of numpy with OpenBLAS and of what draws with it
TORCH_MEMORY = 800  # MB
MARK_WITHIN = 4096  # bytes at either end of a file, in which a command's own mark stands


class OneLineParser(argparse.ArgumentParser):
    """Bad arguments are one line on stderr and exit code 2."""

    def error(self, message: str) -> NoReturn:
        complain(self.prog, message)
        sys.exit(ExitCode.INVALID_INPUT)


@contextlib.contextmanager
def loading(megabytes: int = BLAS_MEMORY) -> Iterator[None]:
    """Around the imports of numpy and of what needs it, in the body of a command.

    A signal waits for their end. Raises Error at once if there is no such memory: OpenBLAS asks for
    its own in an endless loop, and an import of torch names a module that is there.
    """
    try:
        mmap.mmap(-1, megabytes << 20, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS).close()
    except OSError as error:
        needed = f"memory: {megabytes} MB more are needed: {error.strerror}"
        raise Error(needed, ExitCode.RUNTIME_FAULT) from None
    with interrupts.held():
        yield


# In front of a command that must not outlive this process.
TIED_TO_PARENT = ["setpriv", "--pdeathsig", "KILL"]


def run_command(name: str, body: Callable[[], None], hint: str = "nothing is written") -> int:
    """Runs the work of a command. Every failure is one line on stderr and an exit code.

    `hint` says what an interrupt leaves.
    """
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="surrogateescape")  # names of files may be any bytes
    interrupts.catch(name)
    try:
        body()
        return ExitCode.OK
    except Error as error:
        message, code = str(error), error.exit_code
    except KeyboardInterrupt:
        message, code = "interrupted" + (f"; {hint}" if hint else ""), ExitCode.RUNTIME_FAULT
    except ImportError as error:
        missing = error.name or str(error)
        message, code = f"{missing}: not found; it is needed", ExitCode.BAD_DEPENDENCY
    except MemoryError:
        message, code = "memory is used up", ExitCode.RUNTIME_FAULT
    except OSError as error:
        thing = f"{error.filename}: " if error.filename is not None else ""
        message, code = f"{thing}{error.strerror or error}", ExitCode.RUNTIME_FAULT
        _forget_stdout()
    except Exception as error:
        if str(error) == "can't start new thread":  # Python's words for a limit of processes
            complain(name, str(error))
            return ExitCode.RUNTIME_FAULT
        message = f"internal error: {type(error).__name__}: {error}"
        code = ExitCode.INTERNAL_ERROR
    complain(name, message)
    return code


def say(text: str, end: str = "\n") -> None:
    """Prints to stdout at once. An error of the system names stdout."""
    with named(Path("stdout")):
        print(text, end=end, flush=True)


def complain(name: str, message: str) -> None:
    """Writes one line to stderr, if there is one."""
    line = clipped(" ".join(message.split()))
    with contextlib.suppress(OSError, AttributeError, ValueError):
        sys.stderr.write(f"{name}: {line}\n")
        sys.stderr.flush()


def _forget_stdout() -> None:
    """Drops the buffer of a stdout that takes nothing: flushing it would be a second error."""
    with contextlib.suppress(OSError, AttributeError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


class Interrupts:
    """SIGNALS as in the commands in C++: KeyboardInterrupt in the main thread.

    A second signal more than 0.5 s later, or 10 s without an end, ends the process at once.
    """

    def __init__(self) -> None:
        self._first: Optional[float] = None  # [s] on the monotonic clock
        self._held = False
        self._last_words = ""

    def catch(self, name: str) -> None:
        self._last_words = f"{name}: interrupted, and ended before it had stopped in order\n"
        for number in SIGNALS:
            signal.signal(number, self._on_signal)
        signal.signal(signal.SIGALRM, self._end_at_once)
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # an error of write(), then
        sys.unraisablehook = self._on_lost_exception

    @contextlib.contextmanager
    def held(self) -> Iterator[None]:
        """A signal waits until the end of the block: a broken import prints a traceback."""
        self._held = True
        try:
            yield
        finally:
            self._held = False
        if self._first is not None:
            raise KeyboardInterrupt

    def _on_signal(self, _number: int, _frame: Any) -> None:
        now = time.monotonic()
        if self._first is None:
            self._first = now
            signal.alarm(PATIENCE)
            if not self._held:
                raise KeyboardInterrupt
        elif now - self._first > ONE_SIGNAL:
            self._end_at_once()

    def _end_at_once(self, *_: Any) -> None:
        with contextlib.suppress(OSError):
            os.write(2, self._last_words.encode("utf-8", "replace"))
        os._exit(ExitCode.RUNTIME_FAULT)

    def _on_lost_exception(self, unraisable: Any) -> None:
        """An interrupt in code that may raise nothing, such as a destructor."""
        if issubclass(unraisable.exc_type, KeyboardInterrupt):
            self._end_at_once()
        sys.__unraisablehook__(unraisable)


interrupts = Interrupts()


def require_new_file(option: str, path: Path, mark: Optional[bytes] = None) -> None:
    """Refuses a file that is there, a link too.

    With `mark` it may be replaced if it is a file of this command's own: one that has the mark
    near its beginning or its end.
    """
    if not os.path.lexists(path):
        return
    if mark is None:
        raise Error(f"{option} {path}: is there already; name a new file")
    if path.is_symlink() or not path.is_file() or not _has_mark(path, mark):
        raise Error(f"{option} {path}: is there already, and is not this command's own")


def require_folder_of(option: str, path: Path) -> None:
    """Refuses a file in no folder, or in one that is not writable, before there is work to lose."""
    folder = path.parent
    if not folder.is_dir():
        text = f"{option} {path}: must be in a folder that is there"
        raise Error(text, ExitCode.RUNTIME_FAULT)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise Error(f"{option} {path}: cannot be written in that folder", ExitCode.RUNTIME_FAULT)


def _has_mark(path: Path, mark: bytes) -> bool:
    with open(path, "rb") as file:
        if mark in file.read(MARK_WITHIN):
            return True
        file.seek(max(0, path.stat().st_size - MARK_WITHIN))
        return mark in file.read()
