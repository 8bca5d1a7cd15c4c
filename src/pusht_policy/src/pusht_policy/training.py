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
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Dict, Iterator, List, Optional, Sequence, Tuple

from pusht_policy.checkpoint import (
    ARCHIVE_MARK,
    PROVENANCE_FORMAT,
    provenance_path,
    read_provenance,
    sha256_of,
)
from pusht_policy.demonstrations import read_demonstrations, read_origin
from pusht_policy.interface import require_task
from pusht_policy.model import torchscript_bytes
from pusht_policy.recipe import Recipe
from pusht_policy.software import set_up_torch, software
from pusht_policy.trainer import Trainer
from pusht_task.command import SIGNALS, require_folder_of, require_new_file, say
from pusht_task.error import Error
from pusht_task.files import write_file
from pusht_task.json_file import Json, write_json


@dataclass(frozen=True)
class Targets:
    """The checkpoints that a training writes."""

    out: Path  # after the last epoch
    also_after: Tuple[int, ...] = ()  # epochs after which the policy is written, too
    overwrite: bool = False  # checkpoints that are there are replaced; other files never
    keep: bool = False  # a finished training of the same recipe and frames stays

    def paths(self, recipe: Recipe) -> Dict[int, Path]:
        """The checkpoints by the epochs after which they are written: "after-60-full.ts.pt"."""
        early = {n: self.out.with_name(f"after-{n}-{self.out.name}") for n in self.also_after}
        return {**dict(sorted(early.items())), recipe.epochs: self.out}

    def check(self, recipe: Recipe) -> None:
        """Raises Error for the first checkpoint that cannot be written, whatever is there."""
        require_folder_of("out", self.out)
        if self.out.is_dir():
            raise Error(f"{self.out}: is a folder; it must be a file name")
        for epoch in self.also_after:
            if not 0 < epoch < recipe.epochs:
                raise Error(
                    f"also-after is {epoch}; it must be in [1, {recipe.epochs - 1}], below epochs"
                )

    def require_new(self, path: Path) -> None:
        """Raises Error if there is something that must stay."""
        require_new_file("out", path, ARCHIVE_MARK if self.overwrite else None)
        if not self.overwrite:
            require_new_file("provenance", provenance_path(path))


def train(bags: Sequence[Path], targets: Targets, state_dir: Path, recipe: Recipe) -> None:
    """Trains on the bags and writes checkpoints, each with its provenance beside it.

    Goes on where a state was left. Refuses files that are there, unless `targets` says otherwise
    or they are of this training.
    """
    recipe.check()
    targets.check(recipe)
    paths = targets.paths(recipe)
    goes_on = (state_dir / "state.pt").exists()
    if not (goes_on or targets.keep):
        for path in paths.values():
            targets.require_new(path)
    with _stop_signals() as stop_requested, locked(state_dir):
        demonstrations = read_demonstrations(bags)
        frames = sum(len(d.actions) for d in demonstrations)
        successes = sum(d.success for d in demonstrations)
        say(f"{len(demonstrations)} demonstrations, {successes} solved, {frames} frames")
        origins = [read_origin(bag) for bag in bags]
        for bag, origin in zip(bags, origins):
            require_task(bag, recipe.interface, (origin or {}).get("task", "full_circle"))
        set_up_torch(recipe)
        trainer = Trainer(demonstrations, recipe)
        trainer.resume(state_dir / "state.pt")
        finished = targets.keep and targets.out.exists() and not goes_on
        for epochs, path in paths.items():
            difference = _difference(path, trainer, epochs)
            if difference is not None and (finished or epochs < trainer.epoch):
                kept = targets.out if finished else state_dir / "state.pt"
                raise Error(f"{path}: {difference}; delete {kept} to train anew")
            if difference is not None and not _is_begun(path, trainer, epochs):
                targets.require_new(path)
        if finished:
            say(f"{targets.out} stays: it is this training, finished")
            return
        of_demonstrations = {
            "bags": [{"file": b.name, "origin": o} for b, o in zip(bags, origins)],
            "sha256_of_frames": trainer.identity["frames"],
            "episodes": len(demonstrations),
            "successes": successes,
            "frames": frames,
            "first_seed": demonstrations[0].seed,
            "last_seed": demonstrations[-1].seed,
        }
        for epochs, path in paths.items():
            if epochs >= trainer.epoch:
                trainer.run(state_dir / "state.pt", stop_requested, epochs)
                _write_checkpoint(path, trainer, of_demonstrations)
        (state_dir / "state.pt").unlink()


def _write_checkpoint(path: Path, trainer: Trainer, demonstrations: Json) -> None:
    """Writes the provenance first: a checkpoint without one would say nothing of its origin."""
    model_bytes = torchscript_bytes(trainer.script, trainer.model.description())
    provenance = {
        "format": PROVENANCE_FORMAT,
        "checkpoint": {"file": path.name, "sha256": hashlib.sha256(model_bytes).hexdigest()},
        "demonstrations": demonstrations,
        "training": trainer.provenance(),
        "software": software(),
        "evaluation": None,
    }
    write_json(provenance_path(path), provenance)
    write_file(path, model_bytes)


def _difference(path: Path, trainer: Trainer, epochs: int) -> Optional[str]:
    """What tells a checkpoint from that of this training after so many epochs; None if nothing."""
    if not path.exists():
        return "is not there"
    if not provenance_path(path).exists():
        return "has no provenance beside it"
    provenance = read_provenance(path)
    expected, found = provenance["checkpoint"]["sha256"], sha256_of(path)
    if found != expected:
        return f"its SHA-256 is {found}, must be {expected}"
    return _difference_of_training(provenance, trainer, epochs)


def _is_begun(path: Path, trainer: Trainer, epochs: int) -> bool:
    """Whether there is only the provenance of this training, which was then killed."""
    if path.exists() or not provenance_path(path).exists():
        return False
    return _difference_of_training(read_provenance(path), trainer, epochs) is None


def _difference_of_training(provenance: Json, trainer: Trainer, epochs: int) -> Optional[str]:
    training = provenance.get("training", {})
    found = {
        **training,
        "frames": provenance["demonstrations"]["sha256_of_frames"],
        "after_epochs": training.get("after_epochs", training.get("epochs")),
    }
    wanted = {
        **trainer.recipe_provenance(),
        "frames": trainer.identity["frames"],
        "after_epochs": epochs,
    }
    for name, value in wanted.items():
        if found.get(name) != value:
            return f"{name} was {found.get(name)}, is now {value}; both must agree"
    return None


@contextlib.contextmanager
def _stop_signals() -> Iterator[Callable[[], bool]]:
    """SIGNALS ask for a stop while the context lasts."""
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
