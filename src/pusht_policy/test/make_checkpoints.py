# SPDX-License-Identifier: BSD-3-Clause
"""Writes checkpoints as Python programs make them: make_checkpoints.py FOLDER"""

import json
import pickle
import sys
from pathlib import Path
from typing import Any, Callable, Dict, Tuple

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


class Gated(nn.Module):
    """Two paths, one of which gates the other; parts of the observation go round both."""

    def __init__(self) -> None:
        super().__init__()
        self.first = nn.Linear(OBSERVATION, 2 * HIDDEN)
        self.norm = nn.LayerNorm(HIDDEN + 4)
        self.last = nn.Linear(HIDDEN + 4, ACTION)

    def forward(self, obs: Tensor) -> Tensor:
        value, gate = self.first(obs).chunk(2, dim=-1)
        x = torch.cat([value * torch.sigmoid(gate), obs[:, :2], obs[:, 6:8] / 3.0], dim=-1)
        return self.last(self.norm(x)) + 0.1 * (obs[:, 2:4] - obs[:, 0:2])


class TwoHeads(nn.Module):
    """The actor of SB3's SAC with its mean alone, and a second head that scales it."""

    def __init__(self) -> None:
        super().__init__()
        self.latent = nn.Sequential(nn.Linear(OBSERVATION, HIDDEN), nn.ELU())
        self.mean = nn.Linear(HIDDEN, ACTION)
        self.scale = nn.Linear(HIDDEN, 1)

    def forward(self, obs: Tensor) -> Tensor:
        latent = self.latent(obs)
        scale = torch.exp(self.scale(latent).clamp(-5.0, 2.0))
        return torch.tanh(self.mean(latent)) * scale


class Cosine(nn.Module):
    def forward(self, obs: Tensor) -> Tensor:
        return torch.cos(obs[:, :2])


class GruMemory(nn.Module):
    def __init__(self) -> None:
        super().__init__()
        self.cell = nn.GRUCell(OBSERVATION, HIDDEN)
        self.head = nn.Linear(HIDDEN, ACTION)

    def forward(self, obs: Tensor, state: Tensor) -> Tuple[Tensor, Tensor]:
        hidden = self.cell(obs[:, -1], state)
        return self.head(hidden).unsqueeze(1), hidden


class LstmMemory(nn.Module):
    """Its state has the hidden state and the cell state."""

    def __init__(self) -> None:
        super().__init__()
        self.cell = nn.LSTMCell(OBSERVATION, HIDDEN)
        self.head = nn.Linear(HIDDEN, ACTION)

    def forward(self, obs: Tensor, state: Tensor) -> Tuple[Tensor, Tensor]:
        hidden, memory = self.cell(obs[:, -1], (state[:, 0], state[:, 1]))
        return self.head(hidden).unsqueeze(1), torch.stack([hidden, memory], dim=1)


class LongMemory(nn.Module):
    """Two layers of nn.LSTM over a history of three observations."""

    def __init__(self) -> None:
        super().__init__()
        self.lstm = nn.LSTM(OBSERVATION, HIDDEN, num_layers=2, batch_first=True)
        self.head = nn.Linear(HIDDEN, ACTION)

    def forward(self, obs: Tensor, state: Tensor) -> Tuple[Tensor, Tensor]:
        hidden, memory = state[:, 0].transpose(0, 1), state[:, 1].transpose(0, 1)
        y, after = self.lstm(obs, (hidden.contiguous(), memory.contiguous()))
        both = torch.stack([after[0].transpose(0, 1), after[1].transpose(0, 1)], dim=1)
        return self.head(y[:, -1:]), both


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


class OfOneObservation(nn.Module):
    """A plain policy behind the signature of histories and chunks."""

    def __init__(self, policy: nn.Module) -> None:
        super().__init__()
        self.policy = policy

    def forward(self, obs: Tensor) -> Tensor:
        return self.policy(obs.flatten(1)).unsqueeze(1)


