# SPDX-License-Identifier: BSD-3-Clause
"""Behavior cloning: from bags of demonstrations to a checkpoint with its provenance.

The same recipe, demonstrations, torch and BLAS on a processor for which they choose the same code
(the core type of OpenBLAS, the vectors of libtorch) give the same weights bit for bit, interrupted
or not. Another core type sums gradients in another order.
"""

import contextlib
import fcntl
import hashlib
import signal
from pathlib import Path
from typing import Callable, Iterator, List, Sequence

from pusht_policy.checkpoint import ARCHIVE_MARK, PROVENANCE_FORMAT, provenance_path
from pusht_policy.demonstrations import read_demonstrations, read_origin
from pusht_policy.model import torchscript_bytes
from pusht_policy.recipe import Recipe
from pusht_policy.software import set_up_torch, software
from pusht_policy.trainer import Trainer
from pusht_task.command import SIGNALS, require_new_file, say
from pusht_task.error import Error
from pusht_task.files import write_file
from pusht_task.json_file import write_json


def train(
    bags: Sequence[Path], out: Path, state_dir: Path, recipe: Recipe, overwrite: bool = False
) -> None:
    """Trains on the bags and writes `out` and its provenance; goes on where a state was left.

    Refuses a file that is there; with `overwrite` it may be a checkpoint.
    """
    recipe.check()
    if not out.parent.is_dir():
        raise Error(f"{out}: its folder does not exist; it must exist")
    if out.is_dir():
        raise Error(f"{out}: is a folder; it must be a file name")
    require_new_file("out", out, ARCHIVE_MARK if overwrite else None)
    if not overwrite:
        require_new_file("provenance", provenance_path(out))
    with _stop_signals() as stop_requested, locked(state_dir):
        demonstrations = read_demonstrations(bags)
        frames = sum(len(d.actions) for d in demonstrations)
        successes = sum(d.success for d in demonstrations)
        say(f"{len(demonstrations)} demonstrations, {successes} solved, {frames} frames")
        origins = [read_origin(bag) for bag in bags]
        set_up_torch(recipe)
        trainer = Trainer(demonstrations, recipe)
        trainer.resume(state_dir / "state.pt")
        trainer.run(state_dir / "state.pt", stop_requested)
        model_bytes = torchscript_bytes(trainer.script)
        provenance = {
            "format": PROVENANCE_FORMAT,
            "checkpoint": {"file": out.name, "sha256": hashlib.sha256(model_bytes).hexdigest()},
            "demonstrations": {
                "bags": [{"file": b.name, "origin": o} for b, o in zip(bags, origins)],
                "sha256_of_frames": trainer.identity["frames"],
                "episodes": len(demonstrations),
                "successes": successes,
                "frames": frames,
                "first_seed": demonstrations[0].seed,
                "last_seed": demonstrations[-1].seed,
            },
            "training": trainer.provenance(),
            "software": software(),
            "evaluation": None,
        }
        write_file(out, model_bytes)
        write_json(provenance_path(out), provenance)
        (state_dir / "state.pt").unlink()


@contextlib.contextmanager
def _stop_signals() -> Iterator[Callable[[], bool]]:
    """SIGINT, SIGTERM and SIGHUP ask for a stop while the context lasts."""
    received: List[int] = []
    previous = [signal.signal(s, lambda number, _: received.append(number)) for s in SIGNALS]
    try:
        yield lambda: bool(received)
    finally:
        for number, handler in zip(SIGNALS, previous):
            signal.signal(number, handler)


@contextlib.contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Holds a folder for one run; removes it at the end if nothing else is left in it."""
    folder.mkdir(parents=True, exist_ok=True)
    lock = folder / "lock"
    with lock.open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise Error(f"{folder}: in use by another training; it must be free") from None
        try:
            yield
        finally:
            lock.unlink()
            with contextlib.suppress(OSError):
                folder.rmdir()
