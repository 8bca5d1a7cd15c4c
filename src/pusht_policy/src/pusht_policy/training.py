# SPDX-License-Identifier: BSD-3-Clause
"""Behaviour cloning: the training loop, its resumable state, and the files it writes.

The same recipe, demonstrations, torch and BLAS on a processor for which they choose the same code
(the core type of OpenBLAS, the vectors of libtorch) give the same weights bit for bit, interrupted
or not. Another core type sums gradients in another order.
"""

import contextlib
import ctypes
import fcntl
import hashlib
import io
import json
import math
import os
import platform
import re
import signal
import sys
import time
import zipfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Sequence, Tuple

import numpy as np
import torch
from torch import Tensor, nn

from pusht_policy.demonstrations import (
    Demonstration,
    InputError,
    read_demonstrations,
    read_origin,
    require_format,
    sha256_of_frames,
)
from pusht_policy.formats import PROVENANCE_FORMAT, STATE_FORMAT
from pusht_policy.model import Policy, minimum_and_range, normalised
from pusht_task.command import SIGNALS, Refusal, read_json, require_new_file, say
from pusht_task.exit_codes import ExitCode
from pusht_task.files import write_file

STATE_INTERVAL = 10  # epochs between two saved states, and between two plain progress lines
HISTORY_INTERVAL = 50  # epochs between two entries of the validation loss history
METRICS_FORMAT = 4  # of the metrics.json that is read; kDescriptionFormat in sim2sim_eval
# What an evaluation is of, besides episodes and seed.
EVALUATED: Dict[str, Any] = {
    "reference_simulator": "mujoco",
    "simulators.reference.changed": [],  # parameters
    "horizon": 300,
    "first_episode": 0,
    "smoke": False,
}
ARCHIVE_MARK = b"PK\x03\x04"  # at the beginning of a TorchScript archive
ARCHIVE_TIME = (1980, 1, 1, 0, 0, 0)  # of every file in a TorchScript archive


class Fault(Refusal):
    """A run-time fault; the text names the thing, its value and the rule."""

    def __init__(self, message: str) -> None:
        super().__init__(message, ExitCode.RUNTIME_FAULT)


class Interrupted(Fault):
    """Training was interrupted by a signal after its state had been saved."""


@dataclass(frozen=True)
class Recipe:
    """What decides the weights, besides the demonstrations and the software."""

    epochs: int = 600
    batch: int = 128  # frames
    learning_rate: float = 1e-3  # at the start; cosine to 0, one step an epoch
    seed: int = 0  # of the split, the initial weights and the shuffles
    threads: int = 1
    hidden: Tuple[int, int] = (512, 512)  # units
    validation_fraction: float = 0.1  # of the demonstrations

    def check(self) -> None:
        """Raises InputError for the first value that breaks its rule."""
        for name in ("epochs", "batch", "threads"):
            if getattr(self, name) < 1:
                raise InputError(f"{name} is {getattr(self, name)}; it must be at least 1")
        if min(self.hidden) < 1:
            raise InputError(f"hidden is {list(self.hidden)}; both sizes must be at least 1")
        if not (math.isfinite(self.learning_rate) and self.learning_rate > 0):
            raise InputError(f"lr is {self.learning_rate}; it must be finite and greater than 0")
        if not 0 <= self.seed < 2**63:
            raise InputError(f"seed is {self.seed}; it must be in [0, 2^63)")


@dataclass(frozen=True)
class Frames:
    """Frames of some demonstrations, in SI units."""

    observations: Tensor  # float32 [n, 10]
    actions: Tensor  # float32 [n, 2], m/s


@dataclass(frozen=True)
class NormalisedFrames:
    """Frames as the network sees them: inputs in [-1, 1], targets mapped likewise."""

    inputs: Tensor  # float32 [n, 10]
    targets: Tensor  # float32 [n, 2]


