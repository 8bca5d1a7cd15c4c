# SPDX-License-Identifier: BSD-3-Clause
"""Policies of gym-pusht in the shapes of LeRobot and Diffusion Policy, with random weights.

Written from the papers: C. Chi et al., "Diffusion Policy" (2023), its one-dimensional U-Net;
T. Zhao et al., "Learning Fine-Grained Bimanual Manipulation" (2023), ACT.
"""

import json
from typing import Any, Dict, Sequence, Tuple

import torch
from torch import Tensor, nn

SIDE = 512.0  # [px]
LEROBOT = {"interface": "gym_keypoints", "keypoints": 8, "agent": "first"}
DIFFUSION_POLICY = {"interface": "gym_keypoints", "keypoints": 9, "agent": "last"}


class Block(nn.Sequential):
    """Convolution over time, normalized in groups."""

    def __init__(self, inputs: int, outputs: int) -> None:
        convolution = nn.Conv1d(inputs, outputs, 5, padding=2)
        super().__init__(convolution, nn.GroupNorm(8, outputs), nn.Mish())


class Residual(nn.Module):
    """Two blocks that a condition scales and shifts."""

    def __init__(self, inputs: int, outputs: int, condition: int) -> None:
        super().__init__()
        self.first, self.second = Block(inputs, outputs), Block(outputs, outputs)
        self.film = nn.Sequential(nn.Mish(), nn.Linear(condition, 2 * outputs))
        self.around = nn.Conv1d(inputs, outputs, 1) if inputs != outputs else nn.Identity()

    def forward(self, x: Tensor, condition: Tensor) -> Tensor:
        scale, shift = self.film(condition).unsqueeze(-1).chunk(2, dim=1)
        return self.second(scale * self.first(x) + shift) + self.around(x)


class Unet(nn.Module):
    """Noise in a sequence of actions, given the observations and the step of the diffusion."""

    def __init__(self, condition: int, widths: Sequence[int], embedding: int) -> None:
        super().__init__()
        self.embedding = embedding
        self.of_step = nn.Sequential(
            nn.Linear(embedding, 4 * embedding), nn.Mish(), nn.Linear(4 * embedding, embedding)
        )
        condition += embedding
        ways = list(zip((2, *widths), widths))
        self.down = nn.ModuleList(Residual(a, b, condition) for a, b in ways)
        self.shorter = nn.ModuleList(nn.Conv1d(b, b, 3, 2, 1) for _, b in ways[:-1])
        self.middle = Residual(widths[-1], widths[-1], condition)
        back = list(zip(widths[:0:-1], widths[-2::-1]))
        self.up = nn.ModuleList(Residual(2 * a, b, condition) for a, b in back)
        self.longer = nn.ModuleList(nn.ConvTranspose1d(b, b, 4, 2, 1) for _, b in back)
        self.last = nn.Sequential(Block(widths[0], widths[0]), nn.Conv1d(widths[0], 2, 1))

    def forward(self, actions: Tensor, step: Tensor, observations: Tensor) -> Tensor:
        half = self.embedding // 2
        rates = torch.exp(torch.arange(half) * (-9.21 / (half - 1)))
        angles = step.reshape(-1, 1) * rates
        known = self.of_step(torch.cat([angles.sin(), angles.cos()], 1))
        condition = torch.cat([known, observations], 1)
        x = actions.transpose(1, 2)
        kept = []
        for i, residual in enumerate(self.down):
            x = residual(x, condition)
            kept.append(x)
            if i < len(self.shorter):
                x = self.shorter[i](x)
        x = self.middle(x, condition)
        for residual, longer in zip(self.up, self.longer):
            x = longer(residual(torch.cat([x, kept.pop()], 1), condition))
        return self.last(x).transpose(1, 2)


class Diffusion(nn.Module):
    """A diffusion policy as it is exported: normalization inside, noise as an input, the sampler
    (DDIM) unrolled, and the actions from the control step of the call on."""

    def __init__(self, numbers: int, widths: Sequence[int], steps: int = 10) -> None:
        super().__init__()
        self.unet = Unet(2 * numbers, widths, embedding=32)
        times = torch.linspace(0, 1, 101)
        kept = torch.cos((times + 0.008) / 1.008 * torch.pi / 2) ** 2
        self.steps = [int(step) for step in torch.linspace(99, 0, steps)]
        self.kept = (kept / kept[0])[1:].clamp(1e-4, 1.0)

    def forward(self, observations: Tensor, noise: Tensor) -> Tensor:
        seen = (observations / (SIDE / 2) - 1.0).flatten(1)
        actions = noise
        for number, step in enumerate(self.steps):
            kept = self.kept[step]
            last = number + 1 == len(self.steps)
            kept_next = torch.ones(()) if last else self.kept[self.steps[number + 1]]
            at = torch.full((1,), float(step)).expand(noise.shape[0])
            found = self.unet(actions, at, seen)
            clean = ((actions - (1 - kept).sqrt() * found) / kept.sqrt()).clamp(-1.0, 1.0)
            found = (actions - kept.sqrt() * clean) / (1 - kept).sqrt()
            actions = kept_next.sqrt() * clean + (1 - kept_next).sqrt() * found
        return (actions[:, 1:] + 1.0) * (SIDE / 2)


