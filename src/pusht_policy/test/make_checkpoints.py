# SPDX-License-Identifier: BSD-3-Clause
"""Writes checkpoints as Python programs make them: make_checkpoints.py FOLDER"""

import pickle
import sys
from pathlib import Path

import torch
from torch import Tensor, nn

OBSERVATION = 10
ACTION = 2
HIDDEN = 48


class Normalized(nn.Module):
    """The course's policy: it carries its own normalization, raw observation in, raw action out."""

    def __init__(self, net: nn.Module) -> None:
        super().__init__()
        self.net = net
        self.register_buffer("obs_min", -0.5 - torch.rand(OBSERVATION))
        self.register_buffer("obs_range", 1.0 + torch.rand(OBSERVATION))
        self.register_buffer("act_min", -1.0 - torch.rand(ACTION))
        self.register_buffer("act_range", 2.0 + torch.rand(ACTION))

    def forward(self, obs: Tensor) -> Tensor:
        x = (obs - self.obs_min) * 2 / self.obs_range - 1
        y = self.net(x.clamp(-1.0, 1.0))
        return (y + 1) / 2 * self.act_range + self.act_min


class TakesSingleRows(Normalized):
    """A module that branches on the number of dimensions."""

    def forward(self, obs: Tensor) -> Tensor:
        if obs.dim() == 1:
            obs = obs.unsqueeze(0)
        return self.net(obs)


class Residual(nn.Module):
    def __init__(self) -> None:
        super().__init__()
        self.first = nn.Linear(OBSERVATION, HIDDEN)
        self.second = nn.Linear(HIDDEN, HIDDEN)
        self.last = nn.Linear(HIDDEN, ACTION)

    def forward(self, obs: Tensor) -> Tensor:
        x = torch.relu(self.first(obs))
        return self.last(x + torch.relu(self.second(x)))


class EndlessToLoad(nn.Module):
    @torch.jit.export  # type: ignore[misc]
    def __getstate__(self) -> int:
        return 1

    @torch.jit.export  # type: ignore[misc]
    def __setstate__(self, state: int) -> None:
        while state > 0:
            state = state % 2 + 1
        self.training = False

    def forward(self, obs: Tensor) -> Tensor:
        return obs[:, :2]


class EndlessToAct(nn.Module):
    def forward(self, obs: Tensor) -> Tensor:
        count = 1
        while count > 0:
            count = count % 2 + 1
        return obs[:, :2]


def perceptron(activation: type = nn.ReLU) -> nn.Module:
    return nn.Sequential(
        nn.Linear(OBSERVATION, HIDDEN),
        activation(),
        nn.Linear(HIDDEN, HIDDEN),
        activation(),
        nn.Linear(HIDDEN, ACTION),
    )


def with_extras() -> nn.Module:
    return nn.Sequential(
        nn.Linear(OBSERVATION, HIDDEN),
        nn.ReLU6(),
        nn.Dropout(0.1),
        nn.Linear(HIDDEN, HIDDEN, bias=False),
        nn.Hardtanh(),
        nn.Identity(),
        nn.Linear(HIDDEN, ACTION),
        nn.Tanh(),
    )


def layer_norm() -> nn.Module:
    return nn.Sequential(
        nn.Linear(OBSERVATION, HIDDEN), nn.LayerNorm(HIDDEN), nn.ReLU(), nn.Linear(HIDDEN, ACTION)
    )


def main() -> None:
    folder = Path(sys.argv[1])
    torch.manual_seed(0)
    modules = {
        "course": Normalized(perceptron()),
        "single_rows": TakesSingleRows(perceptron()),
        "extras": Normalized(with_extras()),
        "residual": Residual(),
        "layer_norm": Normalized(layer_norm()),
        "gelu": Normalized(perceptron(nn.GELU)),
    }
    for name, module in modules.items():
        module.eval()
        torch.jit.script(module).save(str(folder / f"{name}_scripted.pt"))
        torch.jit.trace(module, torch.zeros(1, OBSERVATION)).save(str(folder / f"{name}_traced.pt"))
    for name, module in {"to_load": EndlessToLoad(), "to_act": EndlessToAct()}.items():
        torch.jit.script(module.eval()).save(str(folder / f"endless_{name}.pt"))
    course = modules["course"]
    torch.jit.freeze(torch.jit.script(course)).save(str(folder / "course_frozen.pt"))
    torch.save(course.state_dict(), folder / "state_dict.pt")
    torch.save(
        course.state_dict(), folder / "legacy_state_dict.pt", _use_new_zipfile_serialization=False
    )
    torch.save(course, folder / "pickled_module.pt")
    (folder / "pickle.pt").write_bytes(pickle.dumps({"weight": [1.0, 2.0]}))


if __name__ == "__main__":
    main()
