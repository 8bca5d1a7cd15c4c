# SPDX-License-Identifier: BSD-3-Clause
"""The policy: a small MLP that carries its own normalization, and its archive."""

import io
import zipfile
from typing import Sequence, Tuple

import torch
from torch import Tensor, nn

ARCHIVE_TIME = (1980, 1, 1, 0, 0, 0)  # date of every file in a TorchScript archive
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


class Policy(nn.Module):
    """Observation [n, 10] or [10] in SI units to commanded pusher velocity [n, 2] or [2] in m/s."""

    obs_min: Tensor
    obs_range: Tensor
    act_min: Tensor
    act_range: Tensor

    def __init__(
        self,
        hidden: Sequence[int],
        obs_min: Tensor,
        obs_range: Tensor,
        act_min: Tensor,
        act_range: Tensor,
    ) -> None:
        super().__init__()
        self.register_buffer("obs_min", obs_min)
        self.register_buffer("obs_range", obs_range)
        self.register_buffer("act_min", act_min)
        self.register_buffer("act_range", act_range)
        self.net = nn.Sequential(
            nn.Linear(obs_min.numel(), hidden[0]),
            nn.ReLU(),
            nn.Linear(hidden[0], hidden[1]),
            nn.ReLU(),
            nn.Linear(hidden[1], act_min.numel()),
        )
        for layer in self.net:  # TorchScript writes constants in the order of a set, at random
            layer.__constants__ = []

    def forward(self, obs: Tensor) -> Tensor:
        """The order of these float32 operations is fixed: other programs repeat it."""
        x = normalised(obs, self.obs_min, self.obs_range).clamp(-1.0, 1.0)
        y = self.net(x)
        return (y + 1) / 2 * self.act_range + self.act_min


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