def train(
    bags: Sequence[Path], out: Path, state_dir: Path, recipe: Recipe, overwrite: bool = False
) -> None:
    """Trains on the bags and writes `out` and its provenance; goes on where a state was left.

    Refuses a file that is there; with `overwrite` it may be a checkpoint.
    """
    recipe.check()
    if not out.parent.is_dir():
        raise InputError(f"{out}: its folder does not exist; it must exist")
    if out.is_dir():
        raise InputError(f"{out}: is a folder; it must be a file name")
    require_new_file("out", out, ARCHIVE_MARK if overwrite else None)
    if not overwrite:
        require_new_file("provenance", provenance_path(out))
    with _stop_signals() as stop_requested, _locked(state_dir):
        demonstrations = read_demonstrations(bags)
        frames = sum(len(d.actions) for d in demonstrations)
        successes = sum(d.success for d in demonstrations)
        say(f"{len(demonstrations)} demonstrations, {successes} solved, {frames} frames")
        origins = [read_origin(bag) for bag in bags]
        _set_up_torch(recipe)
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
        write_file(provenance_path(out), _json_bytes(provenance))
        (state_dir / "state.pt").unlink()


class Trainer:
    """One training run over demonstrations that are already read."""

    def __init__(self, demonstrations: Sequence[Demonstration], recipe: Recipe) -> None:
        self.recipe = recipe
        self.identity = _identity(recipe, demonstrations)
        self.generator = torch.Generator().manual_seed(recipe.seed)
        train_part, validation_part = split(demonstrations, recipe, self.generator)
        frames = _frames(train_part)
        obs_min, obs_range = minimum_and_range(frames.observations)
        act_min, act_range = minimum_and_range(frames.actions)
        torch.manual_seed(recipe.seed)
        self.model = Policy(recipe.hidden, obs_min, obs_range, act_min, act_range)
        self.script = torch.jit.script(self.model)  # shares the weights; reads model.py only now
        self.train_frames = self._normalised(frames)
        self.validation_frames = self._normalised(_frames(validation_part))
        self.optimizer = torch.optim.Adam(self.model.parameters(), lr=recipe.learning_rate)
        self.scheduler = torch.optim.lr_scheduler.CosineAnnealingLR(
            self.optimizer, T_max=recipe.epochs
        )
        self.epoch = 0  # epochs done
        self.train_loss = math.nan  # mean over the last epoch, while the weights changed
        self.validation_loss = math.nan  # after the last epoch
        self.history: List[Dict[str, float]] = []

    def run(self, state_path: Path, stop_requested: Callable[[], bool]) -> None:
        """Trains up to the last epoch; saves the state now and then and when told to stop."""
        progress = _Progress(self.epoch, self.recipe.epochs)
        while self.epoch < self.recipe.epochs:
            if stop_requested():
                self.save(state_path)
                progress.close()
                raise Interrupted(
                    f"interrupted after epoch {self.epoch} of {self.recipe.epochs}, state saved; "
                    "run the same command again to resume"
                )
            self._run_epoch()
            if self.epoch % STATE_INTERVAL == 0 or self.epoch == self.recipe.epochs:
                self.save(state_path)
            progress.show(self.epoch, self.train_loss, self.validation_loss)
        progress.close()

    def save(self, path: Path) -> None:
        """Writes everything that decides the rest of the run."""
        buffer = io.BytesIO()
        state = {
            "identity": self.identity,
            "epoch": self.epoch,
            "model": self.model.state_dict(),
            "optimizer": self.optimizer.state_dict(),
            "scheduler": self.scheduler.state_dict(),
            "generator": self.generator.get_state(),
            "global_generator": torch.get_rng_state(),
            "train_loss": self.train_loss,
            "validation_loss": self.validation_loss,
            "history": self.history,
        }
        torch.save(state, buffer)
        write_file(path, buffer.getvalue())

    def resume(self, path: Path) -> None:
        """Takes over a saved state, if there is one; refuses that of another run."""
        if not path.exists():
            return
        try:
            state = torch.load(str(path), weights_only=False)
            found = state["identity"]
        except Exception:  # unpickling damaged bytes can raise anything
            raise InputError(
                f"{path}: not a readable training state; delete it to start anew"
            ) from None
        for name, value in self.identity.items():
            if found.get(name) != value:
                raise InputError(
                    f"{path}: {name} was {found.get(name)}, is now {value}; both must agree "
                    "(or delete that file to start anew)"
                )
        self.model.load_state_dict(state["model"])
        self.optimizer.load_state_dict(state["optimizer"])
        self.scheduler.load_state_dict(state["scheduler"])
        self.generator.set_state(state["generator"])
        torch.set_rng_state(state["global_generator"])
        self.epoch = state["epoch"]
        self.train_loss = state["train_loss"]
        self.validation_loss = state["validation_loss"]
        self.history = state["history"]
        say(f"resumed after epoch {self.epoch}")

    def provenance(self) -> Dict[str, Any]:
        """The `training` part of the provenance of a finished run."""
        hidden = "-".join(str(size) for size in self.recipe.hidden)
        inputs = self.train_frames.inputs.shape[1]
        outputs = self.train_frames.targets.shape[1]
        return {
            "architecture": f"MLP {inputs}-{hidden}-{outputs}, ReLU",
            "epochs": self.recipe.epochs,
            "batch": self.recipe.batch,
            "learning_rate": self.recipe.learning_rate,
            "schedule": "cosine to 0, stepped every epoch",
            "optimizer": "Adam",
            "loss": "mean squared error in normalised action space",
            "seed": self.recipe.seed,
            "threads": self.recipe.threads,
            "flush_denormal": True,
            "validation_fraction": self.recipe.validation_fraction,
            "train_frames": len(self.train_frames.inputs),
            "validation_frames": len(self.validation_frames.inputs),
            "final_train_loss": self._loss_over(self.train_frames),
            "final_validation_loss": self.validation_loss,
            "validation_loss_history": self.history,
        }

    def _normalised(self, frames: Frames) -> NormalisedFrames:
        model = self.model
        inputs = normalised(frames.observations, model.obs_min, model.obs_range).clamp(-1.0, 1.0)
        return NormalisedFrames(inputs, normalised(frames.actions, model.act_min, model.act_range))

    def _run_epoch(self) -> None:
        frames = self.train_frames
        order = torch.randperm(len(frames.inputs), generator=self.generator)
        total = 0.0
        for inputs, targets in zip(
            frames.inputs[order].split(self.recipe.batch),
            frames.targets[order].split(self.recipe.batch),
        ):
            loss = nn.functional.mse_loss(self.model.net(inputs), targets)
            self.optimizer.zero_grad(set_to_none=True)
            loss.backward()
            self.optimizer.step()
            total += loss.item() * len(inputs)
        self.scheduler.step()
        self.epoch += 1
        self.train_loss = total / len(frames.inputs)
        self.validation_loss = self._loss_over(self.validation_frames)
        if not (math.isfinite(self.train_loss) and math.isfinite(self.validation_loss)):
            raise Fault(
                f"epoch {self.epoch}: training loss {self.train_loss}, validation loss "
                f"{self.validation_loss}; both must be finite (a lower --lr may help)"
            )
        if self.epoch % HISTORY_INTERVAL == 0:
            self.history.append({"epoch": self.epoch, "loss": self.validation_loss})

    def _loss_over(self, frames: NormalisedFrames) -> float:
        """Mean squared error in normalised action space over all frames."""
        with torch.no_grad():
            return float(nn.functional.mse_loss(self.model.net(frames.inputs), frames.targets))


