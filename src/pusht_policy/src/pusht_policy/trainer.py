# SPDX-License-Identifier: BSD-3-Clause
"""The training loop and its state, from which a training resumes with the same bits."""

import io
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Sequence

import torch

from pusht_policy.demonstrations import Demonstration, sha256_of_frames
from pusht_policy.formats import STATE_FORMAT
from pusht_policy.frames import Examples, frames_of, split
from pusht_policy.interface import INTERFACES
from pusht_policy.model import ranges_of
from pusht_policy.models import MODELS
from pusht_policy.progress import Progress
from pusht_policy.recipe import Recipe
from pusht_policy.software import software
from pusht_task.command import say
from pusht_task.error import Error, ExitCode
from pusht_task.files import read_file, write_file

STATE_INTERVAL = 10  # epochs between two saved states
NEWER = ("interface", "chunk")  # of a recipe: left out where they have their defaults
HISTORY_INTERVAL = 50  # epochs between two entries of the validation loss history


class Trainer:
    """A training over demonstrations that are already read."""

    def __init__(self, demonstrations: Sequence[Demonstration], recipe: Recipe) -> None:
        self.recipe = recipe
        self.identity = _identity(recipe, demonstrations)
        self.generator = torch.Generator().manual_seed(recipe.seed)
        train_part, validation_part = split(demonstrations, recipe, self.generator)
        interface = INTERFACES[recipe.interface]
        frames = frames_of(train_part, interface)
        torch.manual_seed(recipe.seed)
        self.model = MODELS[recipe.model](recipe, ranges_of(frames))
        self.script = torch.jit.script(self.model)  # shares the weights; reads model.py only now
        self.train_examples = self.model.examples(frames)
        self.validation_examples = self.model.examples(frames_of(validation_part, interface))
        self.optimizer = torch.optim.Adam(self.model.parameters(), lr=recipe.learning_rate)
        self.scheduler = torch.optim.lr_scheduler.CosineAnnealingLR(
            self.optimizer, T_max=recipe.epochs
        )
        self.epoch = 0  # epochs done
        self.train_loss = math.nan  # mean over the last epoch, while the weights changed
        self.validation_loss = math.nan  # after the last epoch
        self.history: List[Dict[str, float]] = []

    def run(
        self,
        state_path: Path,
        stop_requested: Callable[[], bool],
        until: Optional[int] = None,  # epochs that are then done; None: all
    ) -> None:
        """Trains; saves the state now and then and when told to stop."""
        epochs = self.recipe.epochs if until is None else until
        progress = Progress(self.epoch, self.recipe.epochs)
        while self.epoch < epochs:
            if stop_requested():
                self.save(state_path)
                progress.close()
                raise Error(
                    f"interrupted after epoch {self.epoch} of {self.recipe.epochs}, state saved; "
                    "run the same command again to resume",
                    ExitCode.RUNTIME_FAULT,
                )
            self._run_epoch()
            if self.epoch % STATE_INTERVAL == 0 or self.epoch == epochs:
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
        content = read_file(path)
        try:
            state = torch.load(io.BytesIO(content), weights_only=False)
            found = state["identity"]
        except Exception:  # unpickling damaged bytes can raise anything
            raise Error(f"{path}: not a readable training state; delete it to start anew") from None
        for name, value in self.identity.items():
            if found.get(name) != value:
                raise Error(
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

    def recipe_provenance(self) -> Dict[str, Any]:
        """What the recipe says in a provenance."""
        return {
            **self.model.provenance(),
            "epochs": self.recipe.epochs,
            "batch": self.recipe.batch,
            "learning_rate": self.recipe.learning_rate,
            "schedule": "cosine to 0, stepped every epoch",
            "optimizer": "Adam",
            "seed": self.recipe.seed,
            "threads": self.recipe.threads,
            "flush_denormal": True,
            "validation_fraction": self.recipe.validation_fraction,
            **{name: _named(self.recipe)[name] for name in NEWER if name in _named(self.recipe)},
        }

    def provenance(self) -> Dict[str, Any]:
        """The `training` part of the provenance, after the epochs that are done."""
        early = {} if self.epoch == self.recipe.epochs else {"after_epochs": self.epoch}
        return {
            **self.recipe_provenance(),
            **early,
            "train_frames": self.train_examples.frames(),
            "validation_frames": self.validation_examples.frames(),
            "final_train_loss": self._loss_over(self.train_examples),
            "final_validation_loss": self.validation_loss,
            "validation_loss_history": self.history,
        }

    def _run_epoch(self) -> None:
        examples = self.train_examples
        order = torch.randperm(len(examples), generator=self.generator)
        total = 0.0
        for batch in examples.rows(order).split(self.recipe.batch):
            loss = self.model.loss(batch, self.generator)
            self.optimizer.zero_grad(set_to_none=True)
            loss.backward()
            self.optimizer.step()
            total += loss.item() * batch.frames()
        self.scheduler.step()
        self.epoch += 1
        self.train_loss = total / examples.frames()
        self.validation_loss = self._loss_over(self.validation_examples)
        if not (math.isfinite(self.train_loss) and math.isfinite(self.validation_loss)):
            raise Error(
                f"epoch {self.epoch}: training loss {self.train_loss}, validation loss "
                f"{self.validation_loss}; both must be finite (a lower --lr may help)",
                ExitCode.RUNTIME_FAULT,
            )
        if self.epoch % HISTORY_INTERVAL == 0:
            self.history.append({"epoch": self.epoch, "loss": self.validation_loss})

    def _loss_over(self, examples: Examples) -> float:
        """The loss over all examples, with noise that is the same each time."""
        with torch.no_grad():
            return float(self.model.loss(examples, torch.Generator().manual_seed(self.recipe.seed)))


def _named(recipe: Recipe) -> Dict[str, Any]:
    """The recipe; without what an earlier version did not know, unless it is set."""
    usual = asdict(Recipe())
    return {
        name: list(value) if name == "chunk" else value
        for name, value in asdict(recipe).items()
        if name not in NEWER or value != usual[name]
    }


def _identity(recipe: Recipe, demonstrations: Sequence[Demonstration]) -> Dict[str, Any]:
    """Values that must agree for a state to be resumed with the same bits."""
    versions = software()
    return {
        "format": STATE_FORMAT,
        **_named(recipe),
        "frames": sha256_of_frames(demonstrations),
        **{name: versions[name] for name in ("torch", "blas", "blas_core", "vectors")},
    }
