# SPDX-License-Identifier: BSD-3-Clause
"""The networks that look back, remember, answer with chunks or draw noise, and the names of all."""

from typing import Any, Callable, Dict, Mapping, Tuple

import torch
from torch import Tensor, nn

from pusht_policy.formats import DESCRIPTION_FORMAT
from pusht_policy.frames import Examples, Frames, pieces, windows
from pusht_policy.interface import INTERFACES
from pusht_policy.model import Model, Policy, Ranges, normalised, perceptron, sizes_of
from pusht_policy.recipe import Recipe

PIECE = 48  # control steps of a demonstration through which a gradient goes back
EULER_STEPS = 8  # from noise to a chunk
# Loss whose best constant answer is a median, which is nearly one of the expert's actions. A mean,
# best for squares, of pushing and staying is too slow to move the tee: the policy stands still.
ABSOLUTE_ERROR = "mean absolute error in normalised action space"


class Described(Model):
    """A network whose checkpoint says what it takes and answers."""

    def description(self) -> Dict[str, Any]:
        return {"format": DESCRIPTION_FORMAT, "observations": 1, "actions": 1, "execute": 1}

    def inputs_of(self, observations: Tensor) -> Tensor:
        return normalised(observations, self.obs_min, self.obs_range).clamp(-1.0, 1.0)

    def actions_of(self, outputs: Tensor) -> Tensor:
        return (outputs + 1) / 2 * self.act_range + self.act_min


class Recurrent(Described):
    """Observation [n, 1, 10] and state [n, units] to action [n, 1, 2] and the next state."""

    def __init__(self, recipe: Recipe, ranges: Ranges) -> None:
        super().__init__(ranges)
        self.gru = nn.GRU(ranges.obs_min.numel(), recipe.hidden[0], batch_first=True)
        self.gru.__constants__ = []
        self.net = perceptron([*recipe.hidden, ranges.act_min.numel()])

    def forward(self, observations: Tensor, state: Tensor) -> Tuple[Tensor, Tensor]:
        y, state = self.gru(self.inputs_of(observations), state.unsqueeze(0))
        return self.actions_of(self.net(y)), state.squeeze(0)

    def provenance(self) -> Dict[str, str]:
        gru = f"GRU {self.gru.input_size}-{self.gru.hidden_size}"
        return {"architecture": f"{gru}, MLP {sizes_of(self.net)}, ReLU", "loss": ABSOLUTE_ERROR}

    def description(self) -> Dict[str, Any]:
        return {**super().description(), "state": {"shape": [self.gru.hidden_size]}}

    def examples(self, frames: Frames) -> Examples:
        return pieces(self.normalized(frames), PIECE)

    def loss(self, examples: Examples, generator: torch.Generator) -> Tensor:
        steps = torch.arange(int(examples.lengths.max()))
        counts = steps < examples.lengths.unsqueeze(1)
        outputs = self.net(self.gru(examples.inputs[:, : len(steps)])[0])
        return nn.functional.l1_loss(outputs[counts], examples.targets[:, : len(steps)][counts])


class Chunked(Described):
    """A network that answers some observations with some actions."""

    __jit_ignored_attributes__ = ["sizes", "interface"]

    def __init__(self, recipe: Recipe, ranges: Ranges) -> None:
        super().__init__(ranges)
        self.sizes = (1, 1, 1) if recipe.model == "mlp" else recipe.chunk
        self.interface = recipe.interface

    def description(self) -> Dict[str, Any]:
        sizes = dict(zip(("observations", "actions", "execute"), self.sizes))
        fields = INTERFACES[self.interface].fields(self.interface)
        return {**super().description(), **fields, **sizes}

    def examples(self, frames: Frames) -> Examples:
        return windows(self.normalized(frames), *self.sizes[:2])