def split(
    demonstrations: Sequence[Demonstration], recipe: Recipe, generator: torch.Generator
) -> Tuple[List[Demonstration], List[Demonstration]]:
    """Whole demonstrations for training and for validation, by a seeded permutation."""
    count = len(demonstrations)
    if count < 2:
        raise InputError(f"demonstrations: {count}; at least 2 are needed (1 to validate)")
    validation_count = max(1, round(recipe.validation_fraction * count))
    chosen = set(torch.randperm(count, generator=generator)[:validation_count].tolist())
    training = [d for i, d in enumerate(demonstrations) if i not in chosen]
    return training, [demonstrations[i] for i in sorted(chosen)]


def torchscript_bytes(script: torch.jit.ScriptModule) -> bytes:
    """The archive of a module, without its debug records: they hold local paths."""
    script.eval()
    saved = io.BytesIO()
    torch.jit.save(script, saved)
    stripped = io.BytesIO()
    with zipfile.ZipFile(saved) as source, zipfile.ZipFile(stripped, "w") as target:
        for info in source.infolist():
            if not info.filename.endswith(".debug_pkl"):
                record = zipfile.ZipInfo(info.filename, ARCHIVE_TIME)
                target.writestr(record, source.read(info))
    return stripped.getvalue()


def record_evaluation(checkpoint: Path, results: Path) -> None:
    """Fills `evaluation` in the checkpoint's provenance from the results folder of a comparison
    with it in MuJoCo: figures of another policy, simulator or protocol are refused."""
    path = provenance_path(checkpoint)
    provenance = _read_json(path)
    require_format(str(path), provenance, PROVENANCE_FORMAT)
    found = sha256_of(checkpoint)
    _require(path, provenance, "checkpoint.sha256", found)
    metrics = _read_json(results / "metrics.json")
    _require(results / "metrics.json", metrics, "format", METRICS_FORMAT)
    origin = _read_json(results / "provenance.json")
    _require(results / "provenance.json", origin, "policy.sha256", found)
    configuration = _value(results / "provenance.json", origin, "configuration")
    for name, value in EVALUATED.items():
        _require(results / "provenance.json", origin, f"configuration.{name}", value)
    for name in ("starts", "until_decided"):
        if name in configuration:
            raise InputError(
                f"{results / 'provenance.json'}: configuration.{name} is {configuration[name]}; "
                "there must be none"
            )
    for name, value in configuration.items():
        _require(results / "metrics.json", metrics, name, value)
    episodes = _value(results / "metrics.json", metrics, "episodes")
    successes = _value(results / "metrics.json", metrics, "mj_successes")
    rate = _value(results / "metrics.json", metrics, "mj_success_rate")
    if not (0 <= successes <= episodes and rate == round(successes / episodes, 6)):
        raise InputError(
            f"{results / 'metrics.json'}: mj_success_rate is {rate}; it must be mj_successes "
            f"({successes}) over episodes ({episodes})"
        )
    version = _value(results / "provenance.json", origin, "reference.version")
    provenance["evaluation"] = {
        "simulator": f"MuJoCo {version}",
        "episodes": episodes,
        "seed": _value(results / "metrics.json", metrics, "seed"),
        "success_rate": rate,
        "successes": successes,
    }
    write_file(path, _json_bytes(provenance))


