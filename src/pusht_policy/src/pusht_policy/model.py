# SPDX-License-Identifier: BSD-3-Clause
"""Networks as policies that carry their own normalization, the plain one, and their archive."""

import io
import json
import zipfile
from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Tuple

import torch
from torch import Tensor, nn

from pusht_policy.frames import Examples, Frames, windows

DESCRIPTION = "policy.json"  # extra file of an archive: what the policy takes and answers
ARCHIVE_TIME = (1980, 1, 1, 0, 0, 0)  # date of every file in a TorchScript archive
SQUARED_ERROR = "mean squared error in normalised action space"
SMALLEST_RANGE = 1e-4  # a narrower range counts as 1, in the unit of the value


def minimum_and_range(values: Tensor) -> Tuple[Tensor, Tensor]:
    """Per-column minimum and range, each [d], of values [n, d]."""
    minimum = values.min(dim=0).values
    value_range = values.max(dim=0).values - minimum
    one = torch.ones_like(value_range)
    return minimum, torch.where(value_range < SMALLEST_RANGE, one, value_range)


def normalised(values: Tensor, minimum: Tensor, value_range: Tensor) -> Tensor:
    """Maps [minimum, minimum + value_range] to [-1, 1]. The order of operations is fixed, and so
    is the spelling of the name: it is in every archive."""
    return (values - minimum) * 2 / value_range - 1


class Ranges(NamedTuple):
    """Minima and ranges of the numbers in demonstrations, by column."""

    obs_min: Tensor  # [10]
    obs_range: Tensor
    act_min: Tensor  # [2]
    act_range: Tensor


def ranges_of(frames: Frames) -> Ranges:
    """Ranges of frames in SI units."""
    return Ranges(*minimum_and_range(frames.observations), *minimum_and_range(frames.actions))


class Model(nn.Module):
    """A network that carries its normalization, and what a training must know of it."""

    obs_min: Tensor
    obs_range: Tensor
    act_min: Tensor
    act_range: Tensor

    def __init__(self, ranges: Ranges) -> None:
        super().__init__()
        for name, value in ranges._asdict().items():
            self.register_buffer(name, value)

    def provenance(self) -> Dict[str, str]:
        """Architecture and loss in words."""
        raise NotImplementedError

    def description(self) -> Optional[Dict[str, Any]]:
        """What `policy.json` in a checkpoint says; none for one observation and one action."""
        raise NotImplementedError

    def examples(self, frames: Frames) -> Examples:
        """What the network learns from, of frames in SI units."""
        raise NotImplementedError

    def loss(self, examples: Examples, generator: torch.Generator) -> Tensor:
        """Mean over examples, in normalized action space. Noise is drawn from `generator`."""
        raise NotImplementedError

    def normalized(self, frames: Frames) -> Frames:
        """Frames in SI units as the network sees them: observations in [-1, 1], actions mapped
        likewise."""
        return Frames(
            normalised(frames.observations, self.obs_min, self.obs_range).clamp(-1.0, 1.0),
            normalised(frames.actions, self.act_min, self.act_range),
            frames.first,
            frames.last,
        )


def perceptron(sizes: Sequence[int]) -> nn.Sequential:
    """Linear layers between so many units, with ReLU between them."""
    layers: List[nn.Module] = []
    for inputs, outputs in zip(sizes, sizes[1:]):
        layers += [nn.Linear(inputs, outputs), nn.ReLU()]
    return without_constants(nn.Sequential(*layers[:-1]))


def without_constants(module: nn.Sequential) -> nn.Sequential:
    """A module whose archive has the same bytes each time: TorchScript writes the constants of a
    layer in the order of a set, at random."""
    for layer in module:
        layer.__constants__ = []
    return module


class Policy(Model):
    """Observation [n, 10] or [10] in SI units to commanded pusher velocity [n, 2] or [2] in m/s."""

    def __init__(self, hidden: Sequence[int], ranges: Ranges) -> None:
        super().__init__(ranges)
        self.net = perceptron([ranges.obs_min.numel(), *hidden, ranges.act_min.numel()])

    def forward(self, obs: Tensor) -> Tensor:
        """The order of these float32 operations is fixed: other programs repeat it."""
        x = normalised(obs, self.obs_min, self.obs_range).clamp(-1.0, 1.0)
        y = self.net(x)
        return (y + 1) / 2 * self.act_range + self.act_min

    def provenance(self) -> Dict[str, str]:
        return {"architecture": f"MLP {sizes_of(self.net)}, ReLU", "loss": SQUARED_ERROR}

    def description(self) -> Optional[Dict[str, Any]]:
        return None

    def examples(self, frames: Frames) -> Examples:
        return windows(self.normalized(frames), 1, 1)

    def loss(self, examples: Examples, generator: torch.Generator) -> Tensor:
        outputs = self.net(examples.inputs.flatten(1))
        return nn.functional.mse_loss(outputs, examples.targets.flatten(1))


def sizes_of(net: nn.Sequential) -> str:
    """Units of the layers of a perceptron: "10-512-512-2"."""
    layers = [layer for layer in net if isinstance(layer, nn.Linear)]
    sizes = [layers[0].in_features, *(layer.out_features for layer in layers)]
    return "-".join(map(str, sizes))


def torchscript_bytes(
    script: torch.jit.ScriptModule, description: Optional[Dict[str, Any]] = None
) -> bytes:
    """The archive of a module with its description, without its debug records: they hold local
    paths."""
    script.eval()
    extra = {} if description is None else {DESCRIPTION: json.dumps(description, indent=2) + "\n"}
    saved = io.BytesIO()
    torch.jit.save(script, saved, _extra_files=extra)
    stripped = io.BytesIO()
    with zipfile.ZipFile(saved) as source, zipfile.ZipFile(stripped, "w") as target:
        for info in source.infolist():
            if not info.filename.endswith(".debug_pkl"):
                record = zipfile.ZipInfo(info.filename, ARCHIVE_TIME)
                target.writestr(record, source.read(info))
    return stripped.getvalue()
