# SPDX-License-Identifier: BSD-3-Clause
"""Files that are read whole, and written whole or not at all."""

import contextlib
import os
import stat
from pathlib import Path
from typing import BinaryIO, Iterator, Tuple

from pusht_task.error import Error, ExitCode

MODE = 0o644
LARGEST_FILE = 2**30  # bytes of a file that is read at once, as in files.hpp


def require_plain_file(path: Path) -> None:
    """Raises Error for a folder, a pipe, a device, where opening one may wait for ever or never
    end; and for a file that this user may not read."""
    mode = path.stat().st_mode
    if not stat.S_ISREG(mode):
        found = "is a folder; it " if stat.S_ISDIR(mode) else ""
        raise Error(f"{path}: {found}must be a plain file")
    if not os.access(path, os.R_OK):
        raise Error(f"{path}: must be a readable file")


def read_file(path: Path, most: int = LARGEST_FILE) -> bytes:
    """All bytes of a plain file. Raises Error if it is none, has more than `most` bytes, or changes
    meanwhile."""
    require_plain_file(path)
    with named(path), open(path, "rb") as file:
        before = os.fstat(file.fileno()).st_size
        if before > most:
            raise Error(f"{path}: has {before} bytes, must have at most {most}")
        content = file.read()
        size = os.fstat(file.fileno()).st_size
    if size != len(content) and (before, size) != (0, 0):  # the kernel makes some as they are read
        changed = f"has {size} bytes, but {len(content)} were read; it must not change meanwhile"
        raise Error(f"{path}: {changed}", ExitCode.RUNTIME_FAULT)
    return content


def read_text(path: Path) -> str:
    """The text of a file in UTF-8. Raises Error as read_file(), ValueError for other bytes."""
    return read_file(path).decode("utf-8")


@contextlib.contextmanager
def named(path: Path) -> Iterator[None]:
    """Names `path` in an error of the system that names no file, as a write on a full disk does."""
    try:
        yield
    except OSError as error:
        if error.filename is None:
            error.filename = str(path)
        raise


@contextlib.contextmanager
def aside(path: Path) -> Iterator[BinaryIO]:
    """A file beside `path` that takes its place at the end, or is removed if that fails.

    Its name is a fresh one: what lies there already, a link too, is another's and stays as it is.
    """
    name, descriptor = _fresh(path)
    try:
        with named(path), os.fdopen(descriptor, "wb") as file:
            yield file
            file.flush()
            os.fsync(descriptor)
        name.replace(path)
    except BaseException:
        with contextlib.suppress(OSError):
            name.unlink()
        raise


def _fresh(path: Path) -> Tuple[Path, int]:
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
    name = path.with_name(f"{path.name}.part")
    number = 1
    while True:
        try:
            return name, os.open(name, flags, MODE)
        except FileExistsError:
            number += 1
            name = path.with_name(f"{path.name}.{number}.part")


def write_file(path: Path, content: bytes) -> None:
    with aside(path) as file:
        file.write(content)