def _value(path: Path, content: Any, key: str) -> Any:
    """The value under "a.b" in the content of a JSON file."""
    for name in key.split("."):
        if not isinstance(content, dict) or name not in content:
            raise InputError(f"{path}: no key {key}; it is needed")
        content = content[name]
    return content


def _require(path: Path, content: Any, key: str, expected: Any) -> None:
    found = _value(path, content, key)
    if found != expected:
        raise InputError(f"{path}: {key} is {found}; it must be {expected}")


def provenance_path(checkpoint: Path) -> Path:
    """Where the provenance of a checkpoint is kept: beside it."""
    return checkpoint.with_name(checkpoint.name + ".provenance.json")


def sha256_of(path: Path) -> str:
    """Hexadecimal SHA-256 of a file."""
    digest = hashlib.sha256()
    try:
        with path.open("rb") as file:
            for chunk in iter(lambda: file.read(1 << 20), b""):
                digest.update(chunk)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; it must exist") from None
    return digest.hexdigest()


def software() -> Dict[str, str]:
    """What computes the weights: versions, and what they choose their code by."""
    return {
        "cpu": _cpu_model(),
        "vectors": _torch_vectors(),
        "blas_core": ", ".join(_blas_cores()) or "unknown",
        "python": platform.python_version(),
        "torch": torch.__version__,
        "numpy": np.__version__,
        "blas": ", ".join(Path(name).name for name in _loaded_blas()) or "unknown",
    }