class Chunk(Chunked):
    """Observations [n, H, 10] to actions [n, K, 2]."""

    def __init__(self, recipe: Recipe, ranges: Ranges) -> None:
        super().__init__(recipe, ranges)
        observations, self.actions, _ = self.sizes
        inputs, outputs = (
            observations * ranges.obs_min.numel(),
            self.actions * ranges.act_min.numel(),
        )
        self.net = perceptron([inputs, *recipe.hidden, outputs])

    def forward(self, observations: Tensor) -> Tensor:
        y = self.net(self.inputs_of(observations).flatten(1))
        return self.actions_of(y.unflatten(1, [self.actions, -1]))

    def provenance(self) -> Dict[str, str]:
        return {"architecture": f"MLP {sizes_of(self.net)}, ReLU", "loss": ABSOLUTE_ERROR}

    def loss(self, examples: Examples, generator: torch.Generator) -> Tensor:
        outputs = self.net(examples.inputs.flatten(1))
        return nn.functional.l1_loss(outputs, examples.targets.flatten(1))


class Flow(Chunked):
    """Observations [n, H, 10] and normal noise [n, K, 2] to actions [n, K, 2], by flow matching:
    the network gives the velocity that carries noise, at time 0, along a straight line to actions,
    at time 1, and Euler's steps follow it.

    Source: Y. Lipman et al., "Flow Matching for Generative Modeling" (2023).
    """

    def __init__(self, recipe: Recipe, ranges: Ranges) -> None:
        super().__init__(recipe, ranges)
        observations, actions, _ = self.sizes
        inputs, outputs = observations * ranges.obs_min.numel(), actions * ranges.act_min.numel()
        self.net = perceptron([inputs + outputs + 1, *recipe.hidden, outputs])
        self.steps = EULER_STEPS

    def forward(self, observations: Tensor, noise: Tensor) -> Tensor:
        x = self.inputs_of(observations).flatten(1)
        y = noise.flatten(1)
        time = torch.full_like(y[:, :1], -1.0)
        for step in range(self.steps):
            y = y + self.stride(torch.cat([x, y, time], 1), y, self.steps - step)
            time = time + 2.0 / self.steps
        return self.actions_of(y.clamp(-1.0, 1.0).reshape(noise.shape))

    def stride(self, inputs: Tensor, y: Tensor, left: int) -> Tensor:
        """Euler's step from y; so many are left, this one included."""
        return self.net(inputs) / self.steps

    def provenance(self) -> Dict[str, str]:
        return {
            "architecture": f"MLP {sizes_of(self.net)}, ReLU; {self.steps} Euler steps",
            "loss": "mean squared error of the velocity from noise to normalised actions",
        }

    def description(self) -> Dict[str, Any]:
        noise = {"shape": [self.sizes[1], 2], "distribution": "normal"}
        return {**super().description(), "noise": noise}

    def loss(self, examples: Examples, generator: torch.Generator) -> Tensor:
        x, actions = examples.inputs.flatten(1), examples.targets.flatten(1)
        noise = torch.randn(actions.shape, generator=generator)
        time = torch.rand((len(actions), 1), generator=generator)
        y = noise + time * (actions - noise)
        prediction = self.net(torch.cat([x, y, 2 * time - 1], 1))
        return nn.functional.mse_loss(prediction, self.target(actions, noise))

    def target(self, actions: Tensor, noise: Tensor) -> Tensor:
        """What the network predicts between noise and actions."""
        return actions - noise


class FlowToActions(Flow):
    """A flow whose network predicts the actions at its end (x-prediction) instead of the velocity.
    The last step goes to the prediction, so none of the noise is left in the actions.

    The loss is that of the actions: the velocity's, with the weight (1 - time)^2.
    """

    def provenance(self) -> Dict[str, str]:
        loss = "mean squared error of the normalised actions, predicted between noise and actions"
        return {**super().provenance(), "loss": loss}

    def stride(self, inputs: Tensor, y: Tensor, left: int) -> Tensor:
        return (self.net(inputs) - y) / left

    def target(self, actions: Tensor, noise: Tensor) -> Tensor:
        return actions


def plain(recipe: Recipe, ranges: Ranges) -> Model:
    """A network of one observation and one action; of another interface, with a description."""
    is_usual = recipe.interface == "full_circle"
    return Policy(recipe.hidden, ranges) if is_usual else Chunk(recipe, ranges)


MODELS: Mapping[str, Callable[[Recipe, Ranges], Model]] = {
    "mlp": plain,
    "gru": Recurrent,
    "chunk": Chunk,
    "flow": Flow,
    "flow_x": FlowToActions,
}