class Act(nn.Module):
    """A chunk of actions by a transformer that looks at each number that it sees."""

    def __init__(self, numbers: int, chunk: int, width: int) -> None:
        super().__init__()
        self.tokens = nn.Linear(1, width)
        self.places = nn.Parameter(torch.randn(numbers, width))
        self.queries = nn.Parameter(torch.randn(chunk, width))
        layer = nn.TransformerDecoderLayer(width, 4, 4 * width, dropout=0.0, batch_first=True)
        self.decoder = nn.TransformerDecoder(layer, 2)
        self.last = nn.Linear(width, 2)

    def forward(self, observations: Tensor) -> Tensor:
        seen = observations[:, 0] / (SIDE / 2) - 1.0
        tokens = self.tokens(seen.unsqueeze(-1)) + self.places
        queries = self.queries.expand(seen.shape[0], -1, -1)
        actions: Tensor = self.last(self.decoder(queries, tokens))
        return (torch.tanh(actions) + 1.0) * (SIDE / 2)


class Mlp(nn.Module):
    """Layers, for the kernel."""

    def __init__(self, numbers: int, chunk: int) -> None:
        super().__init__()
        self.chunk = chunk
        self.layers = nn.Sequential(nn.Linear(numbers, 64), nn.ReLU(), nn.Linear(64, 2 * chunk))

    def forward(self, observations: Tensor) -> Tensor:
        actions: Tensor = torch.tanh(self.layers(observations.flatten(1) / (SIDE / 2) - 1.0))
        return (actions.reshape(-1, self.chunk, 2) + 1.0) * (SIDE / 2)


class Seer(nn.Module):
    """A small residual network that looks at two images and the pusher, and answers with chunks:
    a module for Python, which gets what gym-pusht shows."""

    def __init__(self, width: int = 16, chunk: int = 8) -> None:
        super().__init__()
        self.chunk = chunk
        self.first = nn.Sequential(nn.Conv2d(3, width, 7, 4, 3), nn.ReLU())
        self.second = nn.Sequential(
            nn.Conv2d(width, width, 3, 1, 1), nn.ReLU(), nn.Conv2d(width, width, 3, 1, 1)
        )
        self.last = nn.Linear(2 * (width * 36 + 2), 2 * chunk)

    def forward(self, observation: Dict[str, Tensor]) -> Tensor:
        images, agent = observation["pixels"], observation["agent_pos"]
        rows, past = images.shape[:2]
        x = images.flatten(0, 1).permute(0, 3, 1, 2).float() / 255.0
        x = self.first(x)
        x = nn.functional.adaptive_avg_pool2d(torch.relu(x + self.second(x)), 6)
        seen = torch.cat([x.reshape(rows, past, -1), agent / (SIDE / 2) - 1.0], 2).flatten(1)
        return (torch.tanh(self.last(seen)).reshape(rows, self.chunk, 2) + 1.0) * (SIDE / 2)


def save(module: nn.Module, inputs: Tuple[Tensor, ...], path: str, **description: Any) -> None:
    """Traces a module and writes its description beside it."""
    traced = torch.jit.trace(module.eval(), inputs, check_trace=False)
    described = json.dumps({"format": 1, **description})
    torch.jit.save(traced, path, _extra_files={"policy.json": described})


def save_diffusion(
    path: str, numbers: int, widths: Sequence[int], interface: Dict[str, Any]
) -> None:
    """Two observations; fifteen actions, of which eight are executed."""
    torch.manual_seed(0)
    inputs = (torch.zeros(1, 2, numbers), torch.zeros(1, 16, 2))
    noise = {"shape": [16, 2], "distribution": "normal"}
    chunk = {"observations": 2, "actions": 15, "execute": 8}
    save(Diffusion(numbers, widths), inputs, path, **chunk, noise=noise, **interface)


def save_act(path: str, chunk: int, width: int) -> None:
    """One observation; a long chunk, all of which is executed."""
    torch.manual_seed(0)
    module = Act(18, chunk, width)
    save(module, (torch.zeros(1, 1, 18),), path, observations=1, actions=chunk, **LEROBOT)


def save_mlp(path: str, interface: Dict[str, Any], numbers: int, past: int, chunk: int) -> None:
    """A network of the kernel."""
    torch.manual_seed(0)
    module = Mlp(past * numbers, chunk)
    inputs = (torch.zeros(1, past, numbers),)
    save(module, inputs, path, observations=past, actions=chunk, **interface)