class Chunks(nn.Module):
    """Two observations in, eight actions out; normalization of each number in their own shapes."""

    def __init__(self) -> None:
        super().__init__()
        self.net = nn.Sequential(
            nn.Linear(2 * OBSERVATION, HIDDEN), nn.ReLU(), nn.Linear(HIDDEN, 8 * ACTION)
        )
        self.register_buffer("obs_scale", 1.0 + torch.rand(OBSERVATION))
        self.register_buffer("obs_shift", torch.rand(2, OBSERVATION))
        self.register_buffer("act_scale", 1.0 + torch.rand(ACTION))

    def forward(self, obs: Tensor) -> Tensor:
        x = obs * self.obs_scale - self.obs_shift
        y = self.net(x.reshape(x.shape[0], -1))
        return y.view(y.shape[0], -1, 2) * self.act_scale


class Recurrent(nn.Module):
    """A GRU. Without `memory` its recurrent weights are 0, and its gate lets no old state by."""

    def __init__(self, memory: bool) -> None:
        super().__init__()
        self.gru = nn.GRU(OBSERVATION, HIDDEN)
        self.head = nn.Linear(HIDDEN, ACTION)
        if not memory:
            with torch.no_grad():
                weights = dict(self.gru.named_parameters())
                weights["weight_hh_l0"].zero_()
                weights["bias_hh_l0"].zero_()
                weights["bias_ih_l0"][HIDDEN : 2 * HIDDEN] = -200.0  # sigmoid: 0 in float32

    def forward(self, obs: Tensor, state: Tensor) -> Tuple[Tensor, Tensor]:
        y, state = self.gru(obs.transpose(0, 1), state.unsqueeze(0))
        return self.head(y).transpose(0, 1), state.squeeze(0)


class FeedForwardTwin(nn.Module):
    """What a GRU without memory computes, as a plain policy."""

    def __init__(self, recurrent: Recurrent) -> None:
        super().__init__()
        weights = dict(recurrent.gru.named_parameters())
        self.weight = weights["weight_ih_l0"]
        self.bias = weights["bias_ih_l0"]
        self.head = recurrent.head

    def forward(self, obs: Tensor) -> Tensor:
        gates = nn.functional.linear(obs, self.weight, self.bias)
        return self.head(torch.tanh(gates.chunk(3, 1)[2]))


class Denoising(nn.Module):
    """A small flow: noise of the shape of the chunk, pushed along in a few steps."""

    def __init__(self) -> None:
        super().__init__()
        self.net = nn.Sequential(
            nn.Linear(2 * OBSERVATION + 8 * ACTION, HIDDEN),
            nn.Tanh(),
            nn.Linear(HIDDEN, 8 * ACTION),
        )

    def forward(self, obs: Tensor, noise: Tensor) -> Tensor:
        x = noise.flatten(1)
        for _ in range(4):
            x = x + 0.25 * self.net(torch.cat([obs.flatten(1), x], 1))
        return x.view(-1, 8, 2)


def recurrent() -> Dict[str, nn.Module]:
    return {
        "gru_cell": GruMemory(),
        "lstm_cell": LstmMemory(),
        "lstm_layers": LongMemory(),
    }


def perceptron(activation: Callable[[], nn.Module] = nn.ReLU) -> nn.Module:
    return nn.Sequential(
        nn.Linear(OBSERVATION, HIDDEN),
        activation(),
        nn.Linear(HIDDEN, HIDDEN),
        activation(),
        nn.Linear(HIDDEN, ACTION),
    )


def activations() -> Dict[str, nn.Module]:
    functions: Dict[str, Callable[[], nn.Module]] = {
        "gelu": nn.GELU,
        "gelu_tanh": lambda: nn.GELU(approximate="tanh"),
        "elu": nn.ELU,
        "silu": nn.SiLU,
        "mish": nn.Mish,
        "selu": nn.SELU,
        "softplus": lambda: nn.Softplus(beta=2),
        "leaky_relu": nn.LeakyReLU,
        "prelu": nn.PReLU,
        "hardswish": nn.Hardswish,
        "hardsigmoid": nn.Hardsigmoid,
    }
    return {name: Normalized(perceptron(function)) for name, function in functions.items()}


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