def _cpu_model() -> str:
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        models = [line.split(":", 1)[1].strip() for line in file if line.startswith("model name")]
    return models[0] if models else platform.processor() or "unknown"


def _torch_vectors() -> str:
    """The instruction set that libtorch's own code takes, e.g. AVX2."""
    found = re.search(r"CPU capability usage: (\S+)", torch.__config__.show())
    return found.group(1) if found else "unknown"


def _blas_cores() -> List[str]:
    """The processor types for which OpenBLAS has chosen its code."""
    cores = []
    for name in _loaded_blas():
        core_name = getattr(ctypes.CDLL(name), "openblas_get_corename", None)
        if core_name is not None:
            core_name.restype = ctypes.c_char_p
            cores.append(core_name().decode())
    return sorted(set(cores))


def _loaded_blas() -> List[str]:
    """Real paths of the BLAS libraries that this process has loaded."""
    with open("/proc/self/maps", encoding="utf-8") as maps:
        mapped = {line.split(maxsplit=5)[5].strip() for line in maps if len(line.split()) > 5}
    names = {name for name in mapped if "blas" in Path(name).name and ".so" in Path(name).name}
    return sorted(os.path.realpath(name) for name in names)


def _set_up_torch(recipe: Recipe) -> None:
    """One set of bits and no slow denormals. OpenBLAS does not heed torch's thread count."""
    torch.use_deterministic_algorithms(True)
    torch.set_flush_denormal(True)
    torch.set_num_threads(recipe.threads)
    for name in _loaded_blas():
        set_threads = getattr(ctypes.CDLL(name), "openblas_set_num_threads", None)
        if set_threads is not None:
            set_threads(ctypes.c_int(recipe.threads))


def _identity(recipe: Recipe, demonstrations: Sequence[Demonstration]) -> Dict[str, Any]:
    """All that must agree for a state to be continued with the same bits."""
    versions = software()
    return {
        "format": STATE_FORMAT,
        **asdict(recipe),
        "frames": sha256_of_frames(demonstrations),
        **{name: versions[name] for name in ("torch", "blas", "blas_core", "vectors")},
    }


def _frames(demonstrations: Sequence[Demonstration]) -> Frames:
    return Frames(
        torch.from_numpy(np.concatenate([d.observations for d in demonstrations])),
        torch.from_numpy(np.concatenate([d.actions for d in demonstrations])),
    )


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
def _locked(folder: Path) -> Iterator[None]:
    """Holds a folder for one run; removes it at the end if nothing else is left in it."""
    folder.mkdir(parents=True, exist_ok=True)
    lock = folder / "lock"
    with lock.open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(f"{folder}: in use by another training; it must be free") from None
        try:
            yield
        finally:
            lock.unlink()
            with contextlib.suppress(OSError):
                folder.rmdir()


def _json_bytes(value: Any) -> bytes:
    return (json.dumps(value, indent=2, sort_keys=True) + "\n").encode()


def _read_json(path: Path) -> Dict[str, Any]:
    value = read_json(path, "it must exist")
    if not isinstance(value, dict):
        raise InputError(f"{path}: is a JSON {type(value).__name__}; it must be an object")
    return value


class _Progress:
    """One updated line on a terminal, else a plain line every few epochs."""

    def __init__(self, first_epoch: int, epochs: int) -> None:
        self._first_epoch = first_epoch
        self._epochs = epochs
        self._start = time.monotonic()
        self._terminal = sys.stdout.isatty()

    def show(self, epoch: int, train_loss: float, validation_loss: float) -> None:
        """Called after every epoch."""
        if not (self._terminal or epoch % STATE_INTERVAL == 0 or epoch == self._epochs):
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