def batch_norm() -> nn.Module:
    net = nn.Sequential(
        nn.Linear(OBSERVATION, HIDDEN),
        nn.BatchNorm1d(HIDDEN),
        nn.ReLU(),
        nn.Linear(HIDDEN, ACTION),
    )
    net(torch.randn(64, OBSERVATION))  # statistics of its own
    return net


def save_training(folder: Path) -> None:
    """Networks traced as they are trained."""
    for name, net in {"dropout": with_extras(), "batch_norm": batch_norm()}.items():
        traced = torch.jit.trace(net.train(), torch.zeros(2, OBSERVATION), check_trace=False)
        traced.save(str(folder / f"{name}_training.pt"))


def save(module: nn.Module, path: Path, **description: Any) -> None:
    """A module with its description."""
    text = json.dumps({"format": 1, **description})
    torch.jit.save(torch.jit.script(module.eval()), str(path), _extra_files={"policy.json": text})


def save_described(folder: Path, course: nn.Module) -> None:
    save(OfOneObservation(course), folder / "wrapped.pt", observations=1, actions=1)
    chunks = Chunks()
    save(chunks, folder / "chunks.pt", observations=2, actions=8, execute=4)
    torch.jit.save(
        torch.jit.trace(chunks, torch.zeros(1, 2, OBSERVATION)),
        str(folder / "chunks_traced.pt"),
        _extra_files={"policy.json": '{"format": 1, "observations": 2, "actions": 8}'},
    )
    of_gru = {"observations": 1, "actions": 1, "state": {"shape": [HIDDEN]}}
    save(Recurrent(memory=True), folder / "gru.pt", **of_gru)
    still = Recurrent(memory=False)
    save(still, folder / "gru_still.pt", **of_gru)
    torch.jit.script(FeedForwardTwin(still)).save(str(folder / "gru_twin.pt"))
    for name, module in recurrent().items():
        shape = (
            [2, 2, HIDDEN] if name == "lstm_layers" else [2, HIDDEN] if "lstm" in name else [HIDDEN]
        )
        of = {"observations": 3, "actions": 1, "state": {"shape": shape}}
        save(module, folder / f"{name}_scripted.pt", **of)
        example = (torch.zeros(1, 3, OBSERVATION), torch.zeros(1, *shape))
        torch.jit.save(
            torch.jit.trace(module.eval(), example),
            str(folder / f"{name}_traced.pt"),
            _extra_files={"policy.json": json.dumps({"format": 1, **of})},
        )
    noise = {"shape": [8, ACTION], "distribution": "normal"}
    save(Denoising(), folder / "denoising.pt", observations=2, actions=8, execute=4, noise=noise)


def main() -> None:
    folder = Path(sys.argv[1])
    torch.manual_seed(0)
    modules = {
        "course": Normalized(perceptron()),
        "single_rows": TakesSingleRows(perceptron()),
        "extras": Normalized(with_extras()),
        "residual": Residual(),
        "layer_norm": Normalized(layer_norm()),
        "batch_norm": Normalized(batch_norm()),
        "gated": Gated(),
        "two_heads": TwoHeads(),
        "cosine": Cosine(),
        **activations(),
    }
    for name, module in modules.items():
        module.eval()
        torch.jit.script(module).save(str(folder / f"{name}_scripted.pt"))
        torch.jit.trace(module, torch.zeros(1, OBSERVATION)).save(str(folder / f"{name}_traced.pt"))
    for name, module in {"to_load": EndlessToLoad(), "to_act": EndlessToAct()}.items():
        torch.jit.script(module.eval()).save(str(folder / f"endless_{name}.pt"))
    save_training(folder)
    course = modules["course"]
    save_described(folder, course)
    torch.jit.freeze(torch.jit.script(course)).save(str(folder / "course_frozen.pt"))
    torch.save(course.state_dict(), folder / "state_dict.pt")
    torch.save(
        course.state_dict(), folder / "legacy_state_dict.pt", _use_new_zipfile_serialization=False
    )
    torch.save(course, folder / "pickled_module.pt")
    (folder / "pickle.pt").write_bytes(pickle.dumps({"weight": [1.0, 2.0]}))


if __name__ == "__main__":
    main()
